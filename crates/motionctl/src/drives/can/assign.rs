//! Gives a drive its id.

use dyn_can::{DriveId, StoredDriveId};
use dyn_commission::{AssignId, AssignResult};

use super::script::{self, LISTEN_US};
use crate::drives::{AssignEnd, AssignError, DrivesError};
use crate::link::Link;

/// Looks who is there, assigns, and reads back.
pub(super) fn assign(
    link: &mut Link,
    from: StoredDriveId,
    to: DriveId,
) -> Result<AssignEnd, DrivesError> {
    let assign = from.drive_id().map_or_else(
        || AssignId::first_id_of_the_only_drive(to),
        |from| AssignId::rename(from, to),
    );
    let mut revision = None;
    let result = script::run(link, assign.listening(LISTEN_US), |assign| {
        revision = assign.revision();
    })?;
    let error = match result {
        AssignResult::Active => return Ok(AssignEnd::of(from, to, true, revision)),
        AssignResult::AfterPowerCycle => return Ok(AssignEnd::of(from, to, false, revision)),
        AssignResult::NoDrive => return Err(DrivesError::NoAnswer { drive: from }),
        AssignResult::SeveralDrives => return Err(DrivesError::Several { drive: from }),
        AssignResult::NotConfirmed => AssignError::NotConfirmed { from, to },
        AssignResult::Refused => AssignError::Refused { to },
        AssignResult::NotQuiet => AssignError::NotQuiet,
        AssignResult::OtherDrive(drive) => AssignError::OtherDrive {
            drive: drive.into(),
        },
        AssignResult::IdTaken => AssignError::IdTaken { to },
        AssignResult::UnknownRevision | AssignResult::NotAllowed => {
            AssignError::UnknownRevision { from }
        }
    };
    Err(DrivesError::Assign(error))
}
