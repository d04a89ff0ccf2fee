//! The values of a message, and a reply from them.

use dyn_serial::{
    ConfigByte, Counts28, DriveId, GearNumber, IntegrationGain, MainGain, MaxAcceleration,
    MaxSpeed, OnPosRange, Quantity, ReadSelector, Reply, ReplyFunction, Request, SpeedGain,
    TorqueFilter,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::values::{Values, drive_status};

pub(super) fn request_values<'py>(
    py: Python<'py>,
    request: &Request,
) -> PyResult<Bound<'py, PyDict>> {
    let values = PyDict::new(py);
    match *request {
        Request::GoAbsolutePos(to) => values.set_item("target_counts", to.get())?,
        Request::GoRelativePos(by) => values.set_item("distance_counts", by.get())?,
        Request::MakeLinearLine(word) | Request::MakeCircularArc(word) => {
            values.set_item("word_counts", word.get())?;
        }
        Request::AssignDriveId(drive) => values.set_item("drive_id", drive.get())?,
        Request::SetDriveConfig(config) => values.set_item("config", config.get())?,
        Request::TurnConstSpeed(speed) => values.set_item("speed_rpm", speed.get())?,
        Request::SquareWave(amplitude) | Request::SinWave(amplitude) => {
            values.set_item("amplitude", amplitude.get())?;
        }
        Request::SsFrequency(frequency) => values.set_item("frequency_hz", frequency.get())?,
        Request::GeneralRead(ReadSelector::Position) => values.set_item("reads", "position")?,
        Request::GeneralRead(ReadSelector::Torque) => values.set_item("reads", "torque")?,
        Request::SetMainGain(value) => values.set_item("main_gain", value.get())?,
        Request::SetSpeedGain(value) => values.set_item("speed_gain", value.get())?,
        Request::SetIntGain(value) => values.set_item("integration_gain", value.get())?,
        Request::SetTrqCons(value) => values.set_item("torque_filter", value.get())?,
        Request::SetHighSpeed(value) => values.set_item("max_speed", value.get())?,
        Request::SetHighAccel(value) => values.set_item("max_acceleration", value.get())?,
        Request::SetPosOnRange(value) => values.set_item("on_pos_range", value.get())?,
        Request::SetGearNumber(value) => values.set_item("gear_number", value.get())?,
        // The others carry nothing.
        _ => {}
    }
    Ok(values)
}

pub(super) fn reply_values<'py>(py: Python<'py>, reply: &Reply) -> PyResult<Bound<'py, PyDict>> {
    let values = PyDict::new(py);
    match *reply {
        Reply::MainGain(value) => values.set_item("main_gain", value.get())?,
        Reply::SpeedGain(value) => values.set_item("speed_gain", value.get())?,
        Reply::IntegrationGain(value) => values.set_item("integration_gain", value.get())?,
        Reply::TorqueFilter(value) => values.set_item("torque_filter", value.get())?,
        Reply::MaxSpeed(value) => values.set_item("max_speed", value.get())?,
        Reply::MaxAcceleration(value) => values.set_item("max_acceleration", value.get())?,
        Reply::DriveId(drive) => values.set_item("drive_id", drive.get())?,
        Reply::OnPosRange(value) => values.set_item("on_pos_range", value.get())?,
        Reply::GearNumber(value) => values.set_item("gear_number", value.get())?,
        Reply::Status(status) => {
            values.set_item("on_position", status.on_position())?;
            values.set_item("disabled", status.is_disabled())?;
            values.set_item("alarm_code", status.alarm().code())?;
            values.set_item("alarm", status.alarm().to_string())?;
            values.set_item("motion_busy", status.motion_busy())?;
        }
        Reply::Config(config) => values.set_item("config", config.get())?,
        Reply::Position(counts) => values.set_item("position_counts", counts.get())?,
        Reply::Torque(torque) => values.set_item("torque", torque)?,
    }
    Ok(values)
}

pub(super) fn reply_of(function: ReplyFunction, values: &Values<'_, '_>) -> PyResult<Reply> {
    use ReplyFunction as F;
    Ok(match function {
        F::IsMainGain => Reply::MainGain(values.number("main_gain", MainGain::new)?),
        F::IsSpeedGain => Reply::SpeedGain(values.number("speed_gain", SpeedGain::new)?),
        F::IsIntGain => {
            Reply::IntegrationGain(values.number("integration_gain", IntegrationGain::new)?)
        }
        F::IsTrqCons => Reply::TorqueFilter(values.number("torque_filter", TorqueFilter::new)?),
        F::IsHighSpeed => Reply::MaxSpeed(values.number("max_speed", MaxSpeed::new)?),
        F::IsHighAccel => {
            Reply::MaxAcceleration(values.number("max_acceleration", MaxAcceleration::new)?)
        }
        F::IsDriveId => Reply::DriveId(values.number("drive_id", DriveId::new)?),
        F::IsPosOnRange => Reply::OnPosRange(values.number("on_pos_range", OnPosRange::new)?),
        F::IsGearNumber => Reply::GearNumber(values.number("gear_number", GearNumber::new)?),
        F::IsStatus => Reply::Status(drive_status(values)?),
        F::IsConfig => Reply::Config(values.number("config", ConfigByte::new)?),
        F::IsAbsPos32 => Reply::Position(values.number("position_counts", Counts28::new)?),
        F::IsTrqCurrent => Reply::Torque(values.number("torque", |raw| {
            Quantity::SerialTorque.check(raw).map(|raw| raw as i16)
        })?),
    })
}
