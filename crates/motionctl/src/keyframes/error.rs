//! Why there are no keyframes.

use core::fmt;
use std::io;

use trajectory::curve::KeyframeError;

use crate::backup::FileFault;
use crate::program::ProgramFileError;
use crate::trajectory::MotionError;

/// A program that does not become keyframes.
#[derive(Debug)]
pub(crate) enum KeyframesError {
    /// Nothing says which.
    NoProgram,
    /// The program or the options cannot be used.
    Motion(MotionError),
    /// The board repeats its motion from where it ends.
    Elsewhere { motor: String, counts: i32 },
    /// The file is there already, or cannot be written.
    File(FileFault),
    /// The board would refuse them.
    Keyframes(KeyframeError),
    /// Between two keyframes as near to each other as they can be, the board would be further from the path.
    Tolerance { at_ms: u64, tolerance_counts: f64 },
    /// The result cannot be printed.
    Print(io::Error),
}

impl fmt::Display for KeyframesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoProgram => f.write_str("nothing says which program: expected --program FILE"),
            Self::Motion(source) => source.fmt(f),
            Self::Elsewhere { motor, counts } => write!(
                f,
                "the board repeats its motion, so a program must end where it starts: {motor} ends {counts} counts from there; let the program go back, as with G28"
            ),
            Self::File(source) => source.fmt(f),
            Self::Keyframes(source) => source.fmt(f),
            Self::Tolerance {
                at_ms,
                tolerance_counts,
            } => write!(
                f,
                "behind {at_ms} ms no keyframe is within {tolerance_counts} counts of the path: they stand at whole milliseconds; use a cycle of which a millisecond is a multiple, or more --tolerance-counts"
            ),
            Self::Print(source) => write!(f, "cannot write the result: {source}"),
        }
    }
}

impl std::error::Error for KeyframesError {}

impl From<MotionError> for KeyframesError {
    fn from(source: MotionError) -> Self {
        Self::Motion(source)
    }
}

impl From<ProgramFileError> for KeyframesError {
    fn from(source: ProgramFileError) -> Self {
        Self::Motion(source.into())
    }
}

impl From<FileFault> for KeyframesError {
    fn from(source: FileFault) -> Self {
        Self::File(source)
    }
}

impl From<KeyframeError> for KeyframesError {
    fn from(source: KeyframeError) -> Self {
        Self::Keyframes(source)
    }
}
