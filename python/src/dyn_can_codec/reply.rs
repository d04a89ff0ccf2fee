//! A reply from its function and values.

use dyn_can::{
    ConfigByte, Dialect, DriveError, FunctionCode, GearNumber, IntegrationGain, LineNumber,
    MainGain, MaxAcceleration, MaxSpeed, OnPosRange, ParamGroup1, ParamGroup2, ParamGroup3, Reply,
    SpeedGain, StoredDriveId, Torque, TorqueFilter,
};
use pyo3::prelude::*;

use crate::errors::codec_error;
use crate::values::{Values, drive_status};

pub(super) fn of(
    function: FunctionCode,
    values: &Values<'_, '_>,
    dialect: &Dialect,
) -> PyResult<Reply> {
    use FunctionCode as F;
    Ok(match function {
        F::ReadDriveId => Reply::DriveId(values.number("drive_id", StoredDriveId::new)?),
        F::ReadDriveConfig => Reply::DriveConfig(ConfigByte::from_byte(values.need("config")?)),
        F::ReadDriveStatus => Reply::DriveStatus(drive_status(values)?),
        F::GeneralRead => general_read(values, dialect)?,
        F::ReadParamGroup1 => Reply::ParamGroup1(ParamGroup1 {
            main_gain: values.number("main_gain", MainGain::new)?,
            speed_gain: values.number("speed_gain", SpeedGain::new)?,
            integration_gain: values.number("integration_gain", IntegrationGain::new)?,
            torque_filter: values.number("torque_filter", TorqueFilter::new)?,
        }),
        F::ReadParamGroup2 => Reply::ParamGroup2(ParamGroup2 {
            max_speed: values.number("max_speed", MaxSpeed::new)?,
            max_acceleration: values.number("max_acceleration", MaxAcceleration::new)?,
        }),
        F::ReadParamGroup3 => Reply::ParamGroup3(ParamGroup3 {
            on_pos_range: values.number("on_pos_range", OnPosRange::new)?,
            gear_number: values.number("gear_number", GearNumber::new)?,
            line_number: values.optional("line_number", LineNumber::new)?,
        }),
        F::ReadMotorSpeed => Reply::MotorSpeed(values.need("speed_rpm")?),
        F::DriveReset => Reply::DriveReset(values.need("answer")?),
        F::EchoFunction => Reply::Echo(values.need("bytes")?),
        F::DiagnosticCounter => Reply::DiagnosticCounter(values.need("counter")?),
        F::DriveError => Reply::DriveError(drive_error(values)?),
        _ => {
            return Err(codec_error(
                values.py(),
                format_args!("{function} has no reply"),
            ));
        }
    })
}

/// Position or torque: the reply does not say which (D31).
fn general_read(values: &Values<'_, '_>, dialect: &Dialect) -> PyResult<Reply> {
    if let Some(raw) = values.get("torque")? {
        return Ok(Reply::Torque(Torque {
            raw,
            full_scale: dialect.torque_full_scale,
            positive: dialect.positive_torque,
        }));
    }
    if dialect.accept_beyond_28_bit {
        return values.need("position_counts").map(Reply::Position);
    }
    let counts = values.number("position_counts", dyn_can::Counts28::new)?;
    Ok(Reply::Position(counts.get()))
}

fn drive_error(values: &Values<'_, '_>) -> PyResult<DriveError> {
    let text: String = values.need("drive_error")?;
    // What decoding calls it; the documents list two of 256.
    let found = (0..=u8::MAX)
        .map(DriveError::from_byte)
        .find(|error| error.to_string() == text);
    found.ok_or_else(|| {
        codec_error(
            values.py(),
            format_args!(
                "Drive_Error: drive_error: expected \"alarm\", \"data error\" or \"undocumented error 0x..\", got \"{text}\""
            ),
        )
    })
}
