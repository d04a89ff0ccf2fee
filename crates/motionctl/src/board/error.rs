//! Why nothing came of a command to a board.

use core::fmt;
use std::io;
use std::path::PathBuf;

use board_link::frame::VERSION;
use board_link::host::RequestError;
use board_link::message::{BoardState, Refused};
use dyn_can::{DriveId, GearNumber, units};
use trajectory::RangeError;

use super::words::refusal;
use crate::backup::FileFault;
use crate::confirm::NotConfirmed;
use crate::endpoint::EndpointError;
use crate::exit::{self, Coded};
use crate::link::OpenError;
use crate::program::ProgramFileError;
use crate::recording::RecordingError;
use crate::station::LimitError;
use crate::trajectory::MotionError;

/// A command to a board that did not come to its end.
#[derive(Debug)]
pub(crate) enum BoardError {
    /// The port cannot be opened.
    Open(OpenError),
    /// The port failed, or is gone.
    Port { port: String, source: io::Error },
    /// Nobody answers.
    NoAnswer { port: String, seconds: f64 },
    /// A board answers in another version of the protocol.
    OtherVersion { port: String },
    /// The board cannot be used now: another version, or another host commands.
    Unavailable { port: String, refused: Refused },
    /// The board refuses what it was asked for.
    Refused {
        what: &'static str,
        refused: Refused,
    },
    /// A request has no answer.
    Request {
        what: &'static str,
        source: RequestError,
    },
    /// The board was reset, or the connection was lost.
    Reset { what: &'static str },
    /// An answer to another question.
    Unexpected { what: &'static str },
    /// The board has no settings.
    NoSettings { port: String },
    /// The settings ask for no homing.
    NoHoming,
    /// An axis is to be homed, and is not.
    NotHomed { drive: DriveId },
    /// A homed axis stands elsewhere than where its motion begins.
    Start {
        drive: DriveId,
        expected_turns: f64,
        actual_turns: f64,
    },
    /// The settings of the board are not settings.
    UnreadableSettings(board_settings::Refusal),
    /// A file of settings cannot be read.
    ReadFile { path: PathBuf, source: io::Error },
    /// A file has something else in it.
    SettingsFile { path: PathBuf, reason: String },
    /// This version does not know the board.
    UnknownBoard { board: String },
    /// A file would be overwritten, or cannot be written.
    WriteFile(FileFault),
    /// The options make no motion.
    Motion(MotionError),
    /// The motion needs more than is allowed.
    Limit(LimitError),
    /// The program cannot be played again.
    Program(ProgramFileError),
    /// The motion has another number of axes than the board, and nothing says which.
    Drives { axes: usize, board: Vec<DriveId> },
    /// The board has no such drive.
    NoDrive { drive: DriveId, board: Vec<DriveId> },
    /// The gear number that the motion was made for, and that of the board.
    Gear {
        drive: DriveId,
        expected: GearNumber,
        actual: GearNumber,
    },
    /// The motion breaks what the board allows.
    Preview {
        segment: u32,
        at_s: f64,
        refused: Refused,
        drive: Option<DriveId>,
    },
    /// There are no frames to record.
    NoFrames,
    /// A file where set-points come from another program.
    FileOfStream,
    /// Limits that a trajectory cannot have.
    Range(RangeError),
    /// The board does not get ready.
    NotReady { state: BoardState },
    /// Nobody can be listened to.
    Control(EndpointError),
    /// A recording cannot begin.
    Recording(RecordingError),
    /// Nobody agreed.
    NotConfirmed(NotConfirmed),
    /// Signals cannot be listened to.
    Interrupt(io::Error),
    /// The result cannot be written.
    Print(io::Error),
}

impl Coded for BoardError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Open(_)
            | Self::Port { .. }
            | Self::NoAnswer { .. }
            | Self::Request { .. }
            | Self::Reset { .. }
            | Self::Unexpected { .. } => exit::LINK_FAILED,
            Self::Unavailable { .. }
            | Self::OtherVersion { .. }
            | Self::Refused { .. }
            | Self::NotReady { .. }
            | Self::NotHomed { .. }
            | Self::Print(_) => exit::BROKEN_PROMISE,
            _ => exit::BAD_INPUT,
        }
    }
}

