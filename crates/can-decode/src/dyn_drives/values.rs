//! Messages as values with units in their names, for machines.
//!
//! Shape: `drive`, `direction`, `function`, then one entry a value, then `response_us`, `error` and `note` where there are any.

use dyn_can::{
    ConfigByte, DriveConfig, DriveId, DriveStatus, ParamGroup1, ParamGroup2, ParamGroup3,
    ReadSelector, Reply, Request, ServoSwitch, SetParamGroup1, SetParamGroup2, SetParamGroup3,
    SyncKind,
};
use serde::ser::{Serialize, SerializeMap, Serializer};

use super::message::{Content, Message};

impl Serialize for Message {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(None)?;
        map.serialize_entry("drive", &self.address.drive().map(DriveId::get))?;
        map.serialize_entry("direction", &self.direction())?;
        map.serialize_entry("function", self.function.name())?;
        match &self.content {
            Content::Request(request) => write_request(&mut map, request)?,
            Content::Reply { reply, .. } => write_reply(&mut map, reply)?,
            Content::PositionOrTorque { value } => {
                map.serialize_entry("position_or_torque", value)?;
            }
            Content::Undecodable { error, .. } => {
                map.serialize_entry("error", &error.to_string())?;
            }
        }
        if let Some(ns) = self.response_ns() {
            map.serialize_entry("response_us", &(ns as f64 / 1e3))?;
        }
        if let Some(note) = self.note {
            map.serialize_entry("note", &note.to_string())?;
        }
        map.end()
    }
}

fn write_request<M: SerializeMap>(map: &mut M, request: &Request) -> Result<(), M::Error> {
    match request {
        Request::GoRelativePosPd(step) => map.serialize_entry("step_counts", &step.get()),
        Request::GoAbsolutePosPtp(to) | Request::GoAbsolutePosSync(to) => {
            map.serialize_entry("target_counts", &to.get())
        }
        Request::GoRelativePosPtp(by) | Request::GoRelativePosSync(by) => {
            map.serialize_entry("distance_counts", &by.get())
        }
        Request::MakeLinearLine(word) | Request::MakeCircularArc(word) => {
            map.serialize_entry("word_counts", &word.get())
        }
        Request::AssignDriveId(id) => map.serialize_entry("drive_id", &id.get()),
        Request::SetDriveConfig(config) => write_config(map, *config),
        Request::TurnConstSpeed(speed) => map.serialize_entry("speed_rpm", &speed.get()),
        Request::SquareWave(amplitude) | Request::SinWave(amplitude) => {
            map.serialize_entry("amplitude", &amplitude.get())
        }
        Request::SsFrequency(frequency) => map.serialize_entry("frequency_hz", &frequency.get()),
        Request::GeneralRead(selector) => map.serialize_entry(
            "reads",
            match selector {
                ReadSelector::Position => "position",
                ReadSelector::Torque => "torque",
            },
        ),
        Request::SetParamGroup1(group) => write_set_group1(map, group),
        Request::SetParamGroup2(group) => write_set_group2(map, group),
        Request::SetParamGroup3(group) => write_set_group3(map, group),
        Request::SyncTrigger(kind) => {
            map.serialize_entry("absolute", &(*kind == SyncKind::Absolute))
        }
        Request::ServoDisable(switch) => {
            map.serialize_entry("enable", &(*switch == ServoSwitch::Enable))
        }
        Request::EchoFunction(bytes) => map.serialize_entry("bytes", bytes),
        Request::SetOrigin
        | Request::ReadDriveId
        | Request::ReadDriveConfig
        | Request::ReadDriveStatus
        | Request::ReadParamGroup1
        | Request::ReadParamGroup2
        | Request::ReadParamGroup3
        | Request::ReadMotorSpeed
        | Request::DriveReset
        | Request::DiagnosticCounter => Ok(()),
    }
}

