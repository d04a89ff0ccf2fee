//! Why a motion did not start.

use core::fmt;

use can_motion::ConfigError;

use crate::confirm::NotConfirmed;
use crate::exit::{self, Coded};
use crate::link::OpenError;
use crate::trajectory::MotionError;

/// A motion that did not start, or whose summary cannot be written.
#[derive(Debug)]
pub(crate) enum RunError {
    /// The options make no motion.
    Motion(MotionError),
    /// The master refuses the configuration.
    Config(ConfigError),
    /// The bus cannot be opened.
    Open(OpenError),
    /// Ctrl-C cannot be listened to.
    Interrupt(ctrlc::Error),
    /// Nobody agreed.
    NotConfirmed(NotConfirmed),
    /// The summary cannot be written as JSON.
    Json(serde_json::Error),
}

impl Coded for RunError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Open(_) => exit::LINK_FAILED,
            _ => exit::BAD_INPUT,
        }
    }
}

impl fmt::Display for RunError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Motion(source) => source.fmt(f),
            Self::Config(source) => source.fmt(f),
            Self::Open(source) => source.fmt(f),
            Self::Interrupt(source) => write!(f, "cannot listen to Ctrl-C: {source}"),
            Self::NotConfirmed(source) => source.fmt(f),
            Self::Json(source) => write!(f, "cannot write the summary: {source}"),
        }
    }
}

impl std::error::Error for RunError {}
