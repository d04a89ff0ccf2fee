//! `motionctl jog`: turns one motor a little, by hand.

mod way;

use std::path::PathBuf;
use std::process::ExitCode;

use dyn_can::{GearNumber, StoredDriveId};

use crate::confirm::confirm;
use crate::counted::counted;
use crate::drive_ids::stored_id;
use crate::drives::{DrivesError, DrivesOptions, Jog, JogEnd};
use crate::exit;
use crate::interrupt;
use crate::output::{print as print_line, print_json, tell};
use crate::station::{AxisOptions, MotionLimits};

/// A jog is for looking whether a motor turns and which way round. More is for `run`.
const MOST_TURNS: f64 = 10.0;
const MOST_PLACE_TURNS: f64 = 1_000.0;
const MOST_RPM: f64 = 300.0;
const MOST_RPM_PER_S: f64 = 100_000.0;

const EXAMPLES: &str = "\
Examples:
  motionctl jog --slcan /dev/ttyACM0 --drive 3 --turns 0.25
  motionctl jog --can can0 --drive 3 --turns -1 --rpm 120 --yes
  motionctl jog --serial /dev/ttyUSB0 --drive 3 --turns 0.25 --rpm 300
  motionctl jog --slcan /dev/ttyACM0 --drive 3 --to 0 --origins machine.toml     to the zero of an axis that was homed

The motor turns on a smooth profile that reaches --rpm in its middle, or less where --max-acceleration allows no more.
A drive that is disabled is enabled for it and disabled afterwards: a vertical axis without a brake falls then. One
that is enabled stays enabled. Ctrl-C slows down and ends the same way. Over --serial a drive that is enabled already makes one built-in move,
whose speed comes from its own parameters: it is refused where that is more than --rpm.

Exit status: 0 the motor went where it should, 1 it did not, or the drive did not confirm that it is disabled, 2 not
confirmed, refused as too fast, or another gear number, and nothing has moved, 3 the link failed or stood still, 130 stopped by Ctrl-C.";

/// Options of `motionctl jog`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    drives: DrivesOptions,
    #[command(flatten)]
    axes: AxisOptions,
    /// Id of the drive; over --serial also 0, a drive that was never given one.
    #[arg(long, value_name = "ID", value_parser = stored_id)]
    drive: StoredDriveId,
    /// Motor turns, positive clockwise; at most 10 either way.
    #[arg(long, value_name = "TURNS", allow_hyphen_values = true, value_parser = turns, required_unless_present = "to", conflicts_with = "to")]
    turns: Option<f64>,
    /// Where to, in motor turns from the zero of the axis in --origins; at most 10 turns away.
    #[arg(long, value_name = "TURNS", allow_hyphen_values = true, value_parser = place, requires = "origins")]
    to: Option<f64>,
    /// File of software origins that `motionctl home` wrote: the axis stays within its travel, and --to is possible.
    #[arg(long, value_name = "FILE.toml", conflicts_with = "serial")]
    origins: Option<PathBuf>,
    /// Highest speed in rpm, at most 300.
    #[arg(long, value_name = "RPM", default_value = "60", value_parser = rpm)]
    rpm: f64,
    /// Fastest change of the speed in r/min per second; also of the ramp with which Ctrl-C stops.
    #[arg(long, value_name = "RPM_PER_S", default_value = "1000", value_parser = acceleration, conflicts_with = "serial")]
    max_acceleration: f64,
    /// Gear number that the drive must have, 500..=16384. Default: the one that it reports.
    #[arg(long, value_name = "NUMBER", value_parser = gear_number, conflicts_with = "serial")]
    gear_number: Option<GearNumber>,
    /// Move without asking.
    #[arg(long)]
    yes: bool,
    /// Print where the jog has led as JSON.
    #[arg(long)]
    json: bool,
}

/// Asks, moves, prints where the jog has led.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let mut drives = arguments
        .drives
        .open(arguments.axes)
        .map_err(DrivesError::Open)?;
    let turns = &way::turns(arguments, drives.as_mut())?;
    let Arguments {
        drive,
        rpm,
        max_acceleration,
        ..
    } = arguments;
    let question = format!(
        "The motor of drive {drive} will TURN, powered, by {} at up to {rpm} r/min and {max_acceleration} r/min per second. Is everybody clear of the machine?",
        counted(*turns, "turn", "turns")
    );
    confirm(&question, arguments.yes).map_err(DrivesError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(DrivesError::Interrupt)?;
    if !arguments.json {
        tell(format_args!(
            "drive {drive} is being enabled and moved, at up to {rpm} r/min and {max_acceleration} r/min per second; Ctrl-C stops it"
        ));
    }
    let jog = Jog {
        turns: *turns,
        rpm: *rpm,
        limits: MotionLimits::of_jog(*rpm, *max_acceleration),
        gear: arguments.gear_number,
    };
    let end = drives.jog(*drive, jog)?;
    print(arguments, &end)?;
    Ok(match end {
        JogEnd {
            interrupted: true, ..
        } => exit::INTERRUPTED.into(),
        _ if end.sent_counts == end.asked_counts => ExitCode::SUCCESS,
        _ => exit::BROKEN_PROMISE.into(),
    })
}

fn print(arguments: &Arguments, end: &JogEnd) -> Result<(), DrivesError> {
    if arguments.json {
        print_json(end).map_err(DrivesError::Print)?;
        return Ok(());
    }
    let read = end.read_counts.map_or_else(
        || "reports no position".to_owned(),
        |counts| format!("reports {counts}"),
    );
    let stopped = if end.interrupted {
        ", stopped by the user"
    } else {
        ""
    };
    let state = if end.enabled {
        "stays enabled, as it was before"
    } else {
        "is disabled"
    };
    print_line(format_args!(
        "asked for {}, sent {}{stopped}; drive {} {read} and {state}",
        counted(end.asked_counts, "count", "counts"),
        end.sent_counts,
        arguments.drive
    ))
    .map_err(DrivesError::Print)?;
    Ok(())
}

fn turns(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(turns) if turns.abs() <= MOST_TURNS && turns != 0.0 => Ok(turns),
        _ => Err(format!(
            "must be -{MOST_TURNS}..={MOST_TURNS} turns and not 0, got {text}"
        )),
    }
}

fn place(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(turns) if turns.abs() <= MOST_PLACE_TURNS => Ok(turns),
        _ => Err(format!(
            "must be -{MOST_PLACE_TURNS}..={MOST_PLACE_TURNS} turns, got {text}"
        )),
    }
}

fn acceleration(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rpm_per_s) if (1.0..=MOST_RPM_PER_S).contains(&rpm_per_s) => Ok(rpm_per_s),
        _ => Err(format!(
            "must be 1..={MOST_RPM_PER_S} r/min per second, got {text}"
        )),
    }
}

fn gear_number(text: &str) -> Result<GearNumber, String> {
    let number = text.parse().map_err(|_| "expected a number".to_owned())?;
    GearNumber::new(number).map_err(|error| error.to_string())
}

fn rpm(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rpm) if (1.0..=MOST_RPM).contains(&rpm) => Ok(rpm),
        _ => Err(format!("must be 1..={MOST_RPM} rpm, got {text}")),
    }
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<JogEnd>()
}
