//! How a stream begins, and how a queue of segments works.

use serde::{Deserialize, Serialize};
use trajectory::Time;

use super::OfAxes;
use crate::config::WhenDry;

/// How a queue of segments works.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SegmentConfig {
    /// A stream moves, and moves again after it has run dry, when so much time is buffered, when the queue is full, or the end is there.
    pub lead: Time,
    /// Longest segment.
    pub longest: Time,
    /// A start may be so many cycles ahead.
    pub farthest_start: u32,
}

impl SegmentConfig {
    /// 0.3 s before it moves, segments up to 10 s, starts up to a minute ahead, with this many cycles in a second.
    #[must_use]
    pub const fn with_cycles_per_second(cycles: u32) -> Self {
        Self {
            lead: Time::from_units(3 * cycles as u64, 10),
            longest: Time::from_units(10 * cycles as u64, 1),
            farthest_start: cycles.saturating_mul(60),
        }
    }
}

/// The begin of a stream.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Begin {
    /// The sender's number of the stream.
    pub stream: u32,
    /// The cycle of the board at which it is at its start; `None` for as soon as [`SegmentConfig::lead`] is buffered.
    pub start: Option<u64>,
    /// What happens when the segments run out.
    pub when_dry: WhenDry,
    /// Override in percent, 0 to 200.
    pub percent: u16,
    /// Where the axes stand, in units of 2^-24 counts: the board must agree.
    pub from: OfAxes<i64>,
}
