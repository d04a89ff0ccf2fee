//! Why a homing did not begin, or could not be kept.

use core::fmt;
use std::io;

use homing::Refusal;

use crate::drives::DrivesError;
use crate::exit::{self, Coded};
use crate::origins::OriginsError;

/// A homing that did not begin, or could not be kept.
#[derive(Debug)]
pub(crate) enum HomeError {
    /// Drives or link.
    Drives(DrivesError),
    /// The homing refuses its configuration.
    Refusal(Refusal),
    /// The search is too fast for its readings.
    TooFast { most_rpm: f64, actual_rpm: f64 },
    /// A speed or acceleration that set-points cannot express.
    Limits(String),
    /// One option must be below another.
    Order {
        what: &'static str,
        than: &'static str,
        actual: f64,
        most: f64,
    },
    /// Levels of a switch for a method that has none.
    SwitchWithoutMethod,
    /// The levels of the switch cannot be read.
    SwitchLines(io::Error),
    /// A line is no level.
    SwitchLine { text: String },
    /// The file of origins.
    Origins(OriginsError),
    /// The drive did not take its own zero.
    NotZero { drive: u8, actual_counts: i32 },
    /// The result cannot be written.
    Print(io::Error),
}

impl From<DrivesError> for HomeError {
    fn from(error: DrivesError) -> Self {
        Self::Drives(error)
    }
}

impl Coded for HomeError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Drives(error) => error.exit_code(),
            Self::NotZero { .. } | Self::SwitchLine { .. } | Self::Print(_) => exit::BROKEN_PROMISE,
            _ => exit::BAD_INPUT,
        }
    }
}

impl fmt::Display for HomeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drives(source) => source.fmt(f),
            Self::Refusal(source) => write!(f, "{source}. Nothing has moved"),
            Self::TooFast {
                most_rpm,
                actual_rpm,
            } => write!(
                f,
                "--rpm must be at most {most_rpm:.1}, so that a contact is seen before the following error is --max-degrees, it is {actual_rpm}. Nothing has moved"
            ),
            Self::Limits(reason) => write!(f, "{reason}. Nothing has moved"),
            Self::Order {
                what,
                than,
                actual,
                most,
            } => write!(f, "{what} must be below {than}, {most}, it is {actual}"),
            Self::SwitchWithoutMethod => {
                f.write_str("--switch-input is for --method switch, and another method is given")
            }
            Self::SwitchLines(source) => {
                write!(
                    f,
                    "cannot read the levels of the switch: {source}. Nothing has moved"
                )
            }
            Self::SwitchLine { text } => write!(
                f,
                "expected 1 or 0 on a line of --switch-input, got {text:?}: the search was stopped"
            ),
            Self::Origins(source) => source.fmt(f),
            Self::NotZero {
                drive,
                actual_counts,
            } => write!(
                f,
                "drive {drive} must report 0 after it was told its zero, it reports {actual_counts} counts: it has not taken it. The origin was not kept"
            ),
            Self::Print(source) => write!(f, "cannot write the result: {source}"),
        }
    }
}

impl std::error::Error for HomeError {}
