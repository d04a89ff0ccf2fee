//! `dyn_can_replies.json`: frame to typed reply and back.

use std::path::Path;

use dyn_can::ZeroAddress;
use dyn_can::{
    Address, Alarm, DataFrame, Dialect, DriveError, FunctionCode, LineNumber, Reply, ReplyKind,
    Revision,
};
use serde::Deserialize;
use serde_json::{Map, Value, json};

use crate::frame_fields::{Command, Context, HexBytes, RevisionField, What, address, data_frame};
use crate::options::Options;
use crate::report::{Mismatch, Report, same};
use crate::vector_file::check_file;

/// The file name.
pub const FILE: &str = "dyn_can_replies.json";

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Vector {
    revision: RevisionField,
    drive_id: i32,
    command: Command,
    fc: u8,
    context: Context,
    fields: Map<String, Value>,
    canonical: bool,
    can_id: u32,
    dlc: usize,
    data: HexBytes,
    #[serde(default)]
    options: Options,
}

/// Each frame decodes to exactly the fields of its vector. A canonical frame is also what the reply encodes to; any other frame
/// re-encodes to one that decodes to the same value.
pub fn check(dir: &Path) -> Report {
    check_file(dir, FILE, check_vector)
}

fn check_vector(vector: Vector) -> Result<(), Mismatch> {
    let function = vector.command.0;
    same("fc", &vector.fc, &(function as u8))?;
    let frame = data_frame(vector.can_id, vector.dlc, &vector.data)?;
    let from = address(vector.drive_id).map_err(Mismatch::unreadable)?;
    let outstanding = outstanding(function, vector.context);
    let dialect = vector.options.dialect(
        Revision::from(vector.revision),
        ZeroAddress::DisableAndSpeedZero,
    );
    let (sender, reply) =
        Reply::decode(&frame, outstanding, &dialect).map_err(|error| Mismatch {
            expected: format!("fields {:?}", vector.fields),
            actual: format!("refused: {error}"),
        })?;
    same("sender", &from, &sender)?;
    same("fields", &Value::Object(vector.fields), &fields(&reply))?;
    if vector.canonical {
        same("frame", &frame, &reply.encode(from, &dialect))
    } else {
        survives_encoding(reply, from, outstanding, &dialect)
    }
}

fn survives_encoding(
    reply: Reply,
    from: Address,
    outstanding: Option<ReplyKind>,
    dialect: &Dialect,
) -> Result<(), Mismatch> {
    let encoded: DataFrame = reply.encode(from, dialect);
    same(
        "re-encoded",
        &Ok((from, reply)),
        &Reply::decode(&encoded, outstanding, dialect),
    )
}

/// The kind of reply that is awaited: General_Read where the context has a selector, otherwise that of the function; `None` for what a
/// drive sends unasked and for General_Read without selector.
pub fn outstanding(function: FunctionCode, context: Context) -> Option<ReplyKind> {
    Some(match (function, context.what) {
        (_, Some(What::Position)) => ReplyKind::Position,
        (_, Some(What::Torque)) => ReplyKind::Torque,
        (FunctionCode::ReadDriveId, None) => ReplyKind::DriveId,
        (FunctionCode::ReadDriveConfig, None) => ReplyKind::DriveConfig,
        (FunctionCode::ReadDriveStatus, None) => ReplyKind::DriveStatus,
        (FunctionCode::ReadParamGroup1, None) => ReplyKind::ParamGroup1,
        (FunctionCode::ReadParamGroup2, None) => ReplyKind::ParamGroup2,
        (FunctionCode::ReadParamGroup3, None) => ReplyKind::ParamGroup3,
        (FunctionCode::ReadMotorSpeed, None) => ReplyKind::MotorSpeed,
        (FunctionCode::DriveReset, None) => ReplyKind::DriveReset,
        (FunctionCode::EchoFunction, None) => ReplyKind::Echo,
        (FunctionCode::DiagnosticCounter, None) => ReplyKind::DiagnosticCounter,
        _ => return None,
    })
}

/// A reply in the field names of the vectors.
fn fields(reply: &Reply) -> Value {
    match *reply {
        Reply::DriveId(id) => json!({"drive_id": id.get()}),
        Reply::DriveConfig(config) => json!({
            "command_mode": config.command_mode() as u8,
            "absolute_mode": config.absolute_mode(),
            "servo_mode": config.servo_mode_code(),
            "disabled": config.servo_free(),
        }),
        Reply::DriveStatus(status) => json!({
            "on_position": status.on_position(),
            "servo_disabled": status.is_disabled(),
            "alarm": status.alarm().code(),
            "alarm_text": alarm_text(status.alarm()),
            "motion_busy": status.motion_busy(),
        }),
        Reply::Position(counts) => json!({"what": "position", "position_counts": counts}),
        Reply::Torque(torque) => json!({
            "what": "torque",
            "torque_raw": torque.raw,
            "full_scale": torque.full_scale.get(),
        }),
        Reply::ParamGroup1(group) => json!({
            "main_gain": group.main_gain.get(),
            "speed_gain": group.speed_gain.get(),
            "integration_gain": group.integration_gain.get(),
            "torque_filter": group.torque_filter.get(),
        }),
        Reply::ParamGroup2(group) => json!({
            "max_speed": group.max_speed.get(),
            "max_acceleration": group.max_acceleration.get(),
        }),
        Reply::ParamGroup3(group) => json!({
            "on_pos_range": group.on_pos_range.get(),
            "gear_number": group.gear_number.get(),
            "line_number": group.line_number.map_or(0, LineNumber::get),
        }),
        Reply::MotorSpeed(speed_rpm) => json!({"speed_rpm": speed_rpm}),
        Reply::DriveReset(raw) => json!({"raw": raw}),
        Reply::Echo(bytes) => json!({"payload_hex": hex(&bytes)}),
        Reply::DiagnosticCounter(counter) => json!({"counter": counter}),
        Reply::DriveError(error) => json!({"raw": error.to_byte(), "error": error_text(error)}),
    }
}

fn alarm_text(alarm: Alarm) -> String {
    match alarm {
        Alarm::None => "none".into(),
        Alarm::LostPhase => "lost_phase".into(),
        Alarm::OverCurrent => "over_current".into(),
        Alarm::OverheatOrOverpower => "overheat_or_overpower".into(),
        Alarm::CommandRefused => "crc_error_command_refused".into(),
        Alarm::Unknown(_) => format!("undocumented_{}", alarm.code()),
    }
}

fn error_text(error: DriveError) -> &'static str {
    match error {
        DriveError::DataError => "data_error",
        DriveError::Alarm => "alarm",
        DriveError::Unknown(_) => "unknown",
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
