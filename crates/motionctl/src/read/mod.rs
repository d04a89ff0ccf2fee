//! `motionctl read`: the state and the parameters of a drive, in units.

use std::process::ExitCode;

use dyn_can::StoredDriveId;

use crate::drive_ids::stored_id;
use crate::drives::{DrivesError, DrivesOptions};
use crate::output::{print, print_json};
use crate::station::ReplyOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl read --slcan /dev/ttyACM0 --drive 3
  motionctl read --can can0 --drive 3 --json
  motionctl read --serial /dev/ttyUSB0 --drive 3

Nothing moves and nothing is changed; a drive in alarm can be read too.

Exit status: 0 read, 1 the drive does not answer, 3 the link failed.";

/// Options of `motionctl read`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    drives: DrivesOptions,
    #[command(flatten)]
    replies: ReplyOptions,
    /// Id of the drive; over --serial also 0, a drive that was never given one.
    #[arg(long, value_name = "ID", value_parser = stored_id)]
    drive: StoredDriveId,
    /// Print what was read as JSON.
    #[arg(long)]
    json: bool,
}

/// Reads a drive and prints what it tells.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let mut drives = arguments
        .drives
        .open(arguments.replies.into())
        .map_err(DrivesError::Open)?;
    let readings = drives.read(arguments.drive)?;
    if arguments.json {
        print_json(&readings).map_err(DrivesError::Print)?;
    } else {
        print(&readings).map_err(DrivesError::Print)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<crate::drives::Readings>()
}
