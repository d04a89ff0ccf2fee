//! Drives on their serial port: DYN232M over RS232, or RS485 through a chain of drives.

mod assign;
mod jog;
mod line;
mod parameters;

use dyn_can::{DriveId, StoredDriveId};
use dyn_serial::{Address, Alarm, ReadSelector, Reply, Request};

use super::{
    AssignEnd, DriveState, Drives, DrivesError, FoundDrive, Jog, JogEnd, Life, ProbeEnd, Readings,
    ResetEnd, Setting, WriteEnd,
};
use crate::interrupt;
use crate::station::AxisOptions;
pub(crate) use jog::{LineMove, Way};
pub(crate) use line::Line;
pub(crate) use parameters::{read_requests, request_of};

/// The protocol, for people.
const PROTOCOL: &str = "DYN232M (serial)";
/// A lost reply must not hide a drive, and most ids have nobody who would answer.
const SCAN_ATTEMPTS: u8 = 2;

/// Drives behind a serial port.
pub(crate) struct SerialDrives {
    line: Line,
    axes: AxisOptions,
}

impl SerialDrives {
    pub(super) fn new(line: Line, axes: AxisOptions) -> Self {
        Self { line, axes }
    }

    /// One built-in move. Returns where it began, in command counts from the origin of the drive, and where it led. The user has agreed.
    pub(crate) fn go(
        &mut self,
        drive: StoredDriveId,
        wanted: LineMove,
    ) -> Result<(i32, JogEnd), DrivesError> {
        jog::go(&mut self.line, self.axes, drive, wanted)
    }

    /// What a drive says of itself now.
    pub(crate) fn state(&mut self, drive: StoredDriveId) -> Result<DriveState, DrivesError> {
        let status = self.line.status(drive)?;
        let alarm = status.alarm();
        Ok(DriveState {
            enabled: Some(!status.is_disabled()),
            on_position: Some(status.on_position()),
            busy: Some(status.motion_busy()),
            alarm: (alarm != Alarm::None).then(|| alarm.to_string()),
            position_counts: Some(self.line.position(drive)?),
            // The protocol has no speed, and the full scale of its torque differs by drive.
            speed_rpm: None,
            torque_share: None,
            torque_in_doubt: false,
        })
    }
}

impl Drives for SerialDrives {
    fn scan(&mut self, on_id: &mut dyn FnMut(u8)) -> Result<Vec<FoundDrive>, DrivesError> {
        self.line.set_attempts(SCAN_ATTEMPTS);
        let mut found = Vec::new();
        for drive in dyn_serial::DriveId::all() {
            on_id(drive.get());
            if self.line.answers(Address::Drive(drive))? {
                found.push(FoundDrive {
                    drive: drive.get(),
                    protocol: PROTOCOL.to_owned(),
                });
            }
        }
        Ok(found)
    }

    fn read(&mut self, drive: StoredDriveId) -> Result<Readings, DrivesError> {
        let state = self.state(drive)?;
        let parameters = parameters::read_all(&mut self.line, drive)?;
        Ok(Readings::new(
            drive.get(),
            PROTOCOL.to_owned(),
            state,
            parameters,
        ))
    }

    fn write(
        &mut self,
        drive: StoredDriveId,
        settings: &[Setting],
        on_end: &mut dyn FnMut(Setting, WriteEnd),
    ) -> Result<(), DrivesError> {
        for &setting in settings {
            if interrupt::requests() > 0 {
                return Err(DrivesError::Interrupted);
            }
            on_end(setting, parameters::write(&mut self.line, drive, setting)?);
        }
        Ok(())
    }

    fn jog(&mut self, drive: StoredDriveId, jog: Jog) -> Result<JogEnd, DrivesError> {
        let wanted = LineMove::of_jog(jog);
        Ok(jog::go(&mut self.line, self.axes, drive, wanted)?.1)
    }

    fn require_one(&mut self, drive: StoredDriveId) -> Result<(), DrivesError> {
        assign::require_one(&mut self.line, drive)
    }

    fn assign_id(&mut self, from: StoredDriveId, to: DriveId) -> Result<AssignEnd, DrivesError> {
        self.line.set_attempts(SCAN_ATTEMPTS);
        assign::assign(&mut self.line, from, to)
    }

    fn set_origin(&mut self, drive: StoredDriveId) -> Result<(), DrivesError> {
        self.line.command(drive, &Request::SetOrigin)
    }

    fn reset(&mut self, _: StoredDriveId) -> Result<ResetEnd, DrivesError> {
        Err(DrivesError::NotOnSerial { what: "reset" })
    }

    fn life(&mut self, _: StoredDriveId) -> Result<Life, DrivesError> {
        Err(DrivesError::NotOnSerial {
            what: "diagnostic counter that tells whether an origin still holds",
        })
    }

    fn probe(&mut self, _: StoredDriveId) -> Result<ProbeEnd, DrivesError> {
        Err(DrivesError::NotOnSerial {
            what: "doubt of its byte order to probe",
        })
    }
}

impl Line {
    fn status(&mut self, drive: StoredDriveId) -> Result<dyn_serial::DriveStatus, DrivesError> {
        match self.read(drive, &Request::ReadDriveStatus)? {
            Reply::Status(status) => Ok(status),
            _ => Err(DrivesError::Incomplete { drive }),
        }
    }

    /// In the unit of the drive's read-back.
    fn position(&mut self, drive: StoredDriveId) -> Result<i32, DrivesError> {
        match self.read(drive, &Request::GeneralRead(ReadSelector::Position))? {
            Reply::Position(counts) => Ok(counts.get()),
            _ => Err(DrivesError::Incomplete { drive }),
        }
    }
}
