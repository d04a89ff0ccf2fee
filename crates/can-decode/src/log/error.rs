//! What can be wrong with a line of a log.

use core::fmt;

/// Most characters of a line that an error shows.
const SHOWN: usize = 60;

/// A line that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum LineError {
    /// No line so far belongs to a format that is known.
    NoFormat {
        /// The begin of the line.
        actual: String,
    },
    /// A header that says what nobody here can read: nothing behind it would mean what it seems to.
    Header {
        /// What should be there.
        expected: &'static str,
        /// What is there.
        actual: String,
    },
    /// Times of candump that are differences, in a log that was taken for one with times from its start.
    Differences {
        /// The time before, in nanoseconds.
        before_ns: u64,
        /// The time that is smaller.
        at_ns: u64,
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
    /// The tool that wrote the log says that it lost frames here.
    Lost {
        /// What it says.
        actual: String,
    },
}

impl LineError {
    /// Whether nothing behind this line can be read.
    #[must_use]
    pub const fn ends_log(&self) -> bool {
        matches!(self, Self::Header { .. } | Self::Differences { .. })
    }

    pub(super) fn no_format(line: &str) -> Self {
        Self::NoFormat {
            actual: shown(line),
        }
    }

    pub(super) fn header(expected: &'static str, actual: &str) -> Self {
        Self::Header {
            expected,
            actual: shown(actual),
        }
    }

    pub(super) fn field(expected: &'static str, actual: &str) -> Self {
        Self::Field {
            expected,
            actual: shown(actual),
        }
    }

    pub(super) fn lost(line: &str) -> Self {
        Self::Lost {
            actual: shown(line),
        }
    }
}

/// The begin of a text, for a message of one line.
fn shown(text: &str) -> String {
    let printable = |letter: char| {
        if letter.is_control() {
            '\u{fffd}'
        } else {
            letter
        }
    };
    let mut letters = text.chars();
    let mut shown: String = letters.by_ref().take(SHOWN).map(printable).collect();
    if letters.next().is_some() {
        shown.push_str("...");
    }
    shown
}

impl fmt::Display for LineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoFormat { actual } => write!(
                f,
                "expected a log of candump, python-can (.log, .asc, .csv, .txt, .trc), PEAK (.trc), Vector (.asc) or SavvyCAN (.csv), got \"{actual}\""
            ),
            Self::Header { expected, actual } => write!(
                f,
                "expected {expected}, got \"{actual}\"; nothing behind this header is read"
            ),
            Self::Differences { before_ns, at_ns } => write!(
                f,
                "the times go back from {:.6} s to {:.6} s, as the differences of candump -t d do: give --stamps delta if they are, --stamps zero if not",
                *before_ns as f64 * 1e-9,
                *at_ns as f64 * 1e-9
            ),
            Self::Missing { expected } => write!(f, "expected {expected}, the line ends"),
            Self::Field { expected, actual } => write!(f, "expected {expected}, got \"{actual}\""),
            Self::DataLength { expected, actual } => {
                write!(f, "expected {expected} data bytes, got {actual}")
            }
            Self::Lost { actual } => {
                write!(
                    f,
                    "frames are missing here, says the tool that wrote the log: {actual}"
                )
            }
        }
    }
}

impl core::error::Error for LineError {}
