//! Why a bench does not run.

use core::fmt;
use std::io;
use std::path::PathBuf;

use crate::exit::{self, Coded};
use crate::host_port::Place;
use crate::recording::RecordingError;

/// A bench that cannot be set up, or that failed.
#[derive(Debug)]
pub(crate) enum BenchError {
    /// Ctrl-C cannot be listened to.
    Interrupt(io::Error),
    /// What other programs open cannot be made.
    Create { place: Place, source: io::Error },
    /// The settings of the board cannot be read.
    Settings { path: PathBuf, source: io::Error },
    /// The log of the bus cannot be written.
    Candump(RecordingError),
    /// The log of the bus is not complete.
    CandumpStopped { reason: String },
    /// A terminal failed while the bench ran.
    Terminal(io::Error),
    /// The report cannot be written.
    Print(std::io::Error),
}

impl Coded for BenchError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Terminal(_) => exit::LINK_FAILED,
            Self::CandumpStopped { .. } => exit::BROKEN_PROMISE,
            _ => exit::BAD_INPUT,
        }
    }
}

impl fmt::Display for BenchError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Interrupt(source) => write!(f, "cannot listen to Ctrl-C: {source}"),
            Self::Create { place, source } => match (place, source.kind()) {
                (Place::Path(_), io::ErrorKind::AlreadyExists) => write!(
                    f,
                    "{place} exists: choose a path that does not, or end the bench that made it"
                ),
                (Place::Path(_), _) => {
                    write!(f, "cannot make a pseudo-terminal at {place}: {source}")
                }
                (Place::Tcp(_), io::ErrorKind::AddrInUse) => write!(
                    f,
                    "{place}: another program listens there already: choose another port, or tcp:0 for one that is free"
                ),
                (Place::Tcp(_), _) => write!(f, "cannot listen at {place}: {source}"),
            },
            Self::Settings { path, source } => {
                write!(
                    f,
                    "cannot read the settings in {}: {source}",
                    path.display()
                )
            }
            Self::Candump(source) => source.fmt(f),
            Self::CandumpStopped { reason } => {
                write!(f, "the log of the bus is not complete: {reason}")
            }
            Self::Terminal(source) => write!(f, "a terminal or port of the bench failed: {source}"),
            Self::Print(source) => write!(f, "cannot write the report: {source}"),
        }
    }
}

impl std::error::Error for BenchError {}
