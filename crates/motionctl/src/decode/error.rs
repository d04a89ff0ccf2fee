//! Why a log cannot be decoded.

use core::fmt;
use std::path::PathBuf;

use can_decode::log::Format;

use super::source::Damage;
use crate::exit::{self, Coded};
use crate::link::{LinkFault, OpenError};

/// A log that cannot be read, or a text that cannot be written.
#[derive(Debug)]
pub(crate) enum DecodeError {
    /// The log cannot be opened or read any further.
    Read {
        path: String,
        source: std::io::Error,
    },
    /// The file is no log of any format that is known, or its header cannot be read.
    NoLog {
        path: String,
        line: u64,
        /// The format that its first line seems to have.
        format: Option<Format>,
        damage: Damage,
    },
    /// The file is no text.
    Binary { path: String, what: &'static str },
    /// The bus cannot be opened.
    Open(OpenError),
    /// The bus cannot be listened to any longer.
    Link(LinkFault),
    /// Ctrl-C cannot be listened to.
    Interrupt(std::io::Error),
    /// The output cannot be written any further.
    Write(std::io::Error),
    /// The page cannot be written.
    Page {
        path: PathBuf,
        source: std::io::Error,
    },
    /// No page is made of this log.
    NoPage { reason: &'static str },
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
            Self::NoLog {
                path,
                line,
                format,
                damage,
            } => {
                write!(f, "{path}: line {line}: {damage}")?;
                match format {
                    Some(format) => write!(
                        f,
                        "; no frame comes before it, so this is no log of {format}"
                    ),
                    None => Ok(()),
                }
            }
            Self::Binary { path, what } => {
                write!(f, "{path}: line 1: expected a text log, got {what}")
            }
            Self::Open(source) => source.fmt(f),
            Self::Link(source) => write!(f, "the link failed: {source}"),
            Self::Interrupt(source) => write!(f, "cannot listen to Ctrl-C: {source}"),
            Self::Write(source) => write!(f, "cannot write the output: {source}"),
            Self::Page { path, source } => write!(f, "cannot write {}: {source}", path.display()),
            Self::NoPage { reason } => write!(f, "no page is made of this log: {reason}"),
        }
    }
}

impl std::error::Error for DecodeError {}

impl Coded for DecodeError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Open(_) | Self::Link(_) => exit::LINK_FAILED,
            _ => exit::BAD_INPUT,
        }
    }
}
