//! `motionctl reset`: clears the fault of a drive.

use core::fmt;
use std::process::ExitCode;

use dyn_can::{Request, StoredDriveId};

use crate::confirm::confirm;
use crate::drive_ids::stored_id;
use crate::drives::{DrivesError, DrivesOptions, Frames, ResetEnd, When};
use crate::dry_run;
use crate::exit;
use crate::output::{print, print_json};
use crate::station::ReplyOptions;

const EXAMPLES: &str = "\
Examples:
  motionctl reset --slcan /dev/ttyACM0 --drive 3
  motionctl reset --can can0 --drive 3 --yes --json

Drive_Reset of revision 1.6A clears an alarm and resets the absolute position: home again afterwards. It may switch the servo
on, which is switched off again. A drive of revision 1.2A, and one whose alarm stays, needs its power switched off and on. The serial
protocol has no reset.

Exit status: 0 the drive has no alarm and is disabled, 1 its alarm stays or it does not answer, 2 it is enabled or nobody
confirmed and nothing was done, 3 the link failed.";

/// Options of `motionctl reset`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    drives: DrivesOptions,
    #[command(flatten)]
    replies: ReplyOptions,
    /// Id of the drive.
    #[arg(long, value_name = "ID", value_parser = stored_id)]
    drive: StoredDriveId,
    /// Reset without asking.
    #[arg(long)]
    yes: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    dry_run: bool,
    /// Print what has changed as JSON.
    #[arg(long)]
    json: bool,
}

/// Asks and resets.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let drive = arguments.drive;
    if arguments.drives.is_serial() {
        return Err(DrivesError::NotOnSerial { what: "reset" });
    }
    if arguments.dry_run {
        let id = drive.drive_id().ok_or(DrivesError::NoIdOnCan)?;
        let mut steps = arguments.drives.frames().reads(drive);
        steps.extend(Frames::on_can(When::Revision16A, id, Request::DriveReset));
        dry_run::show(steps, arguments.json).map_err(DrivesError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let question = format!(
        "The reset of drive {drive} clears its alarm and its position, and may switch its servo ON for a moment. Is nobody near it?"
    );
    let mut drives = arguments
        .drives
        .open(arguments.replies.into())
        .map_err(DrivesError::Open)?;
    drives.require_one(drive)?;
    confirm(&question, arguments.yes).map_err(DrivesError::NotConfirmed)?;
    let end = drives.reset(drive)?;
    if arguments.json {
        print_json(&end).map_err(DrivesError::Print)?;
    } else {
        print(&end).map_err(DrivesError::Print)?;
    }
    Ok(match end.alarm_after {
        None => ExitCode::SUCCESS,
        Some(_) => exit::BROKEN_PROMISE.into(),
    })
}

impl fmt::Display for ResetEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let drive = self.drive;
        match (&self.alarm_before, &self.alarm_after) {
            (_, Some(alarm)) => write!(
                f,
                "drive {drive} still has its alarm, {alarm}: remove the cause, then switch its power off and on"
            )?,
            (Some(alarm), None) => {
                write!(f, "drive {drive} has no alarm any more, it was {alarm}")?
            }
            (None, None) => write!(f, "drive {drive} had no alarm")?,
        }
        let counts = |counts: Option<i32>| {
            counts.map_or_else(|| "?".to_owned(), |counts| counts.to_string())
        };
        write!(
            f,
            "; its position was {} and is {} counts: home it again",
            counts(self.position_before_counts),
            counts(self.position_after_counts)
        )?;
        if self.was_switched_on {
            f.write_str(". The reset had switched its servo on; it is disabled again")?;
        }
        Ok(())
    }
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<crate::drives::ResetEnd>()
}
