//! Why a log cannot be decoded.

use core::fmt;

/// A log that cannot be read, or a text that cannot be written.
#[derive(Debug)]
pub(crate) enum DecodeError {
    /// The log cannot be opened or read any further.
    Read {
        path: String,
        source: std::io::Error,
    },
    /// No line belongs to a format that is known.
    NoLog { path: String },
    /// The output cannot be written any further.
    Write(std::io::Error),
}

impl From<std::io::Error> for DecodeError {
    fn from(error: std::io::Error) -> Self {
        Self::Write(error)
    }
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, source } => write!(f, "cannot read {path}: {source}"),
            Self::NoLog { path } => write!(
                f,
                "{path} is no log that can be read: expected one of candump (-L, -l, -t a) or python-can (.log, .asc, .csv, .txt, .trc)"
            ),
            Self::Write(source) => write!(f, "cannot write the output: {source}"),
        }
    }
}

impl std::error::Error for DecodeError {}
