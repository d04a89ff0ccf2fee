//! `motionctl origin`: where the zero of a drive is.

use core::fmt;
use std::process::ExitCode;

use dyn_can::StoredDriveId;
use schemars::JsonSchema;
use serde::Serialize;

use crate::confirm::confirm;
use crate::drive_ids::stored_id;
use crate::drives::{Drives, DrivesError, DrivesOptions, Parameter, Readings};
use crate::dry_run;
use crate::output::{print, print_json};
use crate::station::ReplyOptions;

/// A free shaft may move by so many counts meanwhile.
const AT_ZERO_COUNTS: u32 = 16;
/// Bit 2 of the configuration: absolute mode.
const ABSOLUTE: i32 = 1 << 2;

const EXAMPLES: &str = "\
Examples:
  motionctl origin --slcan /dev/ttyACM0 --drive 3                   the software origin: nothing is written
  motionctl origin --can can0 --drive 3 --in-drive --yes --json     the drive's own zero

The software origin is the position that the drive reports where it stands: an application subtracts it, and it is valid until the
drive loses its power. With --in-drive the drive makes this position its own zero, which is one write of its EEPROM; over CAN the
drive must be disabled. In absolute mode its motor moves to that zero at each power-on.

Exit status: 0 done, 1 the drive does not answer, moves, or does not report 0 afterwards, 2 it is enabled or nobody confirmed and
nothing was written, 3 the link failed.";

/// Options of `motionctl origin`.
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
    /// Make the position the drive's own zero too, which it stores.
    #[arg(long)]
    in_drive: bool,
    /// Write without asking.
    #[arg(long)]
    yes: bool,
    /// Show the frames and send nothing.
    #[arg(long)]
    dry_run: bool,
    /// Print the origin as JSON.
    #[arg(long)]
    json: bool,
}

/// Where the zero is.
#[derive(Debug, Serialize, JsonSchema)]
struct Origin {
    drive: u8,
    /// What the drive reports where the zero shall be, in the unit of its read-back: subtract it.
    software_origin_counts: i32,
    /// What it reported before.
    before_counts: i32,
    in_drive: bool,
    eeprom_writes: u8,
}

/// Reads the position, and writes only on request.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, DrivesError> {
    let drive = arguments.drive;
    if arguments.dry_run {
        let frames = arguments.drives.frames();
        let mut steps = frames.reads(drive);
        if arguments.in_drive {
            steps.extend(frames.set_origin(drive));
        }
        dry_run::show(steps, arguments.json).map_err(DrivesError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut drives = arguments
        .drives
        .open(arguments.replies.into())
        .map_err(DrivesError::Open)?;
    drives.require_one(drive)?;
    let (readings, before_counts) = at_rest(drives.as_mut(), drive)?;
    let software_origin_counts = if arguments.in_drive {
        store(arguments, drives.as_mut(), &readings)?
    } else {
        before_counts
    };
    let origin = Origin {
        drive: drive.get(),
        software_origin_counts,
        before_counts,
        in_drive: arguments.in_drive,
        eeprom_writes: u8::from(arguments.in_drive),
    };
    if arguments.json {
        print_json(&origin).map_err(DrivesError::Print)?;
    } else {
        print(&origin).map_err(DrivesError::Print)?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Two readings of a position that stays.
fn at_rest(drives: &mut dyn Drives, drive: StoredDriveId) -> Result<(Readings, i32), DrivesError> {
    let first = drives.read(drive)?;
    let second = drives.read(drive)?;
    let (Some(before), Some(after)) = (first.state.position_counts, second.state.position_counts)
    else {
        return Err(DrivesError::Incomplete { drive });
    };
    if before.abs_diff(after) > AT_ZERO_COUNTS {
        return Err(DrivesError::Fault {
            drive,
            reason: format!(
                "expected a motor that stands, its position went from {before} to {after} counts: stop it; nothing was written"
            ),
        });
    }
    Ok((second, after))
}

/// Stores the zero in the drive and returns the position that it reports then.
fn store(
    arguments: &Arguments,
    drives: &mut dyn Drives,
    readings: &Readings,
) -> Result<i32, DrivesError> {
    let drive = arguments.drive;
    if readings.state.enabled != Some(false) && !arguments.drives.is_serial() {
        return Err(DrivesError::Enabled { drive });
    }
    confirm(&question(drive, readings), arguments.yes).map_err(DrivesError::NotConfirmed)?;
    drives.set_origin(drive)?;
    let (_, after) = at_rest(drives, drive)?;
    if after.unsigned_abs() > AT_ZERO_COUNTS {
        return Err(DrivesError::Fault {
            drive,
            reason: format!(
                "expected position 0 after the command, it reports {after} counts: it has not taken this zero"
            ),
        });
    }
    Ok(after)
}

fn question(drive: StoredDriveId, readings: &Readings) -> String {
    let config = readings.value(Parameter::Config);
    let is_absolute = config.is_none_or(|config| config & ABSOLUTE != 0);
    let mut question = format!(
        "Drive {drive} will store where it stands as its zero: position {} becomes 0, in its EEPROM.",
        readings.state.position_counts.unwrap_or_default()
    );
    if is_absolute {
        question
            .push_str(" It is in ABSOLUTE mode: its motor MOVES to that zero at each power-on.");
    }
    if readings.state.enabled != Some(false) {
        question.push_str(" The drive is ENABLED.");
    }
    question.push_str(" Write?");
    question
}

impl fmt::Display for Origin {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            drive,
            software_origin_counts: origin,
            before_counts: before,
            ..
        } = self;
        if self.in_drive {
            write!(
                f,
                "drive {drive} has stored its zero: it reported {before} counts and reports {origin}. EEPROM writes: 1"
            )
        } else {
            write!(
                f,
                "drive {drive} stands at {origin} counts: subtract that from its positions until it loses its power, or let `motionctl home --method here --origins FILE` keep it. Nothing was written"
            )
        }
    }
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<Origin>()
}
