//! Why gains were not measured, or not brought back.

use core::fmt;
use std::io;

use dyn_can::DriveId;

use super::gains::Gains;
use crate::backup::FileFault;
use crate::drives::DrivesError;
use crate::exit::{self, Coded};

/// Gains that were not measured, or not brought back.
#[derive(Debug)]
pub(crate) enum TuneError {
    /// Drives or link.
    Drives(DrivesError),
    /// More sets than are compared.
    TooManySets { most: usize, actual: usize },
    /// A wave of the drive is too short.
    TooFewPeriods { least: u32, actual: u32 },
    /// The old gains are not back.
    NotRestored {
        drive: DriveId,
        old: Gains,
        source: DrivesError,
    },
    /// The picture cannot be drawn.
    Draw(String),
    /// The picture cannot be written.
    Write(FileFault),
    /// The figures cannot be written.
    Print(io::Error),
}

impl From<DrivesError> for TuneError {
    fn from(error: DrivesError) -> Self {
        Self::Drives(error)
    }
}

impl Coded for TuneError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Drives(error) => error.exit_code(),
            Self::TooManySets { .. } | Self::TooFewPeriods { .. } | Self::Write(_) => {
                exit::BAD_INPUT
            }
            Self::NotRestored { .. } | Self::Draw(_) | Self::Print(_) => exit::BROKEN_PROMISE,
        }
    }
}

impl fmt::Display for TuneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drives(source) => source.fmt(f),
            Self::TooManySets { most, actual } => {
                write!(
                    f,
                    "--gains may be given {most} times, it is given {actual} times"
                )
            }
            Self::TooFewPeriods { least, actual } => write!(
                f,
                "--wave of the drive needs --periods {least} or more, since nobody knows where in its wave it begins, got {actual}. Nothing was sent"
            ),
            Self::NotRestored { drive, old, source } => {
                write!(
                    f,
                    "the gains that drive {drive} had are NOT back: {source}. They were {old}: write them with `motionctl write --drive {drive}"
                )?;
                for setting in old.settings() {
                    write!(f, " {}={}", setting.parameter, setting.value)?;
                }
                f.write_str("`")
            }
            Self::Draw(reason) => write!(f, "cannot draw the picture: {reason}"),
            Self::Write(source) => source.fmt(f),
            Self::Print(source) => write!(f, "cannot write the figures: {source}"),
        }
    }
}

impl std::error::Error for TuneError {}
