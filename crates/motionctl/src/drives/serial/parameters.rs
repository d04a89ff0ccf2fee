//! Parameters over the serial port: each has its own pair of functions.

use std::thread::sleep;
use std::time::Duration;

use dyn_can::StoredDriveId;
use dyn_serial::{ConfigByte, RangeError, Reply, Request};

use super::line::Line;
use crate::drives::{DrivesError, Parameter, Setting, WriteEnd};

/// A write is read back so often, with so much time in between: how long a drive takes to store is not stated.
const READ_BACKS: u32 = 10;
const READ_BACK_PAUSE: Duration = Duration::from_millis(50);

/// The parameters that this port reaches, in the order in which they are read.
const PARAMETERS: [(Parameter, Request); 9] = [
    (Parameter::Config, Request::ReadDriveConfig),
    (Parameter::MainGain, Request::ReadMainGain),
    (Parameter::SpeedGain, Request::ReadSpeedGain),
    (Parameter::IntegrationGain, Request::ReadIntGain),
    (Parameter::TorqueFilter, Request::ReadTrqCons),
    (Parameter::MaxSpeed, Request::ReadHighSpeed),
    (Parameter::MaxAcceleration, Request::ReadHighAccel),
    (Parameter::OnPositionRange, Request::ReadPosOnRange),
    (Parameter::GearNumber, Request::ReadGearNumber),
];

/// The requests that read every parameter.
pub(crate) fn read_requests() -> impl Iterator<Item = Request> {
    PARAMETERS.iter().map(|(_, request)| *request)
}

/// Every parameter with its value.
pub(super) fn read_all(
    line: &mut Line,
    drive: StoredDriveId,
) -> Result<Vec<(Parameter, i32)>, DrivesError> {
    PARAMETERS
        .iter()
        .map(|(parameter, _)| Ok((*parameter, read(line, drive, *parameter)?)))
        .collect()
}

/// One parameter.
pub(super) fn read(
    line: &mut Line,
    drive: StoredDriveId,
    parameter: Parameter,
) -> Result<i32, DrivesError> {
    let (_, request) = PARAMETERS
        .iter()
        .find(|(known, _)| *known == parameter)
        .ok_or_else(|| not_reached(drive, parameter))?;
    let reply = line.read(drive, request)?;
    value_of(&reply).ok_or(DrivesError::Incomplete { drive })
}

/// Compares, writes and reads back.
pub(super) fn write(
    line: &mut Line,
    drive: StoredDriveId,
    setting: Setting,
) -> Result<WriteEnd, DrivesError> {
    let Setting { parameter, value } = setting;
    if read(line, drive, parameter)? == value {
        return Ok(WriteEnd::Unchanged);
    }
    let request = request_of(setting)
        .map_err(|error| DrivesError::Fault {
            drive,
            reason: error.to_string(),
        })?
        .ok_or_else(|| not_reached(drive, parameter))?;
    line.command(drive, &request)?;
    let mut actual = None;
    for _ in 0..READ_BACKS {
        sleep(READ_BACK_PAUSE);
        actual = Some(read(line, drive, parameter)?);
        if actual == Some(value) {
            return Ok(WriteEnd::Written);
        }
    }
    Err(DrivesError::NotTaken {
        drive,
        parameter,
        expected: value,
        actual,
    })
}

fn not_reached(drive: StoredDriveId, parameter: Parameter) -> DrivesError {
    DrivesError::Fault {
        drive,
        reason: format!("{parameter} is not in the serial protocol: use CAN"),
    }
}

fn value_of(reply: &Reply) -> Option<i32> {
    Some(match reply {
        Reply::Config(config) => config.get().into(),
        Reply::MainGain(value) => value.get().into(),
        Reply::SpeedGain(value) => value.get().into(),
        Reply::IntegrationGain(value) => value.get().into(),
        Reply::TorqueFilter(value) => value.get().into(),
        Reply::MaxSpeed(value) => value.get().into(),
        Reply::MaxAcceleration(value) => value.get().into(),
        Reply::OnPosRange(value) => value.get().into(),
        Reply::GearNumber(value) => value.get().into(),
        _ => return None,
    })
}

/// The request that writes one parameter; `None` for one that this protocol does not have.
///
/// # Errors
/// When the value is out of range.
pub(crate) fn request_of(setting: Setting) -> Result<Option<Request>, RangeError> {
    let value = setting.value;
    Ok(Some(match setting.parameter {
        Parameter::Config => Request::SetDriveConfig(ConfigByte::new(value)?),
        Parameter::MainGain => Request::SetMainGain(value.try_into()?),
        Parameter::SpeedGain => Request::SetSpeedGain(value.try_into()?),
        Parameter::IntegrationGain => Request::SetIntGain(value.try_into()?),
        Parameter::TorqueFilter => Request::SetTrqCons(value.try_into()?),
        Parameter::MaxSpeed => Request::SetHighSpeed(value.try_into()?),
        Parameter::MaxAcceleration => Request::SetHighAccel(value.try_into()?),
        Parameter::OnPositionRange => Request::SetPosOnRange(value.try_into()?),
        Parameter::GearNumber => Request::SetGearNumber(value.try_into()?),
        Parameter::LineNumber => return Ok(None),
    }))
}
