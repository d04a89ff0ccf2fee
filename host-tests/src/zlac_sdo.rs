//! `zlac_sdo.json`: SDO frames of the ZLAC8030L, and what must be refused.

use std::path::Path;

use serde::Deserialize;
use zlac8030l::dictionary::{self, Entry};
use zlac8030l::{
    AbortCode, DataFrame, DecodeError, FrameError, Message, NodeId, ObjectAddress, SdoReply,
    SdoRequest, WriteError,
};

use crate::frame_fields::HexBytes;
use crate::report::{Mismatch, Report, same};
use crate::vector_file::check_file;

/// The file name.
pub const FILE: &str = "zlac_sdo.json";

/// The reasons that the vectors know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Code {
    Access,
    Address,
    Extended,
    Function,
    Length,
    Magic,
    Range,
    Remote,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Direction {
    ToServer,
    ToClient,
}

/// A frame that must be refused; a remote frame has a length code but no data.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RefusedFrame {
    can_id: u32,
    data: HexBytes,
    remote: bool,
    extended: bool,
    dlc: usize,
}

#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
enum Vector {
    Write {
        node: i32,
        direction: Direction,
        index: u16,
        sub: u8,
        size: u8,
        value: i64,
        #[serde(rename = "type")]
        data_type: String,
        #[serde(default)]
        unit: Option<String>,
        canonical: bool,
        can_id: u16,
        dlc: usize,
        data: HexBytes,
    },
    Read {
        node: i32,
        direction: Direction,
        index: u16,
        sub: u8,
        can_id: u16,
        dlc: usize,
        data: HexBytes,
    },
    ReadReply {
        node: i32,
        direction: Direction,
        index: u16,
        sub: u8,
        size: u8,
        value: i64,
        #[serde(rename = "type")]
        data_type: String,
        #[serde(default)]
        unit: Option<String>,
        can_id: u16,
        dlc: usize,
        data: HexBytes,
    },
    WriteAck {
        node: i32,
        direction: Direction,
        index: u16,
        sub: u8,
        can_id: u16,
        dlc: usize,
        data: HexBytes,
    },
    Abort {
        node: i32,
        direction: Direction,
        index: u16,
        sub: u8,
        abort_code: u32,
        abort_text: String,
        can_id: u16,
        dlc: usize,
        data: HexBytes,
    },
    RefuseWrite {
        node: i32,
        index: u16,
        sub: u8,
        value: i64,
        code: Code,
        #[serde(rename = "reason")]
        _reason: String,
    },
    RefuseFrame {
        frame: RefusedFrame,
        code: Code,
        #[serde(rename = "reason")]
        _reason: String,
    },
}

/// Each message encodes to its frame and back; each refusal is refused with the reason it names.
pub fn check(dir: &Path) -> Report {
    check_file(dir, FILE, check_vector)
}

fn check_vector(vector: Vector) -> Result<(), Mismatch> {
    match vector {
        Vector::Write {
            node,
            direction,
            index,
            sub,
            size,
            value,
            data_type,
            unit,
            canonical,
            can_id,
            dlc,
            data,
        } => {
            same("direction", &Direction::ToServer, &direction)?;
            let entry = entry(index, sub)?;
            check_columns(entry, size, &data_type, unit.as_deref())?;
            let request = entry.write(value).map_err(unexpected)?;
            let frame = data_frame(can_id, dlc, &data)?;
            same(
                "decoded",
                &Ok((node_id(node)?, request)),
                &SdoRequest::decode(&frame),
            )?;
            same(
                "canonical",
                &canonical,
                &(request.encode(node_id(node)?) == frame),
            )
        }
        Vector::Read {
            node,
            direction,
            index,
            sub,
            can_id,
            dlc,
            data,
        } => {
            same("direction", &Direction::ToServer, &direction)?;
            check_request(
                node,
                entry(index, sub)?.read(),
                data_frame(can_id, dlc, &data)?,
            )
        }
        Vector::ReadReply {
            node,
            direction,
            index,
            sub,
            size,
            value,
            data_type,
            unit,
            can_id,
            dlc,
            data,
        } => {
            same("direction", &Direction::ToClient, &direction)?;
            let entry = entry(index, sub)?;
            check_columns(entry, size, &data_type, unit.as_deref())?;
            let expected = entry
                .data_type
                .data(value)
                .ok_or_else(|| unexpected("a value beyond its type"))?;
            same("value", &Ok(value), &entry.data_type.value(expected))?;
            check_reply(
                node,
                SdoReply::Value(entry.address, expected),
                data_frame(can_id, dlc, &data)?,
            )
        }
        Vector::WriteAck {
            node,
            direction,
            index,
            sub,
            can_id,
            dlc,
            data,
        } => {
            same("direction", &Direction::ToClient, &direction)?;
            let reply = SdoReply::Written(ObjectAddress::new(index, sub));
            check_reply(node, reply, data_frame(can_id, dlc, &data)?)
        }
        Vector::Abort {
            node,
            direction,
            index,
            sub,
            abort_code,
            abort_text,
            can_id,
            dlc,
            data,
        } => {
            same("direction", &Direction::ToClient, &direction)?;
            let code = AbortCode::new(abort_code);
            check_words(&abort_text, code)?;
            let reply = SdoReply::Abort(ObjectAddress::new(index, sub), code);
            check_reply(node, reply, data_frame(can_id, dlc, &data)?)
        }
        Vector::RefuseWrite {
            node,
            index,
            sub,
            value,
            code,
            ..
        } => expect_refusal(
            code,
            encode_write(node, ObjectAddress::new(index, sub), value),
        ),
        Vector::RefuseFrame { frame, code, .. } => expect_refusal(code, decode_refused(&frame)),
    }
}

