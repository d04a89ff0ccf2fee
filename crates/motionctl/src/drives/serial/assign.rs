//! Gives a drive its id over its serial port: only with one drive on the line (DYN2 manual A1.8 sections 7.2.3 and 7.8).

use std::thread::sleep;
use std::time::Duration;

use dyn_can::{DriveId, StoredDriveId};
use dyn_serial::{Address, Request};

use super::line::{AnswersOnLine, Line};
use crate::drives::{AssignEnd, AssignError, DrivesError};

/// How long the line must be quiet before anything is sent.
const QUIET: Duration = Duration::from_millis(200);
/// How long a drive takes to store is not stated; over CAN it is 10 ms (1.2A section 6, #5).
const STORE: Duration = Duration::from_millis(100);

/// Makes sure that exactly one drive answers to the id.
pub(super) fn require_one(line: &mut Line, drive: StoredDriveId) -> Result<(), DrivesError> {
    let error = |error: dyn_serial::RangeError| DrivesError::Fault {
        drive,
        reason: error.to_string(),
    };
    let id = dyn_serial::DriveId::new(drive.get().into()).map_err(error)?;
    match line.count_answers(Address::Drive(id))? {
        AnswersOnLine::None => Err(DrivesError::NoAnswer { drive }),
        AnswersOnLine::OnlyEchoes => Err(DrivesError::OnlyEchoes { drive }),
        AnswersOnLine::One => Ok(()),
        AnswersOnLine::SeveralOrDamaged => Err(DrivesError::Several { drive }),
    }
}

/// Looks who is there, assigns, and reads back.
pub(super) fn assign(
    line: &mut Line,
    from: StoredDriveId,
    to: DriveId,
) -> Result<AssignEnd, DrivesError> {
    if line.hears_anything(QUIET)? {
        return Err(DrivesError::Assign(AssignError::NotQuiet));
    }
    require_one(line, from)?;
    require_no_other(line, from, to)?;
    let error = |error: dyn_serial::RangeError| DrivesError::Fault {
        drive: from,
        reason: error.to_string(),
    };
    let new = dyn_serial::DriveId::new(to.get().into()).map_err(error)?;
    let old = dyn_serial::DriveId::new(from.get().into()).map_err(error)?;
    line.command(from, &Request::AssignDriveId(new))?;
    sleep(STORE);
    if line.answers(Address::Drive(new))? {
        return Ok(AssignEnd::of(from, to, true, None));
    }
    if line.answers(Address::Drive(old))? {
        return Ok(AssignEnd::of(from, to, false, None));
    }
    Err(DrivesError::Assign(AssignError::NotConfirmed { from, to }))
}

fn require_no_other(line: &mut Line, from: StoredDriveId, to: DriveId) -> Result<(), DrivesError> {
    let others = dyn_serial::DriveId::all().filter(|other| other.get() != from.get());
    for other in others {
        let count = line.count_answers(Address::Drive(other))?;
        if matches!(count, AnswersOnLine::None | AnswersOnLine::OnlyEchoes) {
            continue;
        }
        return Err(DrivesError::Assign(if other.get() == to.get() {
            AssignError::IdTaken { to }
        } else {
            AssignError::OtherDrive {
                drive: StoredDriveId::new(other.get().into()).unwrap_or(from),
            }
        }));
    }
    Ok(())
}
