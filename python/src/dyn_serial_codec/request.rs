//! A request from its function and values.

use dyn_serial::{
    Amplitude, ConfigByte, Counts28, DriveId, FrequencyHz, GearNumber, IntegrationGain, MainGain,
    MaxAcceleration, MaxSpeed, OnPosRange, ReadSelector, Request, RequestFunction, SpeedGain,
    SpeedRpm, TorqueFilter,
};
use pyo3::prelude::*;

use crate::errors::codec_error;
use crate::values::Values;

pub(super) fn of(function: RequestFunction, values: &Values<'_, '_>) -> PyResult<Request> {
    use RequestFunction as F;
    Ok(match function {
        F::SetOrigin => Request::SetOrigin,
        F::GoAbsolutePos => Request::GoAbsolutePos(values.number("target_counts", Counts28::new)?),
        F::MakeLinearLine => Request::MakeLinearLine(values.number("word_counts", Counts28::new)?),
        F::GoRelativePos => {
            Request::GoRelativePos(values.number("distance_counts", Counts28::new)?)
        }
        F::MakeCircularArc => {
            Request::MakeCircularArc(values.number("word_counts", Counts28::new)?)
        }
        F::AssignDriveId => Request::AssignDriveId(values.number("drive_id", DriveId::new)?),
        F::ReadDriveId => Request::ReadDriveId,
        F::SetDriveConfig => Request::SetDriveConfig(values.number("config", ConfigByte::new)?),
        F::ReadDriveConfig => Request::ReadDriveConfig,
        F::ReadDriveStatus => Request::ReadDriveStatus,
        F::TurnConstSpeed => Request::TurnConstSpeed(values.number("speed_rpm", SpeedRpm::new)?),
        F::SquareWave => Request::SquareWave(values.number("amplitude", Amplitude::new)?),
        F::SinWave => Request::SinWave(values.number("amplitude", Amplitude::new)?),
        F::SsFrequency => Request::SsFrequency(values.number("frequency_hz", FrequencyHz::new)?),
        F::GeneralRead => Request::GeneralRead(selector(values)?),
        F::ForMotorDefine => {
            return Err(codec_error(
                values.py(),
                format_args!("{function} is reserved for the factory"),
            ));
        }
        F::SetMainGain => Request::SetMainGain(values.number("main_gain", MainGain::new)?),
        F::SetSpeedGain => Request::SetSpeedGain(values.number("speed_gain", SpeedGain::new)?),
        F::SetIntGain => {
            Request::SetIntGain(values.number("integration_gain", IntegrationGain::new)?)
        }
        F::SetTrqCons => Request::SetTrqCons(values.number("torque_filter", TorqueFilter::new)?),
        F::SetHighSpeed => Request::SetHighSpeed(values.number("max_speed", MaxSpeed::new)?),
        F::SetHighAccel => {
            Request::SetHighAccel(values.number("max_acceleration", MaxAcceleration::new)?)
        }
        F::SetPosOnRange => Request::SetPosOnRange(values.number("on_pos_range", OnPosRange::new)?),
        F::SetGearNumber => Request::SetGearNumber(values.number("gear_number", GearNumber::new)?),
        F::ReadMainGain => Request::ReadMainGain,
        F::ReadSpeedGain => Request::ReadSpeedGain,
        F::ReadIntGain => Request::ReadIntGain,
        F::ReadTrqCons => Request::ReadTrqCons,
        F::ReadHighSpeed => Request::ReadHighSpeed,
        F::ReadHighAccel => Request::ReadHighAccel,
        F::ReadPosOnRange => Request::ReadPosOnRange,
        F::ReadGearNumber => Request::ReadGearNumber,
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
