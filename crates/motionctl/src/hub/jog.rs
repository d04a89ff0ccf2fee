//! `motionctl jog --drives zlac`: turns one wheel a little, by hand.

use std::path::PathBuf;
use std::process::ExitCode;

use super::bus::Bus;
use super::error::HubError;
use super::home::life;
use super::look::Look;
use super::nodes::OneNode;
use super::own_move::{self, OwnMove, Target};
use crate::confirm::confirm;
use crate::counted::counted;
use crate::home::HomeError;
use crate::interrupt;
use crate::link::LinkOptions;
use crate::origins::Origins;

/// A jog is for looking whether a wheel turns and which way round. More is for `speed` and `run`.
const MOST_TURNS: f64 = 10.0;
const MOST_PLACE_TURNS: f64 = 1_000.0;
const MOST_RPM: u16 = 200;

const EXAMPLES: &str = "\
Examples:
  motionctl jog --drives zlac --slcan /dev/ttyACM0 --turns 0.25
  motionctl jog --drives zlac:5 --can can0 --turns -1 --rpm 30 --yes
  motionctl jog --drives zlac --can can0 --to 0 --origins machine.toml      to the zero of an axis that was homed

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
    #[arg(long, value_name = "TURNS", allow_hyphen_values = true, value_parser = turns, required_unless_present = "to", conflicts_with = "to")]
    turns: Option<f64>,
    /// Where to, in turns from the zero of the axis in --origins; at most 10 turns away.
    #[arg(long, value_name = "TURNS", allow_hyphen_values = true, value_parser = place, requires = "origins")]
    to: Option<f64>,
    /// File of software origins that `motionctl home` wrote: the axis stays within its travel, and --to is possible.
    #[arg(long, value_name = "FILE.toml")]
    origins: Option<PathBuf>,
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
    let counts = way(arguments, &mut bus, &look)?;
    let turns = f64::from(counts) / look.counts_per_turn.max(1.0);
    let question = format!(
        "The wheel of node {node} will TURN, powered, by {} at up to {} r/min and {} r/min per second. Is everybody clear, and does it hang free?",
        counted((turns * 1e4).round() / 1e4, "turn", "turns"),
        arguments.rpm,
        arguments.max_acceleration
    );
    confirm(&question, arguments.yes).map_err(HubError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(HubError::Interrupt)?;
    let wanted = OwnMove {
        to: Target::By(counts),
        rpm: arguments.rpm,
        rpm_per_s: arguments.max_acceleration,
    };
    own_move::run(&mut bus, &look, wanted, arguments.json)
}

/// Counts to go, within the travel of an axis that was homed.
fn way(arguments: &Arguments, bus: &mut Bus, look: &Look) -> Result<i32, HubError> {
    let counts = |turns: f64| (turns * look.counts_per_turn).round() as i32;
    let Some(path) = &arguments.origins else {
        return Ok(counts(arguments.turns.unwrap_or_default()));
    };
    let life = life(bus, look.node, look.counts_per_turn)?;
    let origins = Origins::read(path).map_err(HomeError::Origins)?;
    let wheel = origins.wheel(look.node.get(), &life);
    let frame = wheel.map_err(HomeError::Origins)?.frame();
    let present = frame.to_axis(life.position_counts);
    let target = match arguments.to {
        Some(turns) => i64::from(counts(turns)),
        None => present + i64::from(counts(arguments.turns.unwrap_or_default())),
    };
    let in_turns = |counts: i64| counts as f64 / look.counts_per_turn.max(1.0);
    let travel = frame.travel();
    if !travel.contains(target) {
        return Err(HubError::Input(format!(
            "the axis must stay within {:.4}..={:.4} turns, as {} says, it would go to {:.4}. Nothing has moved",
            in_turns(travel.min_counts.into()),
            in_turns(travel.max_counts.into()),
            path.display(),
            in_turns(target)
        )));
    }
    let go = target - present;
    if in_turns(go).abs() > MOST_TURNS {
        return Err(HubError::Input(format!(
            "a jog goes at most {MOST_TURNS} turns, it would go {:.4}. Nothing has moved",
            in_turns(go)
        )));
    }
    // At most ten turns.
    Ok(go as i32)
}

fn place(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(turns) if turns.abs() <= MOST_PLACE_TURNS => Ok(turns),
        _ => Err(format!(
            "must be -{MOST_PLACE_TURNS}..={MOST_PLACE_TURNS} turns, got {text}"
        )),
    }
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
