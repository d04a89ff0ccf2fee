//! `motionctl move --drives zlac`: one move of one wheel, to a position or by a way.

use std::process::ExitCode;

use super::bus::Bus;
use super::error::HubError;
use super::jog::acceleration;
use super::look::Look;
use super::nodes::OneNode;
use super::own_move::{self, OwnMove, Target};
use crate::confirm::confirm;
use crate::interrupt;
use crate::link::LinkOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl move --drives zlac --slcan /dev/ttyACM0 --to 0                  back to where it counts 0
  motionctl move --drives zlac:5 --can can0 --by -40960 --rpm 60 --yes      ten turns back, with 4096 counts a turn

One move in position mode, with the drive's own profile; a way is made of an absolute target, so that no lost frame doubles it. The move
is over when the wheel stands within 0.005 turns of its target for 0.2 s, or 5 s after the time of its profile. The drive is enabled for it and
switched off afterwards: a vehicle on a slope rolls away then. Ctrl-C stops by quick stop and ends the same way.

Exit status: 0 the wheel stands where it should, 1 it does not, or did not confirm that its power is off, 2 not confirmed, enabled
already, or out of range, and nothing has moved, 3 the link failed, 130 stopped by Ctrl-C.";

/// Options of `motionctl move --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    node: OneNode,
    #[command(flatten)]
    target: TargetOptions,
    /// Highest speed in r/min, at most 1000.
    #[arg(long, value_name = "RPM", default_value_t = 30, value_parser = clap::value_parser!(u16).range(1..=1_000))]
    rpm: u16,
    /// Fastest change of the speed in r/min per second.
    #[arg(long, value_name = "RPM_PER_S", default_value = "200", value_parser = acceleration)]
    max_acceleration: f64,
    /// Move without asking.
    #[arg(long)]
    yes: bool,
    /// Print where the move has led as JSON.
    #[arg(long)]
    json: bool,
}

/// One of the two kinds of targets.
#[derive(Debug, Clone, Copy, clap::Args)]
#[group(required = true, multiple = false)]
struct TargetOptions {
    /// Position in counts, as the drive counts it.
    #[arg(long, value_name = "COUNTS", allow_hyphen_values = true)]
    to: Option<i32>,
    /// Way in counts, positive as the drive counts.
    #[arg(long, value_name = "COUNTS", allow_hyphen_values = true)]
    by: Option<i32>,
}

/// Asks, moves, prints where the move has led.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let node = arguments.node.get()?;
    let (to, words) = match arguments.target {
        TargetOptions {
            to: Some(counts), ..
        } => (Target::To(counts), format!("to {counts}")),
        TargetOptions { by, .. } => {
            let counts = by.unwrap_or_default();
            (Target::By(counts), format!("by {counts}"))
        }
    };
    let mut bus = Bus::open(&arguments.link)?;
    let look = Look::at(&mut bus, node)?;
    let question = format!(
        "The wheel of node {node} will TURN, powered, {words} counts ({} a turn) at up to {} r/min and {} r/min per second. Is everybody clear, and is the way free?",
        look.counts_per_turn, arguments.rpm, arguments.max_acceleration
    );
    confirm(&question, arguments.yes).map_err(HubError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(HubError::Interrupt)?;
    let wanted = OwnMove {
        to,
        rpm: arguments.rpm,
        rpm_per_s: arguments.max_acceleration,
    };
    own_move::run(&mut bus, &look, wanted, arguments.json)
}
