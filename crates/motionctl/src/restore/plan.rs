//! What the drives shall have, before anything is sent.

use std::fs::File;
use std::io::{self, Read as _};

use board_settings::file::{FileError, Place};
use dyn_can::StoredDriveId;

use super::arguments::Arguments;
use super::error::RestoreError;
use crate::drives::Step;
use crate::settings_file::{self, DriveSettings, FileRevision};

/// A file with the settings of all 64 ids has less.
const MOST_BYTES: u64 = 1 << 20;

/// Reads the file and takes the drives that are asked for.
pub(super) fn read(arguments: &Arguments) -> Result<Vec<DriveSettings>, RestoreError> {
    let text = text(arguments)?;
    let wrong = |error| RestoreError::File {
        path: arguments.file.clone(),
        error,
    };
    let of_file = settings_file::parse(&text).map_err(wrong)?;
    let wanted = chosen(of_file, arguments)?;
    if !arguments.drives.is_serial() {
        wanted.iter().try_for_each(require_can)?;
    }
    // What this connection cannot carry shall not be found out half-way.
    frames(arguments, &wanted)?;
    Ok(wanted)
}

fn text(arguments: &Arguments) -> Result<String, RestoreError> {
    let path = &arguments.file;
    let unreadable = |source: io::Error| RestoreError::Read {
        path: path.clone(),
        source,
    };
    let file = File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    file.take(MOST_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(unreadable)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(unreadable(io::Error::other(format!(
            "expected at most {MOST_BYTES} bytes of settings, got more; is it another file?"
        ))));
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let bytes = error.as_bytes();
        let before = String::from_utf8_lossy(bytes.get(..valid).unwrap_or_default());
        RestoreError::File {
            path: path.clone(),
            error: FileError {
                place: Place::of(&before, valid),
                expected: "UTF-8".to_owned(),
                actual: format!(
                    "byte 0x{:02X}",
                    bytes.get(valid).copied().unwrap_or_default()
                ),
                advice: "save the file as UTF-8".to_owned(),
            },
        }
    })
}

fn chosen(
    of_file: Vec<DriveSettings>,
    arguments: &Arguments,
) -> Result<Vec<DriveSettings>, RestoreError> {
    let Some(ids) = &arguments.ids else {
        return Ok(of_file);
    };
    let find = |&drive: &StoredDriveId| {
        let mut found = of_file.iter().filter(|settings| settings.id == drive);
        found
            .next()
            .cloned()
            .ok_or_else(|| RestoreError::NotInFile {
                path: arguments.file.clone(),
                drive,
                there: of_file.iter().map(|settings| settings.id).collect(),
            })
    };
    ids.iter().map(find).collect()
}

/// Over CAN a drive has an id and a revision.
fn require_can(settings: &DriveSettings) -> Result<(), RestoreError> {
    let drive = settings.id;
    if drive.drive_id().is_none() {
        return Err(RestoreError::Drives(crate::drives::DrivesError::NoIdOnCan));
    }
    match settings.revision {
        FileRevision::Can(_) => Ok(()),
        FileRevision::Unknown => Err(RestoreError::RevisionUnknown { drive }),
    }
}

/// Every frame that might go out.
pub(super) fn frames(
    arguments: &Arguments,
    wanted: &[DriveSettings],
) -> Result<Vec<Step>, RestoreError> {
    let frames = arguments.drives.frames();
    let mut steps = Vec::new();
    for drive in wanted {
        steps.extend(frames.reads(drive.id));
        for &setting in &drive.settings {
            steps.push(frames.write(drive.id, setting)?);
        }
    }
    Ok(steps)
}
