//! Writes one parameter.

use can_motion::{Procedure, ProcedureEnd};
use dyn_can::{
    DriveConfig, DriveId, GearNumber, IntegrationGain, LineNumber, MainGain, MaxAcceleration,
    MaxSpeed, OnPosRange, RangeError, Request, SetParamGroup1, SetParamGroup2, SetParamGroup3,
    SpeedGain, TorqueFilter,
};

use super::procedure::perform;
use super::read::parameters_of;
use crate::drives::{DrivesError, Parameter, Setting, WriteEnd};
use crate::station::Station;

/// Compares, writes and reads back one parameter.
pub(super) fn write(
    station: &mut Station<'_>,
    drive: DriveId,
    setting: Setting,
) -> Result<WriteEnd, DrivesError> {
    let Setting { parameter, value } = setting;
    let procedure = procedure_of(setting).map_err(|error| DrivesError::Fault {
        drive: drive.into(),
        reason: error.to_string(),
    })?;
    match perform(station, drive, procedure)? {
        ProcedureEnd::Unchanged => Ok(WriteEnd::Unchanged),
        ProcedureEnd::Written => Ok(WriteEnd::Written),
        ProcedureEnd::Refused => Err(DrivesError::Refused {
            drive: drive.into(),
            parameter,
        }),
        ProcedureEnd::NotTaken(reply) => {
            let mut read = parameters_of(&reply).into_iter();
            Err(DrivesError::NotTaken {
                drive: drive.into(),
                parameter,
                expected: value,
                actual: read
                    .find(|(other, _)| *other == parameter)
                    .map(|(_, value)| value),
            })
        }
        ProcedureEnd::NoReply
        | ProcedureEnd::Aborted
        | ProcedureEnd::Read(_)
        | ProcedureEnd::Sent => Err(DrivesError::Incomplete {
            drive: drive.into(),
        }),
    }
}

/// The frame that writes one parameter.
///
/// # Errors
/// When the value is out of range.
pub(crate) fn request_of(setting: Setting) -> Result<Request, RangeError> {
    Ok(match ParameterWrite::of(setting)? {
        ParameterWrite::Config(config) => Request::SetDriveConfig(config),
        ParameterWrite::Group1(set) => Request::SetParamGroup1(set),
        ParameterWrite::Group2(set) => Request::SetParamGroup2(set),
        ParameterWrite::Group3(set) => Request::SetParamGroup3(set),
    })
}

fn procedure_of(setting: Setting) -> Result<Procedure, RangeError> {
    Ok(match ParameterWrite::of(setting)? {
        ParameterWrite::Config(config) => Procedure::WriteConfig(config),
        ParameterWrite::Group1(set) => Procedure::WriteGroup1(set),
        ParameterWrite::Group2(set) => Procedure::WriteGroup2(set),
        ParameterWrite::Group3(set) => Procedure::WriteGroup3(set),
    })
}

/// One parameter in the message that carries it; the others of its group are kept.
enum ParameterWrite {
    Config(DriveConfig),
    Group1(SetParamGroup1),
    Group2(SetParamGroup2),
    Group3(SetParamGroup3),
}

impl ParameterWrite {
    fn of(setting: Setting) -> Result<Self, RangeError> {
        let value = setting.value;
        let (group1, group2, group3) = (
            SetParamGroup1::default(),
            SetParamGroup2::default(),
            SetParamGroup3::default(),
        );
        Ok(match setting.parameter {
            Parameter::Config => {
                Self::Config(DriveConfig::from_byte(value.try_into().unwrap_or(u8::MAX))?)
            }
            Parameter::MainGain => Self::Group1(SetParamGroup1 {
                main_gain: Some(MainGain::new(value)?),
                ..group1
            }),
            Parameter::SpeedGain => Self::Group1(SetParamGroup1 {
                speed_gain: Some(SpeedGain::new(value)?),
                ..group1
            }),
            Parameter::IntegrationGain => Self::Group1(SetParamGroup1 {
                integration_gain: Some(IntegrationGain::new(value)?),
                ..group1
            }),
            Parameter::TorqueFilter => Self::Group1(SetParamGroup1 {
                torque_filter: Some(TorqueFilter::new(value)?),
                ..group1
            }),
            Parameter::MaxSpeed => Self::Group2(SetParamGroup2 {
                max_speed: Some(MaxSpeed::new(value)?),
                ..group2
            }),
            Parameter::MaxAcceleration => Self::Group2(SetParamGroup2 {
                max_acceleration: Some(MaxAcceleration::new(value)?),
                ..group2
            }),
            Parameter::OnPositionRange => Self::Group3(SetParamGroup3 {
                on_pos_range: Some(OnPosRange::new(value)?),
                ..group3
            }),
            Parameter::GearNumber => Self::Group3(SetParamGroup3 {
                gear_number: Some(GearNumber::new(value)?),
                ..group3
            }),
            Parameter::LineNumber => Self::Group3(SetParamGroup3 {
                line_number: Some(LineNumber::new(value)?),
                ..group3
            }),
        })
    }
}
