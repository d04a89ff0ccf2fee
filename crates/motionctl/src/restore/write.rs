//! Writes what differs, one setting after the other.

use super::difference::Difference;
use super::outcome::{ChangeEnd, Outcome};
use crate::drives::{Drives, DrivesError, Setting, WriteEnd};
use crate::output::tell;

/// Writes the differences of every drive; the outcome has what has become of each, whatever happens.
///
/// # Errors
/// The first failure; nothing is sent after it.
pub(super) fn write(
    drives: &mut dyn Drives,
    differences: &[Difference],
    outcome: &mut Outcome,
) -> Result<(), DrivesError> {
    for (place, difference) in differences.iter().enumerate() {
        let written = write_one(drives, difference, place, outcome);
        if let Err(error) = &written {
            note_failure(place, error, outcome);
        }
        outcome.count();
        written?;
    }
    Ok(())
}

fn write_one(
    drives: &mut dyn Drives,
    difference: &Difference,
    place: usize,
    outcome: &mut Outcome,
) -> Result<(), DrivesError> {
    let settings = |order: core::ops::RangeInclusive<u8>| -> Vec<Setting> {
        let changes = difference.changes.iter();
        changes
            .filter(|change| order.contains(&Difference::order(change)))
            .map(|change| change.setting)
            .collect()
    };
    // What switches the servo on comes last, on its own.
    for settings in [settings(0..=1), settings(2..=u8::MAX)] {
        if settings.is_empty() {
            continue;
        }
        drives.write(difference.drive, &settings, &mut |setting, end| {
            note(place, setting, end, outcome);
        })?;
    }
    Ok(())
}

fn note(place: usize, setting: Setting, end: WriteEnd, outcome: &mut Outcome) {
    let Some(drive) = outcome.drives.get_mut(place) else {
        return;
    };
    let mut changes = drive.changes.iter_mut();
    if let Some(change) = changes.find(|change| change.parameter == setting.parameter) {
        change.result = match end {
            WriteEnd::Written => ChangeEnd::Written,
            WriteEnd::Unchanged => ChangeEnd::Unchanged,
        };
        tell(format_args!(
            "drive {}: {} = {} is in the drive",
            drive.drive, setting.parameter, setting.value
        ));
    }
}

/// The setting that was under way is the first that has not ended.
fn note_failure(place: usize, error: &DrivesError, outcome: &mut Outcome) {
    let Some(drive) = outcome.drives.get_mut(place) else {
        return;
    };
    let mut changes = drive.changes.iter_mut();
    let Some(change) = changes.find(|change| change.result == ChangeEnd::NotWritten) else {
        return;
    };
    change.result = match error {
        DrivesError::NotTaken { .. } => ChangeEnd::NotTaken,
        DrivesError::Refused { .. } => ChangeEnd::Refused,
        DrivesError::Interrupted
        | DrivesError::Procedure(_)
        | DrivesError::Enabled { .. }
        | DrivesError::Config(_) => ChangeEnd::NotWritten,
        _ => ChangeEnd::Unknown,
    };
}
