//! A request from its function and values.

use dyn_can::{
    Amplitude, Counts28, FrequencyHz, FunctionCode, GearNumber, IntegrationGain, LineNumber,
    MainGain, MaxAcceleration, MaxSpeed, OnPosRange, PdStep, ReadSelector, Request, ServoSwitch,
    SetParamGroup1, SetParamGroup2, SetParamGroup3, SpeedGain, SpeedRpm, StoredDriveId, SyncKind,
    TorqueFilter,
};
use pyo3::prelude::*;

use crate::errors::codec_error;
use crate::values::{Values, drive_config};

pub(super) fn of(function: FunctionCode, values: &Values<'_, '_>) -> PyResult<Request> {
    use FunctionCode as F;
    Ok(match function {
        F::SetOrigin => Request::SetOrigin,
        F::GoAbsolutePosPtp => {
            Request::GoAbsolutePosPtp(values.number("target_counts", Counts28::new)?)
        }
        F::MakeLinearLine => Request::MakeLinearLine(values.number("word_counts", Counts28::new)?),
        F::GoRelativePosPtp => {
            Request::GoRelativePosPtp(values.number("distance_counts", Counts28::new)?)
        }
        F::MakeCircularArc => {
            Request::MakeCircularArc(values.number("word_counts", Counts28::new)?)
        }
        F::AssignDriveId => Request::AssignDriveId(values.number("drive_id", StoredDriveId::new)?),
        F::ReadDriveId => Request::ReadDriveId,
        F::SetDriveConfig => Request::SetDriveConfig(drive_config(values)?),
        F::ReadDriveConfig => Request::ReadDriveConfig,
        F::ReadDriveStatus => Request::ReadDriveStatus,
        F::TurnConstSpeed => Request::TurnConstSpeed(values.number("speed_rpm", SpeedRpm::new)?),
        F::SquareWave => Request::SquareWave(values.number("amplitude", Amplitude::new)?),
        F::SinWave => Request::SinWave(values.number("amplitude", Amplitude::new)?),
        F::SsFrequency => Request::SsFrequency(values.number("frequency_hz", FrequencyHz::new)?),
        F::GeneralRead => Request::GeneralRead(selector(values)?),
        F::SetParamGroup1 => Request::SetParamGroup1(group1(values)?),
        F::SetParamGroup2 => Request::SetParamGroup2(group2(values)?),
        F::SetParamGroup3 => Request::SetParamGroup3(group3(values)?),
        F::ReadParamGroup1 => Request::ReadParamGroup1,
        F::ReadParamGroup2 => Request::ReadParamGroup2,
        F::ReadParamGroup3 => Request::ReadParamGroup3,
        F::GoAbsolutePosSync => {
            Request::GoAbsolutePosSync(values.number("target_counts", Counts28::new)?)
        }
        F::GoRelativePosSync => {
            Request::GoRelativePosSync(values.number("distance_counts", Counts28::new)?)
        }
        F::SyncTrigger => Request::SyncTrigger(if values.need("absolute")? {
            SyncKind::Absolute
        } else {
            SyncKind::Relative
        }),
        F::ServoDisable => Request::ServoDisable(if values.need("enable")? {
            ServoSwitch::Enable
        } else {
            ServoSwitch::Disable
        }),
        F::ReadMotorSpeed => Request::ReadMotorSpeed,
        F::DriveReset => Request::DriveReset,
        F::GoRelativePosPd => Request::GoRelativePosPd(values.number("step_counts", PdStep::new)?),
        F::EchoFunction => Request::EchoFunction(values.need("bytes")?),
        F::DiagnosticCounter => Request::DiagnosticCounter,
        F::ForMotorDefine | F::DriveError => {
            return Err(codec_error(
                values.py(),
                format_args!("{function} is no request: the factory or a drive sends it"),
            ));
        }
    })
}

fn selector(values: &Values<'_, '_>) -> PyResult<ReadSelector> {
    match values.need::<String>("reads")?.as_str() {
        "position" => Ok(ReadSelector::Position),
        "torque" => Ok(ReadSelector::Torque),
        other => Err(codec_error(
            values.py(),
            format_args!("General_Read: reads: expected position or torque, got {other}"),
        )),
    }
}

fn group1(values: &Values<'_, '_>) -> PyResult<SetParamGroup1> {
    Ok(SetParamGroup1 {
        main_gain: values.optional("main_gain", MainGain::new)?,
        speed_gain: values.optional("speed_gain", SpeedGain::new)?,
        integration_gain: values.optional("integration_gain", IntegrationGain::new)?,
        torque_filter: values.optional("torque_filter", TorqueFilter::new)?,
    })
}

fn group2(values: &Values<'_, '_>) -> PyResult<SetParamGroup2> {
    Ok(SetParamGroup2 {
        max_speed: values.optional("max_speed", MaxSpeed::new)?,
        max_acceleration: values.optional("max_acceleration", MaxAcceleration::new)?,
    })
}

fn group3(values: &Values<'_, '_>) -> PyResult<SetParamGroup3> {
    Ok(SetParamGroup3 {
        on_pos_range: values.optional("on_pos_range", OnPosRange::new)?,
        gear_number: values.optional("gear_number", GearNumber::new)?,
        line_number: values.optional("line_number", LineNumber::new)?,
    })
}
