//! What can be wrong with a line of a log.

use core::fmt;

/// Most characters of a line that an error shows.
const SHOWN: usize = 40;

/// A line that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum LineError {
    /// The log is in no format that is known.
    NoFormat {
        /// The begin of the line.
        actual: String,
    },
    /// The line ends too early.
    Missing {
        /// What should come.
        expected: &'static str,
    },
    /// Something else stands where a part of the line should be.
    Field {
        /// What should be there.
        expected: &'static str,
        /// What is there.
        actual: String,
    },
    /// The number of data bytes is not the length that the line tells.
    DataLength {
        /// The length that the line tells.
        expected: usize,
        /// The data bytes that are there.
        actual: usize,
    },
    /// A TRC log of another version than 1.0 and 2.1.
    TrcVersion {
        /// The version.
        actual: String,
    },
}

impl LineError {
    pub(super) fn no_format(line: &str) -> Self {
        Self::NoFormat {
            actual: shown(line),
        }
    }

    pub(super) fn field(expected: &'static str, actual: &str) -> Self {
        Self::Field {
            expected,
            actual: shown(actual),
        }
    }
}

/// The begin of a text, for a message of one line.
fn shown(text: &str) -> String {
    let mut shown: String = text.chars().take(SHOWN).collect();
    if shown.len() < text.len() {
        shown.push_str("...");
    }
    shown
}

impl fmt::Display for LineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoFormat { actual } => write!(
                f,
                "expected a log of candump -L or candump -t a, or an .asc, .csv, .txt, .log or .trc of python-can, got \"{actual}\""
            ),
            Self::Missing { expected } => write!(f, "expected {expected}, the line ends"),
            Self::Field { expected, actual } => write!(f, "expected {expected}, got \"{actual}\""),
            Self::DataLength { expected, actual } => {
                write!(f, "expected {expected} data bytes, got {actual}")
            }
            Self::TrcVersion { actual } => write!(
                f,
                "expected TRC version 1.0 or 2.1, got {actual}: save the log in one of these"
            ),
        }
    }
}

impl core::error::Error for LineError {}
