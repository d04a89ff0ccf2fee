//! Why an origin cannot be used.

use core::fmt;
use std::io;
use std::path::PathBuf;

use board_settings::file::Place;
use dyn_can::DriveId;
use homing::OutsideTravel;

use super::wheel::SpoiltWheel;
use crate::backup::FileFault;

/// Why an origin does not hold any more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Spoilt {
    /// The drive has another gear number: its counts are others.
    Gear { expected: i32, actual: i32 },
    /// The drive has lost its power, or somebody else has read its counter.
    Counter { expected: u8, actual: u8 },
    /// The drive was reset, or has taken a zero of its own.
    Zeroed { before_counts: i32 },
    /// The axis is outside its travel.
    Outside(OutsideTravel),
}

impl fmt::Display for Spoilt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gear { expected, actual } => write!(
                f,
                "it was homed with gear number {expected}, the drive has {actual};"
            ),
            Self::Counter { expected, actual } => write!(
                f,
                "its diagnostic counter should be {expected}, it is {actual}: the drive has lost its power since, or another program has read the counter;"
            ),
            Self::Zeroed { before_counts } => write!(
                f,
                "it reported {before_counts} counts when it was last used and reports 0 now: it was reset, or was given another zero;"
            ),
            Self::Outside(error) => {
                write!(f, "{error}: bring it back with `motionctl jog --turns`, or")
            }
        }
    }
}

/// A file of origins that cannot be used.
#[derive(Debug)]
pub(crate) enum OriginsError {
    /// It cannot be read.
    Read { path: PathBuf, source: io::Error },
    /// It has something else in it than origins.
    Content {
        path: PathBuf,
        place: Place,
        reason: String,
    },
    /// It cannot be written.
    Write(FileFault),
    /// It has no origin of a drive.
    Missing { path: PathBuf, drive: DriveId },
    /// It has no origin of a hub motor.
    MissingWheel { path: PathBuf, node: u8 },
    /// The origin of a hub motor does not hold any more.
    SpoiltWheel {
        path: PathBuf,
        node: u8,
        reason: SpoiltWheel,
    },
    /// The origin of a drive does not hold any more.
    Spoilt {
        path: PathBuf,
        drive: DriveId,
        reason: Spoilt,
    },
}

impl fmt::Display for OriginsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, source } => write!(
                f,
                "cannot read {}: {source}. `motionctl home --origins` writes it",
                path.display()
            ),
            Self::Content {
                path,
                place: Place { line, column },
                reason,
            } => write!(
                f,
                "{}, line {line}, column {column}: {reason}; home the axes again into a new file",
                path.display()
            ),
            Self::Write(source) => source.fmt(f),
            Self::Missing { path, drive } => write!(
                f,
                "{} has no origin of drive {drive}: `motionctl home --drive {drive} --origins` first. Nothing has moved",
                path.display()
            ),
            Self::MissingWheel { path, node } => write!(
                f,
                "{} has no origin of node {node}: `motionctl home --drives zlac:{node} --origins` first. Nothing has moved",
                path.display()
            ),
            Self::SpoiltWheel { path, node, reason } => write!(
                f,
                "the origin of node {node} in {} does not hold: {reason} home it again. Nothing has moved",
                path.display()
            ),
            Self::Spoilt {
                path,
                drive,
                reason,
            } => write!(
                f,
                "the origin of drive {drive} in {} does not hold: {reason} home it again. Nothing has moved",
                path.display()
            ),
        }
    }
}

impl std::error::Error for OriginsError {}
