//! `motionctl enable`: enables drives and holds them where they stand, until Ctrl-C.

use std::process::ExitCode;
use std::time::Duration;

use can_motion::PollPeriods;
use dyn_can::DriveId;

use crate::confirm::confirm;
use crate::disable;
use crate::drive_ids::{about, drive_ids};
use crate::drives::DrivesError;
use crate::interrupt;
use crate::link::LinkOptions;
use crate::output::tell;
use crate::station::{AxisOptions, BringUpError, Seen, Station, found_on, look};

/// Shortest cycle of the set-points, which are all zero.
const CYCLE_US: u32 = 5_000;

const EXAMPLES: &str = "\
Examples:
  motionctl enable --slcan /dev/ttyACM0 --drives 1-3
  motionctl enable --can can0 --drives 4 --for 10 --yes

The drives hold where they stand; nothing moves. Ctrl-C, or the end of --for, disables them: a vertical
axis without a brake falls then. Drives that were enabled before stay enabled.

Exit status: 0 enabled and disabled again, 1 a drive could not be enabled, had a fault, or did not confirm that it is
disabled, 2 not confirmed and nothing was enabled, 3 the link failed or stood still.";

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
    let question = about(
        &arguments.drives,
        "will be ENABLED and hold where it stands. Is everybody clear of the machine?",
        "will be ENABLED and hold where they stand. Is everybody clear of the machine?",
    );
    confirm(&question, arguments.yes).map_err(DrivesError::NotConfirmed)?;
    interrupt::listen_in_motion().map_err(DrivesError::Interrupt)?;
    let mut drives = arguments.drives.clone();
    drives.sort_unstable();
    let seen = look(&mut link, arguments.axes, &drives).map_err(DrivesError::Look)?;
    let axis = |seen: &Seen| {
        arguments
            .axes
            .still(seen.drive, seen.gear, PollPeriods::DEFAULT)
    };
    let axes: Vec<_> = seen.iter().map(axis).collect();
    let mut station =
        Station::unhurried(&mut link, &axes, CYCLE_US).map_err(DrivesError::Config)?;
    let held = hold(&mut station, &drives, arguments);
    let ((), end) = DrivesError::after_shut_down(held, &mut station)?;
    disable::tell_end(&end, arguments.json)
}

fn hold(
    station: &mut Station<'_>,
    drives: &[DriveId],
    arguments: &Arguments,
) -> Result<(), DrivesError> {
    match station.bring_up() {
        Ok(()) => {}
        Err(BringUpError::Interrupted) => return Ok(()),
        Err(error) => return Err(DrivesError::BringUp(error)),
    }
    tell(about(
        drives,
        "is enabled and holds; Ctrl-C ends it",
        "are enabled and hold; Ctrl-C ends it",
    ));
    if let Some(text) = found_on(station.found_on()) {
        tell(text);
    }
    let start = station.now();
    let limit = arguments
        .seconds
        .map(|seconds| Duration::from_secs(seconds.into()).as_micros());
    while interrupt::requests() == 0
        && limit.is_none_or(|limit| u128::from(station.now().us_since(start)) < limit)
    {
        station.cycle(|_, _| {})?;
        if let Some((drive, fault)) = station.first_fault() {
            return Err(DrivesError::DriveFault { drive, fault });
        }
    }
    Ok(())
}
