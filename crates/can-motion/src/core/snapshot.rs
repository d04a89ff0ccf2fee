//! Counters, and readings with their age.

use bus_user::Instant;

/// A reading and when it came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Stamped<T> {
    /// The reading.
    pub value: T,
    /// When its frame was handed to the master.
    pub at: Instant,
}

impl<T> Stamped<T> {
    /// How old the reading is, in microseconds.
    pub const fn age_us(&self, now: Instant) -> u64 {
        now.us_since(self.at)
    }
}

/// What happened to one axis since the start; each number wraps after 2^32.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Set-points that the controller accepted.
    pub set_points: u32,
    /// Set-points that missed their cycle; their step went into the next frame.
    pub merged: u32,
    /// Frames that the controller gave back unsent.
    pub displaced: u32,
    /// Requests that the controller accepted.
    pub requests: u32,
    /// Replies that were believed.
    pub replies: u32,
    /// Requests without a reply in time.
    pub timeouts: u32,
    /// Replies dropped because they came too late or twice.
    pub late_replies: u32,
    /// Replies dropped because nobody asked.
    pub stray_replies: u32,
    /// Replies that did not decode.
    pub bad_replies: u32,
    /// Parameters written to the drive's EEPROM.
    pub eeprom_writes: u16,
}

/// What happened to the cycle since the start; each number wraps after 2^32.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CycleCounters {
    /// Cycles begun.
    pub cycles: u32,
    /// Cycles that ended with a set-point not accepted by the controller.
    pub late: u32,
    /// Cycles that were never begun.
    pub missed: u32,
    /// Events dropped because nobody read them.
    pub events_dropped: u32,
}

impl CycleCounters {
    /// Nothing has happened.
    pub(crate) const NONE: Self = Self {
        cycles: 0,
        late: 0,
        missed: 0,
        events_dropped: 0,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_ages() {
        let at = Instant::from_us(1_000);
        let reading = Stamped { value: (), at };
        let ages = [900, 1_000, 1_250].map(|us| reading.age_us(Instant::from_us(us)));
        assert_eq!(ages, [0, 0, 250]);
    }
}
