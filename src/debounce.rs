//! Inputs that bounce.

use crate::config::CYCLE_US;

/// A contact must have been closed this long to count; twice what relays and push-buttons usually bounce.
pub(crate) const SETTLE_US: u32 = 20_000;
const SETTLE_CYCLES: u32 = SETTLE_US / CYCLE_US;

/// One input. It becomes active only when it has been so for a while, and inactive at once: every input here permits
/// something when it is active, so the late edge is the one that permits and the early one stops.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Debounced {
    cycles: u32,
}

impl Debounced {
    /// Inactive.
    pub(crate) const fn new() -> Self {
        Self { cycles: 0 }
    }

    /// Takes the level of this cycle; tells whether the input is active.
    pub(crate) fn update(&mut self, level: bool) -> bool {
        self.cycles = if level {
            SETTLE_CYCLES.min(self.cycles + 1)
        } else {
            0
        };
        self.cycles == SETTLE_CYCLES
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bouncing_contact_counts_only_when_it_has_settled() {
        let mut input = Debounced::new();
        for level in [true, true, false, true, false] {
            assert!(!input.update(level));
        }
        let settling = (0..).take_while(|_| !input.update(true));
        assert_eq!(settling.count() as u32, SETTLE_CYCLES - 1);
    }

    #[test]
    fn it_is_inactive_at_once() {
        let mut input = Debounced::new();
        (0..SETTLE_CYCLES).for_each(|_| {
            input.update(true);
        });
        assert!(input.update(true));
        assert!(!input.update(false));
    }
}
