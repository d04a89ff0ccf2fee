//! `motionctl jog --drives zlac`: turns one wheel a little, by hand.

use std::process::ExitCode;

use super::bus::Bus;
use super::error::HubError;
use super::look::Look;
use super::nodes::OneNode;
use super::own_move::{self, OwnMove, Target};
use crate::confirm::confirm;
use crate::counted::counted;
use crate::interrupt;
use crate::link::LinkOptions;
use crate::output::tell;

/// A jog is for looking whether a wheel turns and which way round. More is for `speed` and `run`.
const MOST_TURNS: f64 = 10.0;
const MOST_RPM: u16 = 200;

const EXAMPLES: &str = "\
Examples:
  motionctl jog --drives zlac --slcan /dev/ttyACM0 --turns 0.25
  motionctl jog --drives zlac:5 --can can0 --turns -1 --rpm 30 --yes

One move in position mode, with the drive's own profile. The drive is enabled for it and switched off afterwards: a vehicle on a slope
rolls away then. Ctrl-C stops by quick stop and ends the same way. Let the wheel hang free of the ground.

Exit status: 0 the wheel stands where it should, 1 it does not, or did not confirm that its power is off, 2 not confirmed, enabled
already, or out of range, and nothing has moved, 3 the link failed, 130 stopped by Ctrl-C.";

/// Options of `motionctl jog --drives zlac`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(super) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    node: OneNode,
    /// Turns of the wheel, positive as its drive counts; at most 10 either way.
    #[arg(long, value_name = "TURNS", allow_hyphen_values = true, value_parser = turns)]
    turns: f64,
    /// Highest speed in r/min, at most 200.
    #[arg(long, value_name = "RPM", default_value_t = 30, value_parser = clap::value_parser!(u16).range(1..=i64::from(MOST_RPM)))]
    rpm: u16,
    /// Fastest change of the speed in r/min per second.
    #[arg(long, value_name = "RPM_PER_S", default_value = "200", value_parser = acceleration)]
    max_acceleration: f64,
    /// Move without asking.
    #[arg(long)]
    yes: bool,
    /// Print where the jog has led as JSON.
    #[arg(long)]
    json: bool,
}

/// Asks, moves, prints where the jog has led.
pub(super) fn run(arguments: &Arguments) -> Result<ExitCode, HubError> {
    let node = arguments.node.get()?;
    let mut bus = Bus::open(&arguments.link)?;
    let look = Look::at(&mut bus, node)?;
    let question = format!(
        "The wheel of node {node} will TURN, powered, by {} at up to {} r/min and {} r/min per second. Is everybody clear, and does it hang free?",
        counted(arguments.turns, "turn", "turns"),
        arguments.rpm,
        arguments.max_acceleration
    );
    confirm(&question, arguments.yes).map_err(HubError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(HubError::Interrupt)?;
    if !arguments.json {
        tell(format_args!(
            "node {node} is being enabled and moved; Ctrl-C stops it"
        ));
    }
    let wanted = OwnMove {
        to: Target::By((arguments.turns * look.counts_per_turn).round() as i32),
        rpm: arguments.rpm,
        rpm_per_s: arguments.max_acceleration,
    };
    own_move::run(&mut bus, &look, wanted, arguments.json)
}

fn turns(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(turns) if turns.abs() <= MOST_TURNS && turns != 0.0 => Ok(turns),
        _ => Err(format!(
            "must be -{MOST_TURNS}..={MOST_TURNS} turns and not 0, got {text}"
        )),
    }
}

/// A change of speed in r/min per second that a ramp of the drive can make.
pub(super) fn acceleration(text: &str) -> Result<f64, String> {
    const LEAST: f64 = 31.0;
    const MOST: f64 = 10_000.0;
    match text.parse::<f64>() {
        Ok(rpm_per_s) if (LEAST..=MOST).contains(&rpm_per_s) => Ok(rpm_per_s),
        _ => Err(format!(
            "must be {LEAST}..={MOST} r/min per second, got {text}"
        )),
    }
}