fn check_request(node: i32, request: SdoRequest, frame: DataFrame) -> Result<(), Mismatch> {
    let node = node_id(node)?;
    same("frame", &frame, &request.encode(node))?;
    same("decoded", &Ok((node, request)), &SdoRequest::decode(&frame))
}

fn check_reply(node: i32, reply: SdoReply, frame: DataFrame) -> Result<(), Mismatch> {
    let node = node_id(node)?;
    same("frame", &frame, &reply.encode(node))?;
    same("decoded", &Ok((node, reply)), &SdoReply::decode(&frame))
}

fn check_columns(
    entry: &Entry,
    size: u8,
    data_type: &str,
    unit: Option<&str>,
) -> Result<(), Mismatch> {
    same("size", &size, &entry.data_type.bytes())?;
    same("type", &data_type, &entry.data_type.to_string().as_str())?;
    unit.map_or(Ok(()), |unit| same("unit", &unit, &entry.unit))
}

/// Every word of the vector's text occurs in ours.
fn check_words(text: &str, code: AbortCode) -> Result<(), Mismatch> {
    let ours = code.text().unwrap_or_default();
    let missing = text.split(' ').find(|word| !ours.contains(word));
    same("missing word of the abort text", &None, &missing)
}

fn entry(index: u16, sub: u8) -> Result<&'static Entry, Mismatch> {
    let address = ObjectAddress::new(index, sub);
    dictionary::find(address).ok_or_else(|| unexpected(format!("no {address} in the dictionary")))
}

pub(crate) fn node_id(node: i32) -> Result<NodeId, Mismatch> {
    NodeId::new(node).map_err(Mismatch::unreadable)
}

pub(crate) fn data_frame(can_id: u16, dlc: usize, data: &HexBytes) -> Result<DataFrame, Mismatch> {
    same("dlc", &dlc, &data.0.len())?;
    DataFrame::new(can_id, &data.0).map_err(Mismatch::unreadable)
}

fn unexpected(reason: impl std::fmt::Display) -> Mismatch {
    Mismatch {
        expected: "accepted".into(),
        actual: format!("refused: {reason}"),
    }
}

/// A refusal with its code where the vectors have one, and in words.
type Refused = (Option<Code>, String);

pub(crate) fn expect_refusal(
    expected: Code,
    outcome: Result<String, Refused>,
) -> Result<(), Mismatch> {
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

fn encode_write(node: i32, address: ObjectAddress, value: i64) -> Result<String, Refused> {
    let node = NodeId::new(node).map_err(|error| (Some(Code::Address), error.to_string()))?;
    let request = dictionary::write(address, value).map_err(of_write_error)?;
    Ok(request.encode(node).to_string())
}

pub(crate) fn decode_refused(frame: &RefusedFrame) -> Result<String, Refused> {
    if !frame.remote && frame.dlc != frame.data.0.len() {
        return Err((
            None,
            "the vector contradicts itself: dlc and data differ".into(),
        ));
    }
    let frame = DataFrame::from_parts(frame.can_id, frame.extended, frame.remote, &frame.data.0)
        .map_err(of_frame_error)?;
    Message::decode(&frame)
        .map_err(of_decode_error)
        .map(|message| message.to_string())
}

fn of_write_error(error: WriteError) -> Refused {
    let code = match error {
        WriteError::NoSuchObject { .. } => Some(Code::Function),
        WriteError::ReadOnly { .. } => Some(Code::Access),
        WriteError::Range { .. } => Some(Code::Range),
        _ => None,
    };
    (code, error.to_string())
}

fn of_frame_error(error: FrameError) -> Refused {
    let code = match error {
        FrameError::Extended { .. } => Some(Code::Extended),
        FrameError::Remote { .. } => Some(Code::Remote),
        FrameError::Identifier { .. } => Some(Code::Address),
        FrameError::DataLength { .. } => Some(Code::Length),
        _ => None,
    };
    (code, error.to_string())
}

fn of_decode_error(error: DecodeError) -> Refused {
    let code = match error {
        DecodeError::Node { .. } => Some(Code::Address),
        DecodeError::Length { .. } => Some(Code::Length),
        DecodeError::Specifier { .. }
        | DecodeError::NmtState { .. }
        | DecodeError::NmtCommand { .. } => Some(Code::Magic),
        _ => None,
    };
    (code, error.to_string())
}
