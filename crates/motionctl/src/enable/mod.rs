//! `motionctl enable`: enables drives and holds them where they stand, until Ctrl-C.

use std::process::ExitCode;
use std::time::Duration;

use can_motion::{AxisState, EventKind, PollPeriods};
use dyn_can::{DriveId, StepLimit};

use crate::confirm::confirm;
use crate::disable;
use crate::drive_ids::{drive_ids, list};
use crate::drives::DrivesError;
use crate::interrupt;
use crate::link::LinkOptions;
use crate::station::{AxisOptions, GROUP, Station};

/// Shortest cycle of the set-points, which are all zero.
const CYCLE_US: u32 = 5_000;
/// Time for the drives to become ready, and to be enabled.
const START_UP_LIMIT_US: u64 = 10_000_000;

const EXAMPLES: &str = "\
Examples:
  motionctl enable --slcan /dev/ttyACM0 --drives 1-3
  motionctl enable --can can0 --drives 4 --for 10 --yes

The drives hold where they stand; nothing moves. Ctrl-C, or the end of --for, disables them: a vertical
axis without a brake falls then.

Exit status: 0 enabled and disabled again, 1 a drive could not be enabled or had a fault, 2 not confirmed
and nothing was enabled, 3 the link failed.";

/// Options of `motionctl enable`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    link: LinkOptions,
    #[command(flatten)]
    axes: AxisOptions,
    /// Ids of the drives: numbers and ranges, as in 1,2,5-7.
    #[arg(long, value_name = "IDS", value_parser = drive_ids)]
    drives: std::vec::Vec<DriveId>,
    /// Disable after so many seconds; until Ctrl-C without it.
    #[arg(long = "for", value_name = "SECONDS", value_parser = clap::value_parser!(u32).range(1..))]
    seconds: Option<u32>,
    /// Enable without asking.
    #[arg(long)]
    yes: bool,
    /// Print the drives that are disabled at the end as JSON.
    #[arg(long)]
    json: bool,
}

/// Asks, enables, holds, disables.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let mut link = arguments.link.open().map_err(DrivesError::Open)?;
    let ids = list(&arguments.drives);
    let question = format!(
        "Drives {ids} will be ENABLED and hold where they stand. Is everybody clear of the machine?"
    );
    confirm(&question, arguments.yes).map_err(DrivesError::NotConfirmed)?;
    interrupt::listen().map_err(DrivesError::Interrupt)?;
    let mut drives = arguments.drives.clone();
    drives.sort_unstable();
    let axis = |&drive| {
        arguments
            .axes
            .axis(drive, StepLimit::MAX, PollPeriods::DEFAULT)
    };
    let axes: Vec<_> = drives.iter().map(axis).collect();
    let mut station =
        Station::unhurried(&mut link, &axes, CYCLE_US).map_err(DrivesError::Config)?;
    let held = hold(&mut station, &drives, arguments);
    let shut_down = station.shut_down();
    DrivesError::after_shut_down(held, shut_down)?;
    disable::tell(&drives, Vec::new(), arguments.json)
}

fn hold(
    station: &mut Station<'_>,
    drives: &[DriveId],
    arguments: &Arguments,
) -> Result<(), DrivesError> {
    if !wait_for(station, drives, AxisState::Ready)? {
        return Ok(());
    }
    let now = station.now();
    let enabled = station.master().enable(now, GROUP);
    enabled.map_err(|error| DrivesError::Fault {
        drive: drives[0].into(),
        reason: error.to_string(),
    })?;
    if !wait_for(station, drives, AxisState::Streaming)? {
        return Ok(());
    }
    eprintln!(
        "drives {} are enabled and hold; Ctrl-C disables them",
        list(drives)
    );
    let start = station.now();
    let limit = arguments
        .seconds
        .map(|seconds| Duration::from_secs(seconds.into()).as_micros());
    while interrupt::requests() == 0
        && limit.is_none_or(|limit| u128::from(station.now().us_since(start)) < limit)
    {
        station.cycle(|_, _| {})?;
        check(station, drives)?;
    }
    Ok(())
}

/// False when the user asked to stop first.
fn wait_for(
    station: &mut Station<'_>,
    drives: &[DriveId],
    state: AxisState,
) -> Result<bool, DrivesError> {
    let start = station.now();
    while station.now().us_since(start) < START_UP_LIMIT_US {
        station.cycle(|_, _| {})?;
        check(station, drives)?;
        if station.master().all_are(GROUP, state) {
            return Ok(true);
        }
        if interrupt::requests() > 0 {
            return Ok(false);
        }
    }
    Err(DrivesError::Incomplete {
        drive: drives[0].into(),
    })
}

fn check(station: &mut Station<'_>, drives: &[DriveId]) -> Result<(), DrivesError> {
    while let Some(event) = station.next_event() {
        if let (EventKind::Fault(fault), Some(axis)) = (event.kind, event.axis) {
            let drive = drives[usize::from(axis)];
            let reason = fault.to_string();
            return Err(DrivesError::Fault {
                drive: drive.into(),
                reason,
            });
        }
    }
    Ok(())
}