fn write_reply<M: SerializeMap>(map: &mut M, reply: &Reply) -> Result<(), M::Error> {
    match reply {
        Reply::DriveId(id) => map.serialize_entry("drive_id", &id.get()),
        Reply::DriveConfig(byte) => write_config_byte(map, *byte),
        Reply::DriveStatus(status) => write_status(map, *status),
        Reply::Position(counts) => map.serialize_entry("position_counts", counts),
        Reply::Torque(torque) => {
            map.serialize_entry("torque", &torque.raw)?;
            map.serialize_entry("torque_full_scale", &torque.full_scale.get())?;
            map.serialize_entry("torque_share_clockwise", &torque.of_peak())?;
            map.serialize_entry("torque_in_doubt", &torque.is_beyond_scale())
        }
        Reply::ParamGroup1(group) => write_group1(map, group),
        Reply::ParamGroup2(group) => write_group2(map, group),
        Reply::ParamGroup3(group) => write_group3(map, group),
        Reply::MotorSpeed(speed_rpm) => map.serialize_entry("speed_rpm", speed_rpm),
        Reply::DriveReset(byte) => map.serialize_entry("answer", byte),
        Reply::Echo(bytes) => map.serialize_entry("bytes", bytes),
        Reply::DiagnosticCounter(count) => map.serialize_entry("counter", count),
        Reply::DriveError(error) => map.serialize_entry("drive_error", &error.to_string()),
    }
}

fn write_status<M: SerializeMap>(map: &mut M, status: DriveStatus) -> Result<(), M::Error> {
    map.serialize_entry("on_position", &status.on_position())?;
    map.serialize_entry("disabled", &status.is_disabled())?;
    map.serialize_entry("alarm_code", &status.alarm().code())?;
    map.serialize_entry("alarm", &status.alarm().to_string())?;
    map.serialize_entry("motion_busy", &status.motion_busy())
}

fn write_config_byte<M: SerializeMap>(map: &mut M, byte: ConfigByte) -> Result<(), M::Error> {
    map.serialize_entry("config", &byte.to_byte())?;
    map.serialize_entry("command_mode", &(byte.command_mode() as u8))?;
    map.serialize_entry("servo_mode", &byte.servo_mode_code())?;
    map.serialize_entry("absolute_mode", &byte.absolute_mode())?;
    map.serialize_entry("servo_free", &byte.servo_free())
}

fn write_config<M: SerializeMap>(map: &mut M, config: DriveConfig) -> Result<(), M::Error> {
    write_config_byte(map, ConfigByte::from_byte(config.to_byte()))
}

fn write_group1<M: SerializeMap>(map: &mut M, group: &ParamGroup1) -> Result<(), M::Error> {
    map.serialize_entry("main_gain", &group.main_gain.get())?;
    map.serialize_entry("speed_gain", &group.speed_gain.get())?;
    map.serialize_entry("integration_gain", &group.integration_gain.get())?;
    map.serialize_entry("torque_filter", &group.torque_filter.get())
}

fn write_group2<M: SerializeMap>(map: &mut M, group: &ParamGroup2) -> Result<(), M::Error> {
    map.serialize_entry("max_speed", &group.max_speed.get())?;
    map.serialize_entry("max_acceleration", &group.max_acceleration.get())
}

fn write_group3<M: SerializeMap>(map: &mut M, group: &ParamGroup3) -> Result<(), M::Error> {
    map.serialize_entry("on_pos_range", &group.on_pos_range.get())?;
    map.serialize_entry("gear_number", &group.gear_number.get())?;
    map.serialize_entry("line_number", &group.line_number.map(|line| line.get()))
}

/// `null` keeps the stored value.
fn write_set_group1<M: SerializeMap>(map: &mut M, group: &SetParamGroup1) -> Result<(), M::Error> {
    map.serialize_entry("main_gain", &group.main_gain.map(|gain| gain.get()))?;
    map.serialize_entry("speed_gain", &group.speed_gain.map(|gain| gain.get()))?;
    map.serialize_entry(
        "integration_gain",
        &group.integration_gain.map(|gain| gain.get()),
    )?;
    map.serialize_entry(
        "torque_filter",
        &group.torque_filter.map(|filter| filter.get()),
    )
}

fn write_set_group2<M: SerializeMap>(map: &mut M, group: &SetParamGroup2) -> Result<(), M::Error> {
    map.serialize_entry("max_speed", &group.max_speed.map(|speed| speed.get()))?;
    map.serialize_entry(
        "max_acceleration",
        &group
            .max_acceleration
            .map(|acceleration| acceleration.get()),
    )
}

fn write_set_group3<M: SerializeMap>(map: &mut M, group: &SetParamGroup3) -> Result<(), M::Error> {
    map.serialize_entry("on_pos_range", &group.on_pos_range.map(|range| range.get()))?;
    map.serialize_entry("gear_number", &group.gear_number.map(|gear| gear.get()))?;
    map.serialize_entry("line_number", &group.line_number.map(|line| line.get()))
}
