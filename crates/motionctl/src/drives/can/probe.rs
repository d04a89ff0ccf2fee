//! The byte orders of a drive, found out while nothing can move.

use dyn_can::{Dialect, DriveId, Reply, Request};
use dyn_commission::{Ask, ByteOrderProbe, ByteOrderResult, Group3Order};

use super::script::{self, LISTEN_US};
use crate::drives::{DrivesError, ProbeEnd};
use crate::link::Link;

/// Makes sure that the drive has no power and stands, then probes it. A drive whose replies cannot be read otherwise is probed too.
pub(super) fn probe(link: &mut Link, drive: DriveId) -> Result<ProbeEnd, DrivesError> {
    require_rest(link, drive)?;
    let group3 = script::run(link, Group3Order::of(drive).listening(LISTEN_US), |_| {})?;
    let group3 = group3.ok_or(DrivesError::Incomplete {
        drive: drive.into(),
    })?;
    let probe = ByteOrderProbe::with_free_shaft(drive, group3.revision).listening(LISTEN_US);
    let numbers = match script::run(link, probe, |_| {})? {
        ByteOrderResult::Order(order) => Some(order),
        ByteOrderResult::Undecided | ByteOrderResult::NotAllowed => None,
    };
    Ok(ProbeEnd::new(drive.get(), numbers, &group3))
}

fn require_rest(link: &mut Link, drive: DriveId) -> Result<(), DrivesError> {
    let stored = drive.into();
    let mut ask = |request| {
        let ask = Ask::new(drive, request, Dialect::V1_6A).listening(LISTEN_US);
        script::run(link, ask, |_| {})
    };
    let Some(Reply::DriveStatus(status)) = ask(Request::ReadDriveStatus)? else {
        return Err(DrivesError::NoAnswer { drive: stored });
    };
    let fault = |reason: String| {
        Err(DrivesError::Fault {
            drive: stored,
            reason,
        })
    };
    if status.alarm().is_alarm() {
        return fault(format!(
            "alarm, {}: remove its cause and clear it first; nothing was probed",
            status.alarm()
        ));
    }
    if !status.is_disabled() {
        return Err(DrivesError::Enabled { drive: stored });
    }
    match ask(Request::ReadMotorSpeed)? {
        Some(Reply::MotorSpeed(0)) => Ok(()),
        Some(Reply::MotorSpeed(rpm)) => fault(format!(
            "its motor turns at {rpm} rpm, expected 0: hold it; nothing was probed"
        )),
        _ => Err(DrivesError::Incomplete { drive: stored }),
    }
}
