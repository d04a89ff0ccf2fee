//! Why a motion file was not checked.

use core::fmt;
use std::io;
use std::path::PathBuf;

use crate::trajectory::MotionError;

/// A file that was not checked, or a result that cannot be written.
#[derive(Debug)]
pub(crate) enum CheckError {
    /// The options make no motion.
    Motion(MotionError),
    /// The picture cannot be drawn.
    Draw(String),
    /// The picture cannot be written.
    Write { path: PathBuf, source: io::Error },
    /// The result cannot be printed.
    Print(io::Error),
}

impl fmt::Display for CheckError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Motion(source) => source.fmt(f),
            Self::Draw(reason) => write!(f, "cannot draw the picture: {reason}"),
            Self::Write { path, source } => write!(f, "cannot write {}: {source}", path.display()),
            Self::Print(source) => write!(f, "cannot write the result: {source}"),
        }
    }
}

impl std::error::Error for CheckError {}
