//! Drive_Reset (1.6A section 6, #27): clears a fault and the position, and may leave the servo on.

use std::time::Duration;

use can_motion::{PollPeriods, Procedure, ProcedureEnd, ProcedureError};
use dyn_can::{DriveId, GearNumber};

use super::procedure::{answering_station, perform};
use super::read;
use crate::drives::{DriveState, DrivesError, ResetEnd};
use crate::link::Link;
use crate::station::AxisOptions;

/// A drive may restart before it answers: it takes 150 ms from power-on (DYN2 manual A1.8 section 3.2).
const RESTART: Duration = Duration::from_millis(500);

/// Resets a drive without power, and switches it off again when the reset has switched it on.
pub(super) fn reset(
    link: &mut Link,
    axes: AxisOptions,
    drive: DriveId,
) -> Result<ResetEnd, DrivesError> {
    let before = read::read(link, axes, drive)?.state;
    if before.enabled == Some(true) {
        return Err(DrivesError::Enabled {
            drive: drive.into(),
        });
    }
    send(link, axes, drive)?;
    std::thread::sleep(RESTART);
    let after = read::read(link, axes, drive)?.state;
    let was_switched_on = after.enabled != Some(false);
    let state = if was_switched_on {
        switch_off(link, axes, drive)?
    } else {
        after
    };
    Ok(ResetEnd {
        drive: drive.get(),
        alarm_before: before.alarm,
        alarm_after: state.alarm,
        position_before_counts: before.position_counts,
        position_after_counts: state.position_counts,
        was_switched_on,
    })
}

fn send(link: &mut Link, axes: AxisOptions, drive: DriveId) -> Result<(), DrivesError> {
    let mut station = answering_station(link, axes, drive, GearNumber::MIN, PollPeriods::DEFAULT)?;
    match perform(&mut station, drive, Procedure::DriveReset) {
        Ok(ProcedureEnd::Sent) => Ok(()),
        Ok(_) => Err(DrivesError::Incomplete {
            drive: drive.into(),
        }),
        Err(DrivesError::Procedure(ProcedureError::Refused(_))) => Err(DrivesError::Fault {
            drive: drive.into(),
            reason: "revision 1.2A has no reset: switch its power off and on. Nothing was done"
                .to_owned(),
        }),
        Err(error) => Err(error),
    }
}

fn switch_off(
    link: &mut Link,
    axes: AxisOptions,
    drive: DriveId,
) -> Result<DriveState, DrivesError> {
    let mut station = answering_station(link, axes, drive, GearNumber::MIN, PollPeriods::DEFAULT)?;
    let drives = station.disable_all()?;
    if !drives.is_empty() {
        return Err(DrivesError::StillEnabled {
            drives,
            after: None,
        });
    }
    drop(station);
    Ok(read::read(link, axes, drive)?.state)
}
