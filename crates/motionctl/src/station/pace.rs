//! When cycles are due, and how well they kept their time.

use can_motion::Instant;
use schemars::JsonSchema;
use serde::Serialize;

/// How well the cycles kept their time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub(crate) struct PaceCounts {
    /// Cycles begun.
    pub(crate) cycles: u64,
    /// Cycles begun more than half a cycle after their time.
    pub(crate) late: u64,
    /// Cycles never begun: their steps went into the next one.
    pub(crate) merged: u64,
    /// How late the latest one began, in microseconds.
    pub(crate) worst_us: u64,
}

/// Cycles at a fixed distance from the first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pace {
    cycle_us: u64,
    /// When the next cycle is due; at once before the first.
    due: Option<Instant>,
    number: u64,
    counts: PaceCounts,
}

impl Pace {
    /// Cycles of so many microseconds.
    pub(crate) fn new(cycle_us: u32) -> Self {
        Self {
            cycle_us: u64::from(cycle_us),
            due: None,
            number: 0,
            counts: PaceCounts::default(),
        }
    }

    /// When the next cycle is due.
    pub(crate) fn due(&self) -> Instant {
        self.due.unwrap_or_default()
    }

    /// A cycle begins; returns its number on the clock, which counts those that were never begun too.
    pub(crate) fn begin(&mut self, now: Instant) -> u64 {
        let due = self.due.unwrap_or(now);
        let late_us = now.us_since(due);
        let merged = late_us / self.cycle_us;
        let number = self.number + merged;
        self.number = number + 1;
        self.due = Some(Instant::from_us(due.as_us() + (merged + 1) * self.cycle_us));
        self.counts.cycles += 1;
        self.counts.late += u64::from(late_us > self.cycle_us / 2);
        self.counts.merged += merged;
        self.counts.worst_us = self.counts.worst_us.max(late_us);
        number
    }

    /// How well the cycles kept their time so far.
    pub(crate) fn counts(&self) -> PaceCounts {
        self.counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycles_keep_their_distance_from_the_first_whenever_they_begin() {
        let mut pace = Pace::new(1_000);
        let mut begin = |us| {
            let number = pace.begin(Instant::from_us(us));
            (number, pace.due().as_us())
        };
        assert_eq!(begin(70), (0, 1_070));
        assert_eq!(begin(1_500), (1, 2_070));
        assert_eq!(begin(2_070), (2, 3_070));
        // 0.6 ms late, then 2.5 ms late: two cycles are merged into this one.
        assert_eq!(begin(3_670), (3, 4_070));
        assert_eq!(begin(6_570), (6, 7_070));
        assert_eq!(begin(7_070), (7, 8_070));
        let expected = PaceCounts {
            cycles: 6,
            late: 2,
            merged: 2,
            worst_us: 2_500,
        };
        assert_eq!(pace.counts(), expected);
    }
}
