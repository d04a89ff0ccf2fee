//! `motionctl disable`: disables drives, whatever left them enabled.

use std::process::ExitCode;

use can_motion::{AxisState, PollPeriods};
use dyn_can::{DriveId, StepLimit};
use serde::Serialize;

use crate::drive_ids::{drive_ids, list};
use crate::drives::DrivesError;
use crate::link::LinkOptions;
use crate::station::{AxisOptions, Station};

/// Shortest cycle: requests go out once a cycle.
const CYCLE_US: u32 = 1_000;
/// Time for the drives to answer; those that do not are told to disable all the same.
const ANSWER_LIMIT_US: u64 = 3_000_000;

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
#[derive(Debug, Serialize)]
struct Disabled {
    disabled: Vec<u8>,
    unconfirmed: Vec<u8>,
}

/// Disables and waits for the confirmation.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let mut link = arguments.link.open().map_err(DrivesError::Open)?;
    let mut drives = arguments.drives.clone();
    drives.sort_unstable();
    let axis = |&drive| AxisOptions::default().axis(drive, StepLimit::MAX, PollPeriods::OFF);
    let axes: Vec<_> = drives.iter().map(axis).collect();
    let mut station =
        Station::unhurried(&mut link, &axes, CYCLE_US).map_err(DrivesError::Config)?;
    let start = station.now();
    while station.now().us_since(start) < ANSWER_LIMIT_US && !have_answered(&mut station) {
        station.cycle(|_, _| {})?;
    }
    let unconfirmed = station.shut_down()?;
    tell(&drives, unconfirmed, arguments.json)
}

/// Tells which drives are disabled; an error names those that have not said so.
pub(crate) fn tell(
    drives: &[DriveId],
    unconfirmed: Vec<DriveId>,
    json: bool,
) -> Result<ExitCode, DrivesError> {
    let (enabled, disabled): (Vec<DriveId>, Vec<DriveId>) =
        drives.iter().partition(|drive| unconfirmed.contains(drive));
    if json {
        let numbers = |drives: &[DriveId]| drives.iter().map(|drive| drive.get()).collect();
        let disabled = Disabled {
            disabled: numbers(&disabled),
            unconfirmed: numbers(&enabled),
        };
        let text = serde_json::to_string_pretty(&disabled).map_err(DrivesError::Json)?;
        println!("{text}");
    } else if !disabled.is_empty() {
        println!("drives {} are disabled", list(&disabled));
    }
    if unconfirmed.is_empty() {
        return Ok(ExitCode::SUCCESS);
    }
    Err(DrivesError::StillEnabled {
        drives: unconfirmed,
        after: None,
    })
}

fn have_answered(station: &mut Station<'_>) -> bool {
    let master = station.master();
    let mut states = (0..)
        .map_while(|axis| master.snapshot(axis))
        .map(|axis| axis.state);
    states.all(|state| matches!(state, AxisState::Ready | AxisState::Faulted))
}
