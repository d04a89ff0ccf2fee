//! `motionctl disable`: disables drives, whatever left them enabled.

use std::process::ExitCode;

use can_motion::PollPeriods;
use dyn_can::{DriveId, GearNumber};
use schemars::JsonSchema;
use serde::Serialize;

use crate::drive_ids::{about, drive_ids};
use crate::drives::DrivesError;
use crate::link::LinkOptions;
use crate::output::{print, print_json};
use crate::station::{AxisOptions, End, Station};

/// Shortest cycle: requests go out once a cycle.
const CYCLE_US: u32 = 1_000;

const EXAMPLES: &str = "\
Examples:
  motionctl disable --slcan /dev/ttyACM0 --drives 1-3
  motionctl disable --can can0 --drives 4 --json

It does not ask, because it stops motion; a vertical axis without a brake falls.

Exit status: 0 every drive says that it is disabled, 1 one does not, 3 the link failed.";

/// Options of `motionctl disable`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    /// Ids of the drives: numbers and ranges, as in 1,2,5-7.
    #[arg(long, value_name = "IDS", value_parser = drive_ids)]
    drives: std::vec::Vec<DriveId>,
    /// Print the drives as JSON.
    #[arg(long)]
    json: bool,
}

/// The drives afterwards.
#[derive(Debug, Serialize, JsonSchema)]
struct Disabled {
    disabled: Vec<u8>,
    unconfirmed: Vec<u8>,
    /// Enabled before this tool came, and not switched off by it.
    left_enabled: Vec<u8>,
}

/// Disables and waits for the confirmation.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let mut link = arguments.link.open().map_err(DrivesError::Open)?;
    let mut drives = arguments.drives.clone();
    drives.sort_unstable();
    // Any gear number: nothing moves.
    let axis = |&drive| AxisOptions::default().still(drive, GearNumber::MIN, PollPeriods::OFF);
    let axes: Vec<_> = drives.iter().map(axis).collect();
    let mut station =
        Station::unhurried(&mut link, &axes, CYCLE_US).map_err(DrivesError::Config)?;
    let unconfirmed = station.disable_all()?;
    drives.retain(|drive| !unconfirmed.contains(drive));
    let end = End {
        disabled: drives,
        unconfirmed,
        left_on: Vec::new(),
    };
    tell_end(&end, arguments.json)
}

/// Tells which drives are disabled; an error names those that have not said so.
pub(crate) fn tell_end(end: &End, json: bool) -> Result<ExitCode, DrivesError> {
    if json {
        let numbers = |drives: &[DriveId]| drives.iter().map(|drive| drive.get()).collect();
        let disabled = Disabled {
            disabled: numbers(&end.disabled),
            unconfirmed: numbers(&end.unconfirmed),
            left_enabled: numbers(&end.left_on),
        };
        print_json(&disabled).map_err(DrivesError::Print)?;
    } else if !end.disabled.is_empty() {
        print(about(&end.disabled, "is disabled", "are disabled")).map_err(DrivesError::Print)?;
    }
    if end.unconfirmed.is_empty() {
        return Ok(ExitCode::SUCCESS);
    }
    Err(DrivesError::StillEnabled {
        drives: end.unconfirmed.clone(),
        after: None,
    })
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<Disabled>()
}
