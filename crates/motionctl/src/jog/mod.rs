//! `motionctl jog`: turns one motor a little, by hand.

use std::process::ExitCode;

use dyn_can::StoredDriveId;

use crate::confirm::confirm;
use crate::drive_ids::stored_id;
use crate::drives::{DrivesError, DrivesOptions, Jog, JogEnd};
use crate::exit;
use crate::interrupt;
use crate::station::AxisOptions;

/// A jog is for looking whether a motor turns and which way round. More is for `run`.
const MOST_TURNS: f64 = 10.0;
const MOST_RPM: f64 = 300.0;

const EXAMPLES: &str = "\
Examples:
  motionctl jog --slcan /dev/ttyACM0 --drive 3 --turns 0.25
  motionctl jog --can can0 --drive 3 --turns -1 --rpm 120 --yes
  motionctl jog --serial /dev/ttyUSB0 --drive 3 --turns 0.25 --rpm 300

The drive is enabled, turns on a smooth profile that is never faster than --rpm, and is disabled:
a vertical axis without a brake falls then. Ctrl-C ramps down and disables. Over --serial a drive that is enabled already makes one built-in move,
whose speed comes from its own parameters: it is refused where that is more than --rpm.

Exit status: 0 the motor went where it should, 1 it did not, 2 not confirmed and nothing has moved,
3 the link failed, 130 stopped by Ctrl-C.";

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
    #[arg(long, value_name = "TURNS", allow_hyphen_values = true, value_parser = turns)]
    turns: f64,
    /// Highest speed in rpm, at most 300.
    #[arg(long, value_name = "RPM", default_value = "60", value_parser = rpm)]
    rpm: f64,
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
    let Arguments {
        drive, turns, rpm, ..
    } = arguments;
    let question = format!(
        "The motor of drive {drive} will TURN, powered, by {turns} turns at up to {rpm} rpm. Is everybody clear of the machine?"
    );
    confirm(&question, arguments.yes).map_err(DrivesError::NotConfirmed)?;
    interrupt::listen().map_err(DrivesError::Interrupt)?;
    if !arguments.json {
        eprintln!("drive {drive} is being enabled and moved; Ctrl-C stops it");
    }
    let jog = Jog {
        turns: *turns,
        rpm: *rpm,
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
        let text = serde_json::to_string_pretty(end).map_err(DrivesError::Json)?;
        println!("{text}");
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
        "stays enabled"
    } else {
        "is disabled"
    };
    println!(
        "asked for {} counts, sent {}{stopped}; the drive {read} and {state}",
        end.asked_counts, end.sent_counts
    );
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

fn rpm(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rpm) if (1.0..=MOST_RPM).contains(&rpm) => Ok(rpm),
        _ => Err(format!("must be 1..={MOST_RPM} rpm, got {text}")),
    }
}
