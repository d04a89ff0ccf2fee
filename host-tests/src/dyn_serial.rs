//! `dyn232m.json`: serial packets of both directions, refusals, and streams with errors.

use std::path::Path;

use dyn_serial::{
    Address, ConfigByte, DecodeError, Decoder, Dialect, DriveId, DriveStatus, Dummy, EncodeError,
    Event, Packet, PacketError, ParameterForm, Quantity, RangeError, ReadSelector, Reply,
    ReplyFunction, Request, RequestFunction,
};
use serde::Deserialize;

use crate::frame_fields::HexBytes;
use crate::report::{Mismatch, Report, same};
use crate::vector_file::check_file;

/// The file name.
pub const FILE: &str = "dyn232m.json";

/// The reasons that the vectors know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Code {
    Address,
    Broadcast,
    Checksum,
    Format,
    Function,
    Length,
    Magic,
    Range,
}

/// One event of a stream, with the bytes that belong to it.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
struct StreamEvent {
    event: EventName,
    bytes: HexBytes,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum EventName {
    Packet,
    Stray,
    Truncated,
    Checksum,
}

/// A message with its number.
#[derive(Debug, Deserialize)]
struct Message {
    drive_id: i32,
    fc: u8,
    value: i32,
    data_bytes: u8,
    packet: HexBytes,
    #[serde(default)]
    function: Option<String>,
}

/// The fields differ by kind.
#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
enum Vector {
    Request(Message),
    Reply(Message),
    SampleCodePacket(Message),
    RejectPacket {
        packet: HexBytes,
        code: Code,
        #[serde(rename = "reason")]
        _reason: String,
    },
    RejectRequest {
        drive_id: i32,
        function: String,
        value: i32,
        code: Code,
        #[serde(rename = "reason")]
        _reason: String,
    },
    Stream {
        stream: HexBytes,
        events: Vec<StreamEvent>,
    },
}

/// A refusal as the codec words it, with its code where the vectors have one.
type Refused = (Option<Code>, String);

/// Each message has exactly the packet of its vector, both ways; each refusal its reason; each stream its events.
pub fn check(dir: &Path) -> Report {
    check_file(dir, FILE, check_vector)
}

/// Every packet of the file, requests and replies.
///
/// # Errors
/// When the file cannot be read or has another schema.
pub fn packets(dir: &Path) -> Result<Vec<Vec<u8>>, Box<dyn std::error::Error>> {
    #[derive(Deserialize)]
    struct Any {
        kind: String,
        packet: Option<HexBytes>,
    }
    let vectors: Vec<Any> = serde_json::from_str(&std::fs::read_to_string(dir.join(FILE))?)?;
    let messages = vectors
        .into_iter()
        .filter(|vector| vector.kind == "request" || vector.kind == "reply");
    Ok(messages
        .filter_map(|vector| Some(vector.packet?.0))
        .collect())
}

fn check_vector(vector: Vector) -> Result<(), Mismatch> {
    match vector {
        Vector::Request(message) => check_request(&message, ParameterForm::Table),
        Vector::SampleCodePacket(message) => check_request(&message, ParameterForm::ShortestSigned),
        Vector::Reply(message) => check_reply(&message),
        Vector::RejectPacket { packet, code, .. } => {
            expect_no_packet_in(&packet.0, code)?;
            expect_refusal(code, decode_reply(&packet.0))
        }
        Vector::RejectRequest {
            drive_id,
            function,
            value,
            code,
            ..
        } => {
            let function = request_function(&function)?;
            expect_refusal(code, encode_request(drive_id, function, value))
        }
        Vector::Stream { stream, events } => same("events", &events, &decode_stream(&stream.0)),
    }
}

fn check_request(message: &Message, parameter_form: ParameterForm) -> Result<(), Mismatch> {
    let function = RequestFunction::from_code(message.fc)
        .ok_or_else(|| Mismatch::unreadable(format!("no function {:#x}", message.fc)))?;
    if let Some(name) = &message.function {
        same("function", &name.as_str(), &function.name())?;
    }
    let (request, dummy) =
        request(function, message.value).map_err(|(_, reason)| Mismatch::unreadable(reason))?;
    let dialect = Dialect {
        parameter_form,
        dummy: dummy.unwrap_or(Dialect::MANUAL.dummy),
        ..Dialect::MANUAL
    };
    let to = start_byte(message)?;
    let packet = request.encode(to, &dialect).map_err(Mismatch::unreadable)?;
    expect_packet(message, &packet)?;
    same(
        "decoded",
        &Ok((to, request)),
        &Request::decode(&packet, &dialect),
    )
}

fn check_reply(message: &Message) -> Result<(), Mismatch> {
    let Address::Drive(from) = start_byte(message)? else {
        return Err(Mismatch::unreadable("a reply from every drive"));
    };
    let function = ReplyFunction::from_code(message.fc)
        .ok_or_else(|| Mismatch::unreadable(format!("no reply {:#x}", message.fc)))?;
    if let Some(name) = &message.function {
        same("function", &name.as_str(), &function.name())?;
    }
    let reply = reply(function, message.value).map_err(Mismatch::unreadable)?;
    let packet = reply.encode(from);
    expect_packet(message, &packet)?;
    same("decoded", &Ok((from, reply)), &Reply::decode(&packet))
}

fn start_byte(message: &Message) -> Result<Address, Mismatch> {
    let byte = u8::try_from(message.drive_id).map_err(Mismatch::unreadable)?;
    Address::from_start_byte(byte).map_err(Mismatch::unreadable)
}

fn expect_packet(message: &Message, packet: &Packet) -> Result<(), Mismatch> {
    same(
        "packet",
        &message.packet,
        &HexBytes(packet.as_bytes().into()),
    )?;
    same("data bytes", &message.data_bytes, &packet.data_len())?;
    same("parsed", &Ok(*packet), &Packet::parse(&message.packet.0))
}

fn request_function(name: &str) -> Result<RequestFunction, Mismatch> {
    let found = RequestFunction::ALL
        .iter()
        .find(|function| function.name() == name);
    found
        .copied()
        .ok_or_else(|| Mismatch::unreadable(format!("unknown function {name:?}")))
}

/// The request of a function and its number, with the dummy byte where the function has no number.
fn request(function: RequestFunction, value: i32) -> Result<(Request, Option<Dummy>), Refused> {
    use RequestFunction as F;
    let request = match function {
        F::GoAbsolutePos => Request::GoAbsolutePos(checked(value)?),
        F::MakeLinearLine => Request::MakeLinearLine(checked(value)?),
        F::GoRelativePos => Request::GoRelativePos(checked(value)?),
        F::MakeCircularArc => Request::MakeCircularArc(checked(value)?),
        F::AssignDriveId => Request::AssignDriveId(checked(value)?),
        F::SetDriveConfig => Request::SetDriveConfig(ConfigByte::new(value).map_err(range)?),
        F::TurnConstSpeed => Request::TurnConstSpeed(checked(value)?),
        F::SquareWave => Request::SquareWave(checked(value)?),
        F::SinWave => Request::SinWave(checked(value)?),
        F::SsFrequency => Request::SsFrequency(checked(value)?),
        F::GeneralRead => Request::GeneralRead(selector(value)?),
        F::SetMainGain => Request::SetMainGain(checked(value)?),
        F::SetSpeedGain => Request::SetSpeedGain(checked(value)?),
        F::SetIntGain => Request::SetIntGain(checked(value)?),
        F::SetTrqCons => Request::SetTrqCons(checked(value)?),
        F::SetHighSpeed => Request::SetHighSpeed(checked(value)?),
        F::SetHighAccel => Request::SetHighAccel(checked(value)?),
        F::SetPosOnRange => Request::SetPosOnRange(checked(value)?),
        F::SetGearNumber => Request::SetGearNumber(checked(value)?),
        _ => return Ok((without_number(function)?, Some(checked(value)?))),
    };
    Ok((request, None))
}

fn without_number(function: RequestFunction) -> Result<Request, Refused> {
    use RequestFunction as F;
    Ok(match function {
        F::SetOrigin => Request::SetOrigin,
        F::ReadDriveId => Request::ReadDriveId,
        F::ReadDriveConfig => Request::ReadDriveConfig,
        F::ReadDriveStatus => Request::ReadDriveStatus,
        F::ReadMainGain => Request::ReadMainGain,
        F::ReadSpeedGain => Request::ReadSpeedGain,
        F::ReadIntGain => Request::ReadIntGain,
        F::ReadTrqCons => Request::ReadTrqCons,
        F::ReadHighSpeed => Request::ReadHighSpeed,
        F::ReadHighAccel => Request::ReadHighAccel,
        F::ReadPosOnRange => Request::ReadPosOnRange,
        F::ReadGearNumber => Request::ReadGearNumber,
        other => return Err((Some(Code::Function), format!("{other} has no request"))),
    })
}

fn checked<T: TryFrom<i32, Error = RangeError>>(value: i32) -> Result<T, Refused> {
    T::try_from(value).map_err(range)
}

fn range(error: RangeError) -> Refused {
    (Some(Code::Range), error.to_string())
}

fn selector(value: i32) -> Result<ReadSelector, Refused> {
    let code = u8::try_from(value).ok();
    code.and_then(ReadSelector::from_code).ok_or_else(|| {
        let reason = format!("{value:#x} selects nothing");
        (Some(Code::Magic), reason)
    })
}

fn reply(function: ReplyFunction, value: i32) -> Result<Reply, RangeError> {
    use ReplyFunction as F;
    Ok(match function {
        F::IsMainGain => Reply::MainGain(value.try_into()?),
        F::IsSpeedGain => Reply::SpeedGain(value.try_into()?),
        F::IsIntGain => Reply::IntegrationGain(value.try_into()?),
        F::IsTrqCons => Reply::TorqueFilter(value.try_into()?),
        F::IsHighSpeed => Reply::MaxSpeed(value.try_into()?),
        F::IsHighAccel => Reply::MaxAcceleration(value.try_into()?),
        F::IsDriveId => Reply::DriveId(value.try_into()?),
        F::IsPosOnRange => Reply::OnPosRange(value.try_into()?),
        F::IsGearNumber => Reply::GearNumber(value.try_into()?),
        F::IsStatus => Reply::Status(DriveStatus::from_byte(value as u8)),
        F::IsConfig => Reply::Config(ConfigByte::new(value)?),
        F::IsAbsPos32 => Reply::Position(value.try_into()?),
        F::IsTrqCurrent => Reply::Torque(Quantity::SerialTorque.check(value)? as i16),
    })
}

fn encode_request(drive_id: i32, function: RequestFunction, value: i32) -> Result<String, Refused> {
    let address = |error: RangeError| (Some(Code::Address), error.to_string());
    let to = match drive_id {
        127 => Address::All,
        id => Address::Drive(DriveId::new(id).map_err(address)?),
    };
    let (request, _) = request(function, value)?;
    let packet = request.encode(to, &Dialect::MANUAL).map_err(|error| {
        let code = match error {
            EncodeError::Broadcast { .. } => Some(Code::Broadcast),
            EncodeError::Range(_) => Some(Code::Range),
            _ => None,
        };
        (code, error.to_string())
    })?;
    Ok(packet.to_string())
}

fn decode_reply(bytes: &[u8]) -> Result<String, Refused> {
    let packet = Packet::parse(bytes).map_err(|error| {
        let code = match error {
            PacketError::Length { .. } => Some(Code::Length),
            PacketError::StartByte { .. } | PacketError::InnerByte { .. } => Some(Code::Format),
            PacketError::Checksum { .. } => Some(Code::Checksum),
            _ => None,
        };
        (code, error.to_string())
    })?;
    let (from, reply) = Reply::decode(&packet).map_err(|error| {
        let code = match error {
            DecodeError::UnknownReply { .. } => Some(Code::Function),
            DecodeError::Length { .. } => Some(Code::Length),
            DecodeError::Range(_) => Some(Code::Range),
            _ => None,
        };
        (code, error.to_string())
    })?;
    Ok(format!("{reply:?} from drive {from}"))
}

fn expect_refusal(expected: Code, outcome: Result<String, Refused>) -> Result<(), Mismatch> {
    let actual = match outcome {
        Err((Some(code), _)) if code == expected => return Ok(()),
        Err((Some(code), reason)) => format!("refused as {code:?}: {reason}"),
        Err((None, reason)) => reason,
        Ok(accepted) => format!("accepted: {accepted}"),
    };
    Err(Mismatch {
        expected: format!("refused as {expected:?}"),
        actual,
    })
}

/// Bytes that are no packet must not be one in a stream either.
fn expect_no_packet_in(bytes: &[u8], code: Code) -> Result<(), Mismatch> {
    let events = decode_stream(bytes);
    let found = events.iter().any(|found| found.event == EventName::Packet);
    let is_packet = !matches!(code, Code::Checksum | Code::Format);
    same("packet in the stream", &is_packet, &found)
}

fn decode_stream(stream: &[u8]) -> Vec<StreamEvent> {
    let mut decoder = Decoder::new();
    let events = stream.iter().filter_map(|byte| decoder.push(*byte));
    events
        .map(|event| {
            let (event, bytes) = match event {
                Event::Packet(packet) => (EventName::Packet, packet.as_bytes().into()),
                Event::Stray(byte) => (EventName::Stray, vec![byte]),
                Event::Truncated(fragment) => (EventName::Truncated, fragment.as_bytes().into()),
                Event::Checksum { received, .. } => {
                    (EventName::Checksum, received.as_bytes().into())
                }
            };
            let bytes = HexBytes(bytes);
            StreamEvent { event, bytes }
        })
        .collect()
}
