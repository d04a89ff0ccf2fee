//! The settings of drives in a file: what `backup` writes and `restore` reads.

mod reader;
#[cfg(test)]
mod tests;
mod writer;

use core::fmt;

use dyn_can::{GearNumber, Revision, StoredDriveId};

use crate::drives::{Parameter, Setting};

pub(crate) use reader::parse;
pub(crate) use writer::{Origin, write};

/// The layout that this tool writes and reads.
const FORMAT: i64 = 1;

/// The revision of the drive that the settings were read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FileRevision {
    /// Of the CAN specification.
    Can(Revision),
    /// Read over the serial port, which does not tell it.
    Unknown,
}

impl FileRevision {
    const ALL: [Self; 3] = [
        Self::Can(Revision::V1_2A),
        Self::Can(Revision::V1_6A),
        Self::Unknown,
    ];
}

impl fmt::Display for FileRevision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Can(revision) => revision.fmt(f),
            Self::Unknown => f.write_str("unknown"),
        }
    }
}

/// The settings of one drive.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct DriveSettings {
    pub(crate) id: StoredDriveId,
    pub(crate) revision: FileRevision,
    /// Each parameter once, in ascending order, except the line number of a drive that has none.
    pub(crate) settings: Vec<Setting>,
}

impl DriveSettings {
    pub(crate) fn value(&self, wanted: Parameter) -> Option<i32> {
        let mut settings = self.settings.iter();
        settings
            .find(|setting| setting.parameter == wanted)
            .map(|setting| setting.value)
    }

    /// The gear number, on which the units of speeds depend.
    pub(crate) fn gear(&self) -> Option<GearNumber> {
        GearNumber::new(self.value(Parameter::GearNumber)?).ok()
    }
}