impl fmt::Display for BoardError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open(source) => source.fmt(f),
            Self::Port { port, source } => write!(
                f,
                "the port {port} failed: {source}. A board that lost its host stops after half a second; plug it in again"
            ),
            Self::NoAnswer { port, seconds } => write!(
                f,
                "no motion board answers at {port} within {seconds} s: check cable, power and --baud; `motionctl board find` asks other ports"
            ),
            Self::OtherVersion { port } => write!(
                f,
                "the board at {port} speaks another version of the protocol than this tool, which has version {VERSION}: use the tool of its version, or update the board; `motionctl board find` says which it is"
            ),
            Self::Unavailable { port, refused } => {
                write!(f, "the board at {port} cannot be used: {}", refusal(refused))
            }
            Self::Refused { what, refused } => {
                write!(f, "the board refuses to {what}: {}", refusal(refused))
            }
            Self::Request { what, source } => write!(f, "cannot {what}: {source}"),
            Self::Reset { what } => write!(
                f,
                "cannot {what}: the board was reset, or did not hear this program for too long. Its axes have stopped; read its state with `motionctl board info`"
            ),
            Self::Unexpected { what } => write!(
                f,
                "cannot {what}: the board answers something else; use the version of this tool that fits its firmware"
            ),
            Self::NoSettings { port } => write!(
                f,
                "the board at {port} has no settings, so it moves nothing: write them with `motionctl board settings set FILE`"
            ),
            Self::NoHoming => f.write_str(
                "the settings of the board ask for no homing: expected homing = \"stop\", \"switch\" or \"here\" at an axis; write them with `motionctl board settings set FILE`",
            ),
            Self::NotHomed { drive } => write!(
                f,
                "the axis of drive {drive} is to be homed, and is not: run `motionctl board home` first, which leaves the drives enabled; the board forgets the origins when they are not. Nothing has moved"
            ),
            Self::Start {
                drive,
                expected_turns,
                actual_turns,
            } => write!(
                f,
                "the motion of drive {drive} begins at {expected_turns:.4} turns of its motor, and its homed axis stands at {actual_turns:.4}: let it begin there, or choose homing_reference_millidegrees or homing_back_off_millidegrees so that the axis rests there. Nothing has moved"
            ),
            Self::UnreadableSettings(refusal) => write!(
                f,
                "the settings of the board cannot be read: {refusal}. Use the version of this tool that fits its firmware"
            ),
            Self::ReadFile { path, source } => {
                write!(f, "cannot read {}: {source}", path.display())
            }
            Self::SettingsFile { path, reason } => write!(f, "{}: {reason}", path.display()),
            Self::UnknownBoard { board } => write!(
                f,
                "this version knows no board {board:?}, so it cannot check its settings: expected one of {}",
                known_boards()
            ),
            Self::WriteFile(source) => source.fmt(f),
            Self::Motion(source) => source.fmt(f),
            Self::Limit(source) => source.fmt(f),
            Self::Program(source) => source.fmt(f),
            Self::Drives { axes, board } => write!(
                f,
                "the motion has {axes} axes, the board has {}, drives {}: say with --drives which they are",
                board.len(),
                ids(board)
            ),
            Self::NoDrive { drive, board } => write!(
                f,
                "the board has no drive {drive}, its drives are {}: choose from them with --drives, or change its settings",
                ids(board)
            ),
            Self::Gear {
                drive,
                expected,
                actual,
            } => write!(
                f,
                "the motion of drive {drive} was made for {} counts a turn, the settings of the board say {} (gear number {actual}): give --counts-per-turn {}",
                units::command_counts_per_turn(*expected),
                units::command_counts_per_turn(*actual),
                units::command_counts_per_turn(*actual)
            ),
            Self::Preview {
                segment,
                at_s,
                refused,
                drive,
            } => {
                write!(f, "the board would refuse segment {segment}, {at_s:.3} s after the start")?;
                if let Some(drive) = drive {
                    write!(f, ", because of drive {drive}")?;
                }
                write!(f, ": {}. Nothing has moved", refusal(refused))
            }
            Self::NoFrames => f.write_str(
                "--candump: the frames are on the bus of the board, where this computer does not see them; record them with an adapter and `motionctl record`",
            ),
            Self::FileOfStream => f.write_str(
                "set-points come from another program: expected no --trajectory and no --program; `motionctl board run` plays files",
            ),
            Self::Range(source) => write!(
                f,
                "the limits of the options and of the board: {source}; choose other ones with --max-rpm, --max-acceleration and --max-jerk"
            ),
            Self::NotReady { state: is } => write!(
                f,
                "the board does not get ready: {}; read `motionctl board faults`",
                is.text()
            ),
            Self::Control(source) => source.fmt(f),
            Self::Recording(source) => source.fmt(f),
            Self::NotConfirmed(source) => source.fmt(f),
            Self::Interrupt(source) => write!(f, "cannot listen to signals: {source}"),
            Self::Print(source) => write!(f, "cannot write the result: {source}"),
        }
    }
}

impl std::error::Error for BoardError {}

fn known_boards() -> String {
    let names: Vec<&str> = board_settings::Board::ALL
        .iter()
        .map(|board| board.name)
        .collect();
    names.join(", ")
}

fn ids(drives: &[DriveId]) -> String {
    let ids: Vec<String> = drives.iter().map(ToString::to_string).collect();
    ids.join(", ")
}
