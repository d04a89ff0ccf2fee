//! The seam to where frames come from: a log file here, a live interface elsewhere.

use core::fmt;

use can_decode::log::{Entry, LineError};

use super::error::DecodeError;

/// Where frames come from.
pub(crate) trait Source {
    /// What messages call it: a file, an interface.
    fn name(&self) -> String;

    /// Whether [`Self::next`] may have to wait: then what was heard is shown first.
    fn may_wait(&self) -> bool;

    /// What the reader of the output should know about the times.
    fn note(&self) -> Option<&'static str> {
        None
    }

    /// What was heard next; `None` at the end. A live source waits.
    fn next(&mut self) -> Result<Option<Heard<'_>>, DecodeError>;
}

/// One thing that was heard.
#[derive(Debug)]
pub(crate) struct Heard<'a> {
    /// Its line in the log, counted from 1; a number of the frame elsewhere.
    pub(crate) line: u64,
    /// What it is, `None` for a line without traffic, or why it cannot be read.
    pub(crate) what: Result<Option<Entry<'a>>, Damage>,
}

/// Why a line was not read, or is doubtful.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Damage {
    /// The line is longer than any format has them.
    LongLine { most: usize },
    /// The line does not belong to its format.
    Line(LineError),
    /// The frame was read, but its time is before that of an earlier one.
    TimeGoesBack { before_ns: u64, at_ns: u64 },
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LongLine { most } => {
                write!(
                    f,
                    "expected a line of at most {most} bytes, got a longer one"
                )
            }
            Self::Line(error) => error.fmt(f),
            Self::TimeGoesBack { before_ns, at_ns } => {
                let s = |ns: u64| ns as f64 * 1e-9;
                write!(
                    f,
                    "time goes back from {:.6} s to {:.6} s: replies may be taken for others",
                    s(*before_ns),
                    s(*at_ns)
                )
            }
        }
    }
}
