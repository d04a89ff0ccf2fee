//! `motionctl backup`: every setting of drives into a file.

pub(crate) mod file;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use dyn_can::StoredDriveId;
use schemars::JsonSchema;
use serde::Serialize;

use crate::counted::counted;
use crate::drive_ids::stored_ids;
use crate::drives::{Drives, DrivesError, DrivesOptions, Parameter, Readings, Setting};
use crate::dry_run;
use crate::exit::{self, Coded};
use crate::output::{print, print_json};
use crate::settings_file::{self, DriveSettings, FileRevision};
use crate::station::ReplyOptions;
pub(crate) use file::{FileFault, create as create_file, origin as this_tool, require_room};

const EXAMPLES: &str = "\
Examples:
  motionctl backup machine.toml --slcan /dev/ttyACM0 --drives 1,2
  motionctl backup machine.toml --can can0 --drives 1-6 --force --json
  motionctl backup fresh.toml --serial /dev/ttyUSB0 --drives 0

Nothing moves and nothing is changed in the drives; drives that are enabled or in alarm can be read too. A file that exists is kept
unless --force is given. The file is written beside its place and renamed when it is whole: a full disk leaves no part of one, and
what was there before.

Exit status: 0 the file has every setting of every drive, 1 a drive does not answer or tells something that cannot be stored,
2 the file exists or cannot be written, 3 the link failed. There is no new file unless it is 0.";

/// Options of `motionctl backup`.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// The file to write, in TOML.
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    #[command(flatten)]
    drives: DrivesOptions,
    #[command(flatten)]
    replies: ReplyOptions,
    /// Ids of the drives: numbers and ranges, as in 1,2,5-7; over --serial also 0, a drive that was never given one.
    #[arg(long = "drives", value_name = "IDS", required = true, value_parser = stored_ids)]
    ids: std::vec::Vec<StoredDriveId>,
    /// Replace a file that exists.
    #[arg(long)]
    force: bool,
    /// Show the frames, send nothing and write no file.
    #[arg(long)]
    dry_run: bool,
    /// Print what was read as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Serialize, JsonSchema)]
struct BackedUp<'a> {
    file: &'a Path,
    drives: Vec<Readings>,
}

/// Reads the drives and writes the file.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, BackupError> {
    if arguments.dry_run {
        let frames = arguments.drives.frames();
        let steps = arguments.ids.iter().flat_map(|&drive| frames.reads(drive));
        dry_run::show(steps.collect(), arguments.json).map_err(DrivesError::Print)?;
        return Ok(ExitCode::SUCCESS);
    }
    let path = &arguments.file;
    file::require_room(path, arguments.force)?;
    let mut drives = arguments
        .drives
        .open(arguments.replies.into())
        .map_err(DrivesError::Open)?;
    let mut settings = Vec::new();
    let mut readings = Vec::new();
    for &drive in &arguments.ids {
        let read = read_one(drives.as_mut(), drive)?;
        settings.push(settings_of(drive, &read)?);
        readings.push(read);
    }
    let text = settings_file::write(&file::origin(), &settings);
    file::create(path, &text, arguments.force)?;
    let printed = if arguments.json {
        print_json(&BackedUp {
            file: path,
            drives: readings,
        })
    } else {
        let drives = counted(settings.len(), "drive", "drives");
        print(format_args!(
            "{} has the settings of {drives}",
            path.display()
        ))
    };
    printed.map_err(DrivesError::Print)?;
    Ok(ExitCode::SUCCESS)
}

fn read_one(drives: &mut dyn Drives, drive: StoredDriveId) -> Result<Readings, DrivesError> {
    drives.require_one(drive)?;
    drives.read(drive)
}

/// What the file has of a drive. A value that `restore` would refuse is not written to a file.
fn settings_of(drive: StoredDriveId, readings: &Readings) -> Result<DriveSettings, DrivesError> {
    let setting = |(parameter, value): (Parameter, i32)| {
        Setting::new(parameter, value).map_err(|error| DrivesError::Fault {
            drive,
            reason: format!("it reports {parameter} = {value}, and {error}: no file was written"),
        })
    };
    Ok(DriveSettings {
        id: drive,
        revision: readings
            .revision
            .map_or(FileRevision::Unknown, FileRevision::Can),
        settings: readings.values().map(setting).collect::<Result<_, _>>()?,
    })
}

/// Why there is no backup.
#[derive(Debug)]
pub(crate) enum BackupError {
    /// A drive or the link.
    Drives(DrivesError),
    /// The file.
    File(FileFault),
}

impl From<DrivesError> for BackupError {
    fn from(error: DrivesError) -> Self {
        Self::Drives(error)
    }
}

impl From<FileFault> for BackupError {
    fn from(fault: FileFault) -> Self {
        Self::File(fault)
    }
}

impl core::fmt::Display for BackupError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Drives(error) => error.fmt(f),
            Self::File(fault) => fault.fmt(f),
        }
    }
}

impl std::error::Error for BackupError {}

impl Coded for BackupError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Drives(error) => error.exit_code(),
            Self::File(_) => exit::BAD_INPUT,
        }
    }
}

/// The shape of what `--json` prints.
pub(crate) fn schema() -> schemars::Schema {
    crate::schema::of::<BackedUp<'_>>()
}
