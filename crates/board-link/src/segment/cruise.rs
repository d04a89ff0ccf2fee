//! Cycles in which nothing changes: no order, nothing new from the admission, the same rate, the same segment, enough ahead. They are nearly
//! all of a stream, and add to the time what the cycle before has added.

use trajectory::Time;

/// How a player goes on while nothing changes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cruise {
    /// Changes of the admission when this was worked out.
    pub(super) changes: u32,
    /// What a cycle adds to the time of the stream.
    pub(super) step: Time,
    /// The start of the segment, and the time up to which this holds.
    pub(super) start: Time,
    pub(super) until: Time,
}

impl Cruise {
    /// Nothing is known: the next cycle is worked out anew.
    pub(super) const NONE: Self = Self {
        changes: 0,
        step: Time::ZERO,
        start: Time::ZERO,
        until: Time::ZERO,
    };
}
