//! `motionctl assign-id`: gives a drive its id.

use std::process::ExitCode;

use dyn_can::{DriveId, StoredDriveId};

use crate::confirm::confirm;
use crate::drive_ids::{drive_id, stored_id};
use crate::drives::{DrivesError, DrivesOptions};
use crate::dry_run;
use crate::output::{print, print_json};
use crate::station::AxisOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl assign-id --slcan /dev/ttyACM0 --from 0 --to 3      a new drive, alone on the bus
  motionctl assign-id --can can0 --from 3 --to 5 --yes --json
  motionctl assign-id --serial /dev/ttyUSB0 --from 0 --to 3     also alone on its line

A drive that was never given an id has id 0, which every other drive may obey too: it must be alone on the bus. Before anything is
stored the bus must be quiet, every id is asked (with --from other than 0, over CAN, only the two), exactly one drive must answer as
--from and none as --to. Drives of revision 1.2A take the new id within 10 ms, those of 1.6A at their next power-on. The id is one
write of the EEPROM.

Exit status: 0 the drive has stored the id, 1 it has not, or another drive is in the way, 2 not confirmed and nothing was sent,
3 the link failed.";

/// Options of `motionctl assign-id`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    drives: DrivesOptions,
    /// Id that the drive has; 0 for one that was never given any.
    #[arg(long, value_name = "ID", value_parser = stored_id)]
    from: StoredDriveId,
    /// Id that it shall have, 1 to 63.
    #[arg(long, value_name = "ID", value_parser = drive_id)]
    to: DriveId,
    /// Assign without asking.
    #[arg(long)]
    yes: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    dry_run: bool,
    /// Print what was done as JSON.
    #[arg(long)]
    json: bool,
}

/// Asks, looks who is there, assigns, reads back.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let (from, to) = (arguments.from, arguments.to);
    if from == to.into() {
        return Err(DrivesError::SameId { id: to });
    }
    if arguments.dry_run {
        let steps = arguments.drives.frames().assign(from, to);
        dry_run::show(steps, arguments.json).map_err(DrivesError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    confirm(&question(arguments), arguments.yes).map_err(DrivesError::NotConfirmed)?;
    let mut drives = arguments
        .drives
        .open(AxisOptions::default())
        .map_err(DrivesError::Open)?;
    let end = drives.assign_id(from, to)?;
    if arguments.json {
        print_json(&end).map_err(DrivesError::Print)?;
    } else {
        print(&end).map_err(DrivesError::Print)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn question(arguments: &Arguments) -> String {
    let Arguments { from, to, .. } = arguments;
    if from.drive_id().is_none() || arguments.drives.is_serial() {
        format!(
            "The drive with id {from} will store id {to}. Is it the only drive on the line, and nothing else sends?"
        )
    } else {
        format!("Drive {from} will store id {to}. Is nothing streaming on the bus?")
    }
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<crate::drives::AssignEnd>()
}
