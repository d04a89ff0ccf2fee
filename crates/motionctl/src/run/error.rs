//! Why a motion did not start.

use core::fmt;
use std::io;

use can_motion::ConfigError;
use dyn_can::{DriveId, GearNumber, units};
use homing::OutsideTravel;
use trajectory::RangeError;

use crate::confirm::NotConfirmed;
use crate::drives::DrivesError;
use crate::endpoint::EndpointError;
use crate::exit::{self, Coded};
use crate::link::OpenError;
use crate::origins::OriginsError;
use crate::recording::RecordingError;
use crate::station::{LimitError, LookError};
use crate::trajectory::MotionError;

/// The gear number that the motion was made for, and that of the drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct GearDifference {
    pub(super) drive: DriveId,
    pub(super) expected: GearNumber,
    pub(super) actual: GearNumber,
}

impl GearDifference {
    /// Whether they differ.
    pub(super) fn is_one(&self) -> bool {
        self.expected != self.actual
    }
}

/// A motion that did not start, or whose summary cannot be written.
#[derive(Debug)]
pub(crate) enum RunError {
    /// The options make no motion.
    Motion(MotionError),
    /// The motion needs more than is allowed.
    Limit(LimitError),
    /// The master refuses the configuration.
    Config(ConfigError),
    /// The bus cannot be opened.
    Open(OpenError),
    /// What the drives say of themselves is not known.
    Look(LookError),
    /// Drives have other gear numbers than the motion was made for; every axis in the order of the columns.
    Gear(Vec<GearDifference>),
    /// A file of origins cannot be used.
    Origins(OriginsError),
    /// A drive does not tell whether its origin holds.
    Life(DrivesError),
    /// An axis stands somewhere else than its motion begins.
    Start {
        drive: DriveId,
        expected_turns: f64,
        actual_turns: f64,
    },
    /// The motion leaves the travel of an axis.
    OutsideTravel {
        drive: DriveId,
        error: OutsideTravel,
    },
    /// Nobody can be listened to.
    Endpoint(EndpointError),
    /// Limits that no stream can have.
    Range(RangeError),
    /// Ctrl-C cannot be listened to.
    Interrupt(io::Error),
    /// Nobody agreed.
    NotConfirmed(NotConfirmed),
    /// A recording cannot begin.
    Recording(RecordingError),
    /// The live view and the sender of set-points would share one keyboard.
    SharedKeyboard,
    /// The live view cannot use the terminal.
    Terminal(io::Error),
    /// The summary cannot be written.
    Print(io::Error),
}

impl Coded for RunError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Open(_) | Self::Look(LookError::Link(_)) => exit::LINK_FAILED,
            Self::Look(LookError::Interrupted) => exit::INTERRUPTED,
            Self::Look(LookError::Fault { .. } | LookError::Incomplete { .. }) | Self::Print(_) => {
                exit::BROKEN_PROMISE
            }
            Self::Life(error) => error.exit_code(),
            _ => exit::BAD_INPUT,
        }
    }
}

impl fmt::Display for RunError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Motion(source) => source.fmt(f),
            Self::Limit(source) => source.fmt(f),
            Self::Config(source) => source.fmt(f),
            Self::Open(source) => source.fmt(f),
            Self::Look(source) => write!(f, "{source}. Nothing was switched and nothing has moved"),
            Self::Gear(axes) => gear_text(f, axes),
            Self::Origins(source) => source.fmt(f),
            Self::Life(source) => write!(f, "{source}. Nothing was switched and nothing has moved"),
            Self::Start {
                drive,
                expected_turns,
                actual_turns,
            } => write!(
                f,
                "the motion of drive {drive} begins at {expected_turns:.4} turns of its motor, and the axis stands at {actual_turns:.4}: bring it there with `motionctl jog --drive {drive} --to {expected_turns:.4} --origins`. Nothing has moved"
            ),
            Self::OutsideTravel { drive, error } => write!(
                f,
                "the motion of drive {drive} leaves the travel of its axis: {error}. Nothing has moved"
            ),
            Self::Endpoint(source) => source.fmt(f),
            Self::Range(source) => write!(
                f,
                "--max-rpm, --max-acceleration and --max-jerk make no limits of a stream in this cycle: {source}"
            ),
            Self::Interrupt(source) => {
                write!(f, "cannot listen to signals, keys or senders: {source}")
            }
            Self::NotConfirmed(source) => source.fmt(f),
            Self::Recording(source) => source.fmt(f),
            Self::SharedKeyboard => f.write_str(
                "--live reads keys, and --stream - would read set-points from the same terminal: send them through a pipe, or with --stream tcp:PORT. Nothing was switched and nothing has moved",
            ),
            Self::Terminal(source) => write!(
                f,
                "the live view needs a terminal ({source}): leave out --live, or use --report"
            ),
            Self::Print(source) => write!(f, "cannot write the summary: {source}"),
        }
    }
}

fn gear_text(f: &mut fmt::Formatter<'_>, axes: &[GearDifference]) -> fmt::Result {
    for axis in axes.iter().filter(|axis| axis.is_one()) {
        let [is, meant] = [axis.actual, axis.expected].map(units::command_counts_per_turn);
        write!(
            f,
            "drive {} has gear number {}, so that {is} command counts are one turn, and the motion counts {meant}: it would turn {:.3} times as far as meant. ",
            axis.drive,
            axis.actual,
            f64::from(meant) / f64::from(is)
        )?;
    }
    let fitting = axes
        .iter()
        .map(|axis| units::command_counts_per_turn(axis.actual).to_string());
    let mut fitting: Vec<String> = fitting.collect();
    if fitting.windows(2).all(|pair| pair[0] == pair[1]) {
        fitting.truncate(1);
    }
    write!(
        f,
        "The scale that fits is --counts-per-turn {}. Nothing was switched and nothing has moved",
        fitting.join(",")
    )
}

impl std::error::Error for RunError {}
