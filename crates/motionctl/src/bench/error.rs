//! Why a bench does not run.

use core::fmt;
use std::io;
use std::path::PathBuf;

use crate::exit::{self, Coded};

/// A bench that cannot be set up, or that failed.
#[derive(Debug)]
pub(crate) enum BenchError {
    /// Ctrl-C cannot be listened to.
    Interrupt(io::Error),
    /// The terminal cannot be made.
    Create { link: PathBuf, source: io::Error },
    /// A terminal failed while the bench ran.
    Terminal(io::Error),
    /// The report cannot be written.
    Print(std::io::Error),
}

impl Coded for BenchError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Terminal(_) => exit::LINK_FAILED,
            _ => exit::BAD_INPUT,
        }
    }
}

impl fmt::Display for BenchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Interrupt(source) => write!(f, "cannot listen to Ctrl-C: {source}"),
            Self::Create { link, source } if source.kind() == io::ErrorKind::AlreadyExists => {
                write!(
                    f,
                    "{} exists: choose a path that does not, or end the bench that made it",
                    link.display()
                )
            }
            Self::Create { link, source } => {
                write!(
                    f,
                    "cannot make a pseudo-terminal at {}: {source}",
                    link.display()
                )
            }
            Self::Terminal(source) => write!(f, "a pseudo-terminal failed: {source}"),
            Self::Print(source) => write!(f, "cannot write the report: {source}"),
        }
    }
}

impl std::error::Error for BenchError {}
