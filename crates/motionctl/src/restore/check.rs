//! Whether every drive may be written, and what differs.

use dyn_can::StoredDriveId;

use super::difference::{Change, Difference};
use super::error::{Refusal, RefusalReason, RestoreError};
use crate::drives::{Drives, DrivesError, Parameter, Readings};
use crate::settings_file::{DriveSettings, FileRevision};

/// Reads every drive and compares it with what it shall have.
///
/// # Errors
/// Every reason that forbids to write to any of the drives; those of their state only when they are to be written.
pub(super) fn compare(
    drives: &mut dyn Drives,
    wanted: &[DriveSettings],
    must_rest: bool,
) -> Result<Vec<Difference>, RestoreError> {
    let mut differences = Vec::new();
    let mut refusals = Vec::new();
    for settings in wanted {
        let drive = settings.id;
        match one(drives, settings, must_rest) {
            Ok(difference) => differences.push(difference),
            Err(RefusalReason::Drives(DrivesError::Link(fault))) => {
                return Err(RestoreError::Drives(DrivesError::Link(fault)));
            }
            Err(reason) => refusals.push(Refusal { drive, reason }),
        }
    }
    if refusals.is_empty() {
        Ok(differences)
    } else {
        Err(RestoreError::Refused(refusals))
    }
}

fn one(
    drives: &mut dyn Drives,
    settings: &DriveSettings,
    must_rest: bool,
) -> Result<Difference, RefusalReason> {
    let drive = settings.id;
    drives.require_one(drive)?;
    let readings = drives.read(drive)?;
    require_revision(settings, &readings)?;
    if must_rest {
        require_rest(drives, drive, &readings)?;
    }
    difference(settings, &readings)
}

fn require_revision(settings: &DriveSettings, readings: &Readings) -> Result<(), RefusalReason> {
    match (settings.revision, readings.revision) {
        // The serial port tells none, and its settings do not depend on it.
        (_, None) => Ok(()),
        (FileRevision::Can(expected), Some(actual)) if expected == actual => Ok(()),
        (expected, Some(actual)) => Err(RefusalReason::Revision { expected, actual }),
    }
}

/// The drive is disabled, has no alarm, and its motor stands.
fn require_rest(
    drives: &mut dyn Drives,
    drive: StoredDriveId,
    readings: &Readings,
) -> Result<(), RefusalReason> {
    let state = &readings.state;
    if let Some(alarm) = &state.alarm {
        return Err(RefusalReason::Alarm(alarm.clone()));
    }
    match (state.enabled, state.busy) {
        (Some(false), Some(false)) => {}
        (None, _) | (_, None) => return Err(RefusalReason::StateUnknown),
        (Some(true), _) => return Err(RefusalReason::Enabled),
        (_, Some(true)) => return Err(RefusalReason::Busy),
    }
    match (state.speed_rpm, state.position_counts) {
        (Some(0), _) => Ok(()),
        (Some(rpm), _) => Err(RefusalReason::Turns { rpm }),
        // The serial port tells no speed: the position tells.
        (None, Some(before)) => match drives.read(drive)?.state.position_counts {
            Some(after) if after == before => Ok(()),
            Some(after) => Err(RefusalReason::Moves { before, after }),
            None => Err(RefusalReason::StateUnknown),
        },
        (None, None) => Err(RefusalReason::StateUnknown),
    }
}

fn difference(settings: &DriveSettings, readings: &Readings) -> Result<Difference, RefusalReason> {
    let line = Parameter::LineNumber;
    let is_known = settings.revision != FileRevision::Unknown;
    if is_known
        && settings.value(line).is_none()
        && let Some(actual) = readings.value(line)
    {
        return Err(RefusalReason::LineNumberStays { actual });
    }
    let mut changes = Vec::new();
    for &setting in &settings.settings {
        let before = readings.value(setting.parameter);
        if before != Some(setting.value) {
            changes.push(Change { setting, before });
        }
    }
    changes.sort_by_key(Difference::order);
    Ok(Difference {
        drive: settings.id,
        compared: settings.settings.len(),
        changes,
        gear_before: readings.gear(),
        gear_after: settings.gear(),
    })
}
