//! Why a bus is not recorded.

use core::fmt;
use std::io;
use std::path::PathBuf;

use crate::decode::DecodeError;
use crate::exit::{self, Coded};

/// A recording that cannot begin, or was cut off.
#[derive(Debug)]
pub(crate) enum RecordError {
    /// The bus cannot be opened, or has failed.
    Bus(DecodeError),
    /// A file cannot be made.
    File { path: PathBuf, source: io::Error },
    /// Ctrl-C cannot be listened to, or the system has no thread.
    Interrupt(io::Error),
    /// The summary cannot be written.
    Print(io::Error),
}

impl Coded for RecordError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Bus(error) => error.exit_code(),
            Self::Print(_) => exit::BROKEN_PROMISE,
            Self::File { .. } | Self::Interrupt(_) => exit::BAD_INPUT,
        }
    }
}

impl fmt::Display for RecordError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bus(source) => source.fmt(f),
            Self::File { path, source } => {
                write!(f, "cannot record into {}: {source}", path.display())
            }
            Self::Interrupt(source) => write!(f, "cannot listen to Ctrl-C: {source}"),
            Self::Print(source) => write!(f, "cannot write the summary: {source}"),
        }
    }
}

impl std::error::Error for RecordError {}
