//! Why a plan was not shown.

use core::fmt;
use std::path::PathBuf;

/// A picture or a verdict that cannot be written.
#[derive(Debug)]
pub(crate) enum PlanError {
    /// The picture cannot be written to its file.
    Write {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The picture cannot be drawn.
    Draw(String),
    /// The verdict cannot be written.
    Print(std::io::Error),
}

impl fmt::Display for PlanError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Write { path, source } => write!(f, "cannot write {}: {source}", path.display()),
            Self::Draw(reason) => write!(f, "cannot draw the picture: {reason}"),
            Self::Print(source) => write!(f, "cannot write the plan: {source}"),
        }
    }
}

impl std::error::Error for PlanError {}
