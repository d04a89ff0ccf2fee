//! The cycle of the board at a time of the host, from round trips of which the fastest says most.

use heapless::Deque;

/// Round trips that are remembered.
const ROUNDS: usize = 8;

/// One round trip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Round {
    trip_us: u64,
    /// The time of the board less that of the host.
    offset_us: i64,
}

/// What is known of the clock of a board.
#[derive(Debug, Clone, Default)]
pub struct ClockEstimate {
    rounds: Deque<Round, ROUNDS>,
    cycle_us: u32,
}

impl ClockEstimate {
    pub(super) const fn new(cycle_us: u32) -> Self {
        Self {
            rounds: Deque::new(),
            cycle_us,
        }
    }

    /// A request that left at one time was answered at another one with a cycle of the board.
    pub(super) fn add(&mut self, sent_us: u64, received_us: u64, cycle: u64) {
        let trip_us = received_us.saturating_sub(sent_us);
        let middle = sent_us.saturating_add(trip_us / 2);
        // On average the cycle is half over.
        let cycle_us = u64::from(self.cycle_us);
        let board = cycle.saturating_mul(cycle_us).saturating_add(cycle_us / 2);
        let round = Round {
            trip_us,
            offset_us: board.wrapping_sub(middle).cast_signed(),
        };
        if self.rounds.is_full() {
            self.rounds.pop_front();
        }
        // There is room now.
        let _ = self.rounds.push_back(round);
    }

    fn best(&self) -> Option<&Round> {
        self.rounds.iter().min_by_key(|round| round.trip_us)
    }

    /// Round trips that are remembered.
    #[must_use]
    pub fn rounds(&self) -> usize {
        self.rounds.len()
    }

    /// How far the estimate can be off, in microseconds: half of the fastest round trip, and half a cycle.
    #[must_use]
    pub fn error_us(&self) -> Option<u64> {
        Some(self.best()?.trip_us.div_ceil(2) + u64::from(self.cycle_us.div_ceil(2)))
    }

    /// The cycle of the board at a time of the host.
    #[must_use]
    pub fn cycle_at(&self, host_us: u64) -> Option<u64> {
        let board_us = host_us.checked_add_signed(self.best()?.offset_us)?;
        board_us.checked_div(self.cycle_us.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fastest_round_trip_counts() {
        let mut clock = ClockEstimate::new(1_000);
        assert_eq!(clock.cycle_at(0), None);
        // The board is 5 s ahead. Slow and lopsided round trips, one that is fast.
        for (there_us, back_us) in [(40_000, 1_000), (2_000, 50_000), (300, 500), (9_000, 100)] {
            let sent = 1_000_000;
            let cycle = (sent + there_us + 5_000_000) / 1_000;
            clock.add(sent, sent + there_us + back_us, cycle);
        }
        let error_us = clock.error_us().unwrap();
        assert_eq!(error_us, 900);
        let cycle = clock.cycle_at(2_000_000).unwrap();
        assert!(cycle.abs_diff(7_000) <= 1, "{cycle}");
        // It is forgotten in the end.
        for _ in 0..8 {
            clock.add(0, 8_000, 0);
        }
        assert_eq!((clock.error_us(), clock.rounds()), (Some(4_500), 8));
    }
}
