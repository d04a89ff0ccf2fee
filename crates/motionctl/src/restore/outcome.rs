//! What has become of every setting.

use core::fmt;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;

use super::difference::Difference;
use crate::counted::counted;
use crate::drives::Parameter;

/// What has become of a setting that differed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(super) enum ChangeEnd {
    /// Written, and read back as written.
    Written,
    /// The drive had the value when it was to be written.
    Unchanged,
    /// Sent, and another value was read back.
    NotTaken,
    /// The drive answered with a data error.
    Refused,
    /// Something failed meanwhile: it may be written or not.
    Unknown,
    /// Not sent.
    NotWritten,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub(super) struct ChangeOutcome {
    pub(super) parameter: Parameter,
    pub(super) before: Option<i32>,
    pub(super) value: i32,
    pub(super) result: ChangeEnd,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub(super) struct DriveOutcome {
    pub(super) drive: u8,
    /// Settings that were the same and were not written.
    same: usize,
    pub(super) changes: Vec<ChangeOutcome>,
    /// Each setting is one write of the EEPROM at most; of one that was not read back it is not known.
    eeprom_writes: usize,
    eeprom_writes_in_doubt: usize,
}

/// What has become of everything.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub(super) struct Outcome {
    file: PathBuf,
    /// Every drive has every value of the file.
    complete: bool,
    pub(super) drives: Vec<DriveOutcome>,
}

impl Outcome {
    /// Nothing was written yet.
    pub(super) fn untouched(file: &Path, differences: &[Difference]) -> Self {
        let drive = |difference: &Difference| DriveOutcome {
            drive: difference.drive.get(),
            same: difference.compared - difference.changes.len(),
            changes: difference
                .changes
                .iter()
                .map(|change| ChangeOutcome {
                    parameter: change.setting.parameter,
                    before: change.before,
                    value: change.setting.value,
                    result: ChangeEnd::NotWritten,
                })
                .collect(),
            eeprom_writes: 0,
            eeprom_writes_in_doubt: 0,
        };
        Self {
            file: file.to_owned(),
            complete: differences.iter().all(Difference::is_empty),
            drives: differences.iter().map(drive).collect(),
        }
    }

    /// Something is written, or may be. What was sent and read back with its old value is not.
    pub(super) fn has_written(&self) -> bool {
        let mut changes = self.drives.iter().flat_map(|drive| &drive.changes);
        changes.any(|change| matches!(change.result, ChangeEnd::Written | ChangeEnd::Unknown))
    }

    /// Counts after a change has ended.
    pub(super) fn count(&mut self) {
        let is = |ends: &'static [ChangeEnd]| {
            move |change: &&ChangeOutcome| ends.contains(&change.result)
        };
        let done = is(&[ChangeEnd::Written, ChangeEnd::Unchanged]);
        for drive in &mut self.drives {
            let changes = || drive.changes.iter();
            drive.eeprom_writes = changes().filter(is(&[ChangeEnd::Written])).count();
            drive.eeprom_writes_in_doubt = changes()
                .filter(is(&[ChangeEnd::NotTaken, ChangeEnd::Unknown]))
                .count();
        }
        self.complete = self
            .drives
            .iter()
            .all(|drive| drive.changes.iter().filter(done).count() == drive.changes.len());
    }
}

impl ChangeEnd {
    const fn words(self) -> &'static str {
        match self {
            Self::Written => "written",
            Self::Unchanged => "is already",
            Self::NotTaken => "NOT TAKEN",
            Self::Refused => "REFUSED",
            Self::Unknown => "NOT KNOWN, it may be written or not",
            Self::NotWritten => "not written",
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for drive in &self.drives {
            let same = counted(drive.same as u64, "setting", "settings");
            writeln!(f, "drive {}: {same} the same", drive.drive)?;
            for change in &drive.changes {
                let ChangeOutcome {
                    parameter,
                    value,
                    result,
                    ..
                } = change;
                writeln!(f, "  {parameter} = {value}  {}", result.words())?;
            }
        }
        let sum = |of: fn(&DriveOutcome) -> usize| self.drives.iter().map(of).sum::<usize>();
        write!(f, "EEPROM writes: {}", sum(|drive| drive.eeprom_writes))?;
        match sum(|drive| drive.eeprom_writes_in_doubt) {
            0 => Ok(()),
            more => write!(f, ", and perhaps {more} more"),
        }
    }
}
