//! `dyn_can_rejects.json`: what must be refused, and for which reason.

use std::path::Path;

use dyn_can::{
    DataFrame, DecodeError, Dialect, EncodeError, FrameError, FunctionCode, Refusal, Reply, Request, Revision,
    ZeroAddress,
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
        Vector::EncodeRequest { revision, drive_id, command, fc, args, code, options, .. } => {
            let function = command.0;
            same("fc", &fc.unwrap_or(function as u8), &(function as u8))?;
            let dialect = dialect(options, revision);
            expect_refusal(code, encode_request(drive_id, function, args, &dialect))
        }
        Vector::DecodeRequest { revision, frame, code, options, .. } => {
            expect_consistent(&frame)?;
            expect_refusal(code, decode_request(&frame, &dialect(options, revision)))
        }
        Vector::DecodeReply { revision, frame, code, context, options, .. } => {
            expect_consistent(&frame)?;
            let dialect = dialect(options, revision);
            expect_refusal(code, decode_reply(&frame, Context::default(), false, &dialect).and(
                decode_reply(&frame, context, true, &dialect)
            ))
        }
    }
}

fn dialect(options: Options, revision: RevisionField) -> Dialect {
    options.dialect(Revision::from(revision), ZeroAddress::Stop)
}
