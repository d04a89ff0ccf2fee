//! Why the drives do not have what the file says.

use core::fmt;
use std::io;
use std::path::PathBuf;

use board_settings::file::FileError;
use dyn_can::{Revision, StoredDriveId};

use crate::drives::DrivesError;
use crate::exit::{self, Coded};
use crate::settings_file::FileRevision;

/// A restore that did not succeed.
#[derive(Debug)]
pub(crate) enum RestoreError {
    /// The file cannot be read.
    Read { path: PathBuf, source: io::Error },
    /// The file is no file of settings.
    File { path: PathBuf, error: FileError },
    /// The file does not have a drive that was asked for.
    NotInFile {
        path: PathBuf,
        drive: StoredDriveId,
        there: Vec<StoredDriveId>,
    },
    /// The file does not say for which revision it is.
    RevisionUnknown { drive: StoredDriveId },
    /// Drives may not be written. Nothing was.
    Refused(Vec<Refusal>),
    /// Something failed before anything was written.
    Drives(DrivesError),
    /// Something failed while values were written.
    Unfinished {
        error: DrivesError,
        /// At least one value is written, or may be.
        is_started: bool,
    },
}

/// A drive that may not be written.
#[derive(Debug)]
pub(crate) struct Refusal {
    pub(super) drive: StoredDriveId,
    pub(super) reason: RefusalReason,
}

/// Why a drive may not be written.
#[derive(Debug)]
pub(crate) enum RefusalReason {
    Enabled,
    Busy,
    Turns {
        rpm: i32,
    },
    Moves {
        before: i32,
        after: i32,
    },
    Alarm(String),
    StateUnknown,
    Revision {
        expected: FileRevision,
        actual: Revision,
    },
    /// The drive has a line number and shall have none.
    LineNumberStays {
        actual: i32,
    },
    /// It cannot be read.
    Drives(DrivesError),
}

impl From<DrivesError> for RefusalReason {
    fn from(error: DrivesError) -> Self {
        Self::Drives(error)
    }
}

impl From<DrivesError> for RestoreError {
    fn from(error: DrivesError) -> Self {
        Self::Drives(error)
    }
}

impl Coded for RestoreError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Read { .. }
            | Self::File { .. }
            | Self::NotInFile { .. }
            | Self::RevisionUnknown { .. } => exit::BAD_INPUT,
            Self::Refused(_) => exit::BROKEN_PROMISE,
            Self::Unfinished {
                is_started: true, ..
            } => exit::PARTLY_DONE,
            Self::Drives(error) | Self::Unfinished { error, .. } => error.exit_code(),
        }
    }
}

impl fmt::Display for RestoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, source } => write!(f, "cannot read {}: {source}", path.display()),
            Self::File { path, error } => write!(f, "{}: {error}", path.display()),
            Self::NotInFile { path, drive, there } => {
                let there: Vec<String> = there.iter().map(ToString::to_string).collect();
                write!(
                    f,
                    "{} has no drive {drive}: expected one of {}; nothing was written",
                    path.display(),
                    there.join(", ")
                )
            }
            Self::RevisionUnknown { drive } => write!(
                f,
                "the settings of drive {drive} were read over its serial port, which does not tell its revision: restore them with --serial, or see its revision with `motionctl scan` and write it into the file; nothing was written"
            ),
            Self::Refused(refusals) => {
                f.write_str("nothing was written to any drive")?;
                refusals
                    .iter()
                    .try_for_each(|refusal| write!(f, "\n  {refusal}"))
            }
            Self::Drives(error) => error.fmt(f),
            Self::Unfinished { error, is_started } => {
                let what = if *is_started {
                    "the restore is NOT complete, what is written is listed"
                } else {
                    "nothing was written"
                };
                write!(f, "{error}; {what}")
            }
        }
    }
}

impl std::error::Error for RestoreError {}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let drive = self.drive;
        // These name their drive.
        if let RefusalReason::Drives(error) = &self.reason {
            return error.fmt(f);
        }
        write!(f, "drive {drive}: {}", self.reason)
    }
}

impl fmt::Display for RefusalReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Enabled => f.write_str(
                "expected a disabled drive, it is enabled: `motionctl disable` first, where nothing hangs on it; over --serial, `motionctl write` config with bit 5",
            ),
            Self::Busy => f.write_str(
                "expected a drive without motion, a built-in move or wave is under way: stop it and disable the drive",
            ),
            Self::Turns { rpm } => write!(
                f,
                "expected a motor that stands, it turns at {rpm} rpm: wait, or hold it"
            ),
            Self::Moves { before, after } => write!(
                f,
                "expected a motor that stands, its position went from {before} to {after} counts: wait, or hold it"
            ),
            Self::Alarm(alarm) => write!(
                f,
                "expected no alarm, it has one: {alarm}. Remove the cause, then `motionctl reset`, or switch it off and on"
            ),
            Self::StateUnknown => f.write_str(
                "it did not tell its state in time: try again, or look for a second master",
            ),
            Self::Revision { expected, actual } => write!(
                f,
                "expected revision {expected}, as in the file, it is of revision {actual}: the file is of another drive"
            ),
            Self::LineNumberStays { actual } => write!(
                f,
                "expected no line number, as in the file, it has {actual}, and no command removes one: write line-number = {actual} into the file if that is right"
            ),
            Self::Drives(error) => error.fmt(f),
        }
    }
}
