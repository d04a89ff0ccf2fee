//! The seam between the decoder and the protocols on a bus.

use core::fmt;

use crate::frame::Frame;

/// One protocol on the bus, followed from frame to frame.
///
/// A protocol keeps what it needs of the past: whose request is open, what a drive told about itself. It is told the time and
/// does no I/O, so the same code reads a log, a live interface and the traffic of a simulation.
pub trait Conversation {
    /// What it makes of a frame: words by `Display`, values by `serde::Serialize`.
    type Message: fmt::Display + serde::Serialize;

    /// Reads a frame that ended at `at_ns`; `None` when no node of this protocol sends or hears such a frame.
    ///
    /// Frames come in the order of the bus. Time in nanoseconds from any start; a step back is taken as no time passed. `None` when
    /// the times are not known: then the order alone counts, and nothing is late.
    fn hear(&mut self, at_ns: Option<u64>, frame: &Frame) -> Option<Self::Message>;
}

/// Time that has passed, when both times are known.
pub(crate) fn since(at_ns: Option<u64>, then_ns: Option<u64>) -> Option<u64> {
    Some(at_ns?.saturating_sub(then_ns?))
}

/// Which side sent a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// The master, to a drive or to all.
    ToDrive,
    /// A drive.
    FromDrive,
}

impl fmt::Display for Direction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::ToDrive => "to",
            Self::FromDrive => "from",
        })
    }
}
