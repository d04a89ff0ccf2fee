//! `dyn_can_rejects.json`: what must be refused, and for which reason.

use std::path::Path;

use dyn_can::{
    DataFrame, DecodeError, Dialect, EncodeError, FrameError, FunctionCode, Refusal, Reply,
    ReplyKind, Request, Revision, ZeroAddress,
};
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::arguments::{self, ArgumentError};
use crate::dyn_can_replies::outstanding;
use crate::frame_fields::{Command, Context, HexBytes, RevisionField, address};
use crate::options::Options;
use crate::report::{Mismatch, Report, same};
use crate::vector_file::check_file;

/// The file name.
pub const FILE: &str = "dyn_can_rejects.json";

/// The reasons that the vectors know.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Code {
    Address,
    Broadcast,
    ByteOrder,
    Extended,
    Function,
    Length,
    Magic,
    Range,
    Remote,
    Revision,
    Type,
}

/// Why the vector is a refusal.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Basis {
    Spec,
    Policy,
    Ambiguous,
}

/// What a drive does with such a frame; the simulator's business, here only checked for unknown words.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
enum DriveReaction {
    DataError,
    Ignore,
    Unspecified,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Frame {
    can_id: u32,
    data: HexBytes,
    remote: bool,
    extended: bool,
    dlc: usize,
}

/// The fields differ by stage.
#[derive(Debug, Deserialize)]
#[serde(tag = "stage", rename_all = "snake_case", deny_unknown_fields)]
enum Vector {
    EncodeRequest {
        revision: RevisionField,
        drive_id: i32,
        command: Command,
        #[serde(default)]
        fc: Option<u8>,
        args: Map<String, Value>,
        code: Code,
        #[serde(rename = "basis")]
        _basis: Basis,
        #[serde(rename = "reason")]
        _reason: String,
        #[serde(default)]
        options: Options,
    },
    DecodeRequest {
        revision: RevisionField,
        frame: Frame,
        code: Code,
        #[serde(rename = "basis")]
        _basis: Basis,
        #[serde(rename = "reason")]
        _reason: String,
        #[serde(rename = "drive_reaction", default)]
        _drive_reaction: Option<DriveReaction>,
        #[serde(default)]
        options: Options,
    },
    DecodeReply {
        revision: RevisionField,
        frame: Frame,
        code: Code,
        #[serde(rename = "basis")]
        _basis: Basis,
        #[serde(rename = "reason")]
        _reason: String,
        #[serde(default)]
        context: Context,
        #[serde(default)]
        options: Options,
    },
}

/// A refusal as the codec words it, with its code where the vectors have one.
type Refused = (Option<Code>, String);

/// Each vector is refused with exactly the reason it names.
pub fn check(dir: &Path) -> Report {
    check_file(dir, FILE, check_vector)
}

fn check_vector(vector: Vector) -> Result<(), Mismatch> {
    match vector {
        Vector::EncodeRequest {
            revision,
            drive_id,
            command,
            fc,
            args,
            code,
            options,
            ..
        } => {
            let function = command.0;
            same("fc", &fc.unwrap_or(function as u8), &(function as u8))?;
            let dialect = dialect_of(options, revision);
            expect_refusal(code, encode_request(drive_id, function, args, &dialect))
        }
        Vector::DecodeRequest {
            revision,
            frame,
            code,
            options,
            ..
        } => {
            expect_consistent(&frame)?;
            expect_refusal(code, decode_request(&frame, &dialect_of(options, revision)))
        }
        Vector::DecodeReply {
            revision,
            frame,
            code,
            context,
            options,
            ..
        } => {
            expect_consistent(&frame)?;
            let dialect = dialect_of(options, revision);
            // What a reply lacks must not depend on whether its request is known.
            let awaited = awaited(&frame, context);
            awaited
                .iter()
                .try_for_each(|kind| expect_refusal(code, decode_reply(&frame, *kind, &dialect)))
        }
    }
}

fn dialect_of(options: Options, revision: RevisionField) -> Dialect {
    let options = options.with_printed_group3_order();
    options.dialect(Revision::from(revision), ZeroAddress::DisableAndSpeedZero)
}

/// A remote frame has a length code but no data; any other frame has as many bytes as its length code says.
fn expect_consistent(frame: &Frame) -> Result<(), Mismatch> {
    if frame.remote {
        Ok(())
    } else {
        same("dlc", &frame.dlc, &frame.data.0.len())
    }
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

fn encode_request(
    drive_id: i32,
    function: FunctionCode,
    args: Map<String, Value>,
    dialect: &Dialect,
) -> Result<String, Refused> {
    let to = address(drive_id).map_err(|error| (Some(Code::Address), error.to_string()))?;
    let request =
        arguments::request(function, dialect.revision, args).map_err(of_argument_error)?;
    let frame = request.encode(to, dialect).map_err(of_encode_error)?;
    Ok(format!("{frame:?}"))
}

fn decode_request(frame: &Frame, dialect: &Dialect) -> Result<String, Refused> {
    let frame = data_frame(frame)?;
    let (to, request) = Request::decode(&frame, dialect).map_err(of_decode_error)?;
    Ok(format!("{request:?} to {to}"))
}

fn decode_reply(
    frame: &Frame,
    outstanding: Option<ReplyKind>,
    dialect: &Dialect,
) -> Result<String, Refused> {
    let frame = data_frame(frame)?;
    let (from, reply) = Reply::decode(&frame, outstanding, dialect).map_err(of_decode_error)?;
    // The codec hands such a torque on as a value in doubt, so that a drive with another scale is not taken for a lost one.
    if let Reply::Torque(torque) = reply
        && torque.is_beyond_scale()
    {
        return Err((Some(Code::Range), format!("in doubt: {torque:?}")));
    }
    Ok(format!("{reply:?} from {from}"))
}

fn data_frame(frame: &Frame) -> Result<DataFrame, Refused> {
    DataFrame::from_parts(frame.can_id, frame.extended, frame.remote, &frame.data.0)
        .map_err(of_frame_error)
}

/// The outstanding requests under which the frame must be refused: a selector decides, otherwise with and without the request.
fn awaited(frame: &Frame, context: Context) -> Vec<Option<ReplyKind>> {
    let function = FunctionCode::from_can_id((frame.can_id & 0x7FF) as u16);
    let kind = outstanding(function, context);
    if context.what.is_some() || kind.is_none() {
        vec![kind]
    } else {
        vec![None, kind]
    }
}

fn of_argument_error(error: ArgumentError) -> Refused {
    let code = match &error {
        ArgumentError::Range(_) | ArgumentError::BeyondI32(_) => Some(Code::Range),
        ArgumentError::Type(_) => Some(Code::Type),
        ArgumentError::Length(_) => Some(Code::Length),
        ArgumentError::Variant(_) => Some(Code::Magic),
        ArgumentError::Refused(refusal) => of_refusal(*refusal),
        ArgumentError::Schema(_) => None,
    };
    (code, error.to_string())
}

fn of_encode_error(error: EncodeError) -> Refused {
    let code = match error {
        EncodeError::Refused(refusal) => of_refusal(refusal),
        EncodeError::Broadcast { .. } => Some(Code::Broadcast),
        EncodeError::Range(_) => Some(Code::Range),
        _ => None,
    };
    (code, error.to_string())
}

fn of_decode_error(error: DecodeError) -> Refused {
    let code = match error {
        DecodeError::Refused(refusal) => of_refusal(refusal),
        DecodeError::Broadcast { .. } => Some(Code::Broadcast),
        DecodeError::Length { .. } | DecodeError::NotShortest { .. } => Some(Code::Length),
        DecodeError::Magic { .. } => Some(Code::Magic),
        DecodeError::Range(_) => Some(Code::Range),
        DecodeError::SelectorUnknown => Some(Code::Type),
        DecodeError::ByteOrder { .. } => Some(Code::ByteOrder),
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

fn of_refusal(refusal: Refusal) -> Option<Code> {
    match refusal {
        Refusal::Factory | Refusal::DriveOnly | Refusal::NoReply { .. } => Some(Code::Function),
        Refusal::Revision { .. } => Some(Code::Revision),
        _ => None,
    }
}
