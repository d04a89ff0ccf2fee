//! What became of a new id.

use core::fmt;

use dyn_can::{DriveId, Revision, StoredDriveId};
use schemars::JsonSchema;
use serde::Serialize;

/// A drive that has stored a new id.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub(crate) struct AssignEnd {
    from: u8,
    to: u8,
    /// The id under which it answers now.
    active: u8,
    /// The new id counts after a power cycle.
    needs_power_cycle: bool,
    revision: Option<String>,
}

impl AssignEnd {
    /// The drive answers under its new id already, or still under its old one.
    pub(crate) fn of(
        from: StoredDriveId,
        to: DriveId,
        is_active: bool,
        revision: Option<Revision>,
    ) -> Self {
        Self {
            from: from.get(),
            to: to.get(),
            active: if is_active { to.get() } else { from.get() },
            needs_power_cycle: !is_active,
            revision: revision.map(|revision| revision.to_string()),
        }
    }
}

impl fmt::Display for AssignEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { from, to, .. } = self;
        if self.needs_power_cycle {
            write!(
                f,
                "id {to} is stored. The drive has id {from} until its power is switched off and on; then `motionctl scan` shows it as drive {to}"
            )
        } else {
            write!(f, "the drive has id {to} now, and answers under it")
        }
    }
}

/// Why a drive did not get an id.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum AssignError {
    /// Somebody else sends.
    NotQuiet,
    /// Another drive would take the id too.
    OtherDrive { drive: StoredDriveId },
    /// A drive has the id.
    IdTaken { to: DriveId },
    /// The drive answers with a data error.
    Refused { to: DriveId },
    /// The drive is of no known revision.
    UnknownRevision { from: StoredDriveId },
    /// The drive was told and does not answer as it should.
    NotConfirmed { from: StoredDriveId, to: DriveId },
}

impl fmt::Display for AssignError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotQuiet => f.write_str(
                "the bus is not quiet: expected no traffic of others, got some. End every other master and monitor that asks, and clear alarms; nothing was changed",
            ),
            Self::OtherDrive { drive } => write!(
                f,
                "drive {drive} is there too, and it may take the id that is meant for the drive without one: expected one drive alone, disconnect all others; nothing was changed"
            ),
            Self::IdTaken { to } => write!(
                f,
                "id {to} is in use: a drive answers to it. Choose another --to; nothing was changed"
            ),
            Self::Refused { to } => write!(
                f,
                "the drive answers id {to} with a data error: it has stored nothing"
            ),
            Self::UnknownRevision { from } => write!(
                f,
                "drive {from} tells no known revision: expected parameter group 3 in 5 bytes (1.2A) or 6 bytes (1.6A); nothing was changed"
            ),
            Self::NotConfirmed { from, to } => write!(
                f,
                "the drive was told to store id {to} and confirms it neither as drive {to} nor as drive {from}: switch its power off and on, then look with `motionctl scan`"
            ),
        }
    }
}
