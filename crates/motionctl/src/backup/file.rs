//! The file of a backup: there as a whole, or not at all.

use core::fmt;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;
use time::OffsetDateTime;
use toml::value::{Date, Datetime, Offset, Time};

use crate::settings_file::Origin;

/// Why a file is not there.
#[derive(Debug)]
pub(crate) enum FileFault {
    /// It exists already.
    Exists { path: PathBuf },
    /// It cannot be written; what was there before is there still.
    Write { path: PathBuf, source: io::Error },
}

impl fmt::Display for FileFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Exists { path } => write!(
                f,
                "{} exists: choose another name, or replace it with --force",
                path.display()
            ),
            Self::Write { path, source } => write!(
                f,
                "cannot write {}: {source}. No part of a file was left, and what was there before is unchanged",
                path.display()
            ),
        }
    }
}

impl std::error::Error for FileFault {}

/// Makes sure, before anything is read, that the file may be written.
pub(crate) fn require_room(path: &Path, force: bool) -> Result<(), FileFault> {
    let is_there = path.symlink_metadata().is_ok();
    if is_there && !force {
        return Err(FileFault::Exists {
            path: path.to_owned(),
        });
    }
    // It goes away at once.
    temporary(folder_of(path))
        .map(drop)
        .map_err(|source| FileFault::Write {
            path: path.to_owned(),
            source,
        })
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// Writes the file beside its place and renames it.
pub(crate) fn create(path: &Path, text: &str, force: bool) -> Result<(), FileFault> {
    let write = |source| FileFault::Write {
        path: path.to_owned(),
        source,
    };
    let mut file = temporary(folder_of(path)).map_err(write)?;
    file.write_all(text.as_bytes())
        .and_then(|()| file.as_file().sync_all())
        .map_err(write)?;
    let persisted = if force {
        file.persist(path)
    } else {
        file.persist_noclobber(path)
    };
    match persisted {
        Ok(_) => Ok(()),
        Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => {
            Err(FileFault::Exists {
                path: path.to_owned(),
            })
        }
        Err(error) => Err(write(error.error)),
    }
}

/// A file that goes away unless it is renamed, with the permissions of any other new file.
fn temporary(folder: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".motionctl-");
    #[cfg(unix)]
    let permissions = std::os::unix::fs::PermissionsExt::from_mode(0o666);
    #[cfg(unix)]
    builder.permissions(permissions);
    builder.tempfile_in(folder)
}

/// This tool, now.
pub(crate) fn origin() -> Origin {
    let now = OffsetDateTime::now_utc();
    let date = Datetime {
        date: Some(Date {
            // No clock of a PC is set to a year before 0.
            year: u16::try_from(now.year()).unwrap_or_default(),
            month: u8::from(now.month()),
            day: now.day(),
        }),
        time: Some(Time {
            hour: now.hour(),
            minute: now.minute(),
            second: Some(now.second()),
            nanosecond: None,
        }),
        offset: Some(Offset::Z),
    };
    Origin {
        tool: concat!("motionctl ", env!("CARGO_PKG_VERSION")).to_owned(),
        date,
    }
}
