//! Group ramp-down: all axes of a group slow down together, in proportion, on the line they move along.

/// The way of one axis from its velocity to standstill.
///
/// Every axis of a group takes the same number of cycles, so the ratio of their velocities, which is the direction of
/// the path, stays. The position is computed from the start each cycle, so rounding does not add up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct Ramp {
    start_counts: i32,
    velocity_counts: i32,
    cycles: u32,
    elapsed: u32,
}

/// Cycles that a velocity needs to fall to zero when it may change by `max_change` per cycle, both in the same unit.
pub(crate) fn cycles_to_stop(velocity: i32, max_change: u32) -> u32 {
    velocity.unsigned_abs().div_ceil(max_change.max(1))
}

impl Ramp {
    pub(crate) const fn new(start_counts: i32, velocity_counts: i32, cycles: u32) -> Self {
        Self {
            start_counts,
            velocity_counts,
            cycles,
            elapsed: 0,
        }
    }

    /// The target of the next cycle; the last one stays.
    pub(crate) fn next_target(&mut self) -> i32 {
        self.elapsed = self.elapsed.saturating_add(1).min(self.cycles);
        self.after(self.elapsed)
    }

    /// The last target.
    pub(crate) const fn end(&self) -> i32 {
        self.after(self.cycles)
    }

    /// The target after so many cycles.
    const fn after(&self, elapsed: u32) -> i32 {
        let (velocity, cycles, elapsed) = (
            self.velocity_counts as i64,
            self.cycles as i64,
            elapsed as i64,
        );
        // Sum over k = 1..=elapsed of velocity * (1 - k / cycles).
        let Some(offset) = velocity
            .wrapping_mul(elapsed)
            .wrapping_mul(2 * cycles - elapsed - 1)
            .checked_div(2 * cycles)
        else {
            return self.start_counts;
        };
        self.start_counts.wrapping_add(offset as i32)
    }

    pub(crate) const fn is_done(&self) -> bool {
        self.elapsed >= self.cycles
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn targets(velocity: i32, cycles: u32) -> std::vec::Vec<i32> {
        let mut ramp = Ramp::new(0, velocity, cycles);
        (0..cycles).map(|_| ramp.next_target()).collect()
    }

    #[test]
    fn velocity_falls_in_even_steps_to_zero() {
        assert_eq!(cycles_to_stop(100, 25), 4);
        assert_eq!(cycles_to_stop(-101, 25), 5);
        assert_eq!(targets(100, 4), [75, 125, 150, 150]);
        assert_eq!(targets(-100, 4), [-75, -125, -150, -150]);
    }

    #[test]
    fn axes_stay_in_proportion() {
        let fast = targets(1_000, 50);
        let slow = targets(100, 50);
        for (fast, slow) in fast.iter().zip(&slow) {
            assert!(
                (fast - 10 * slow).abs() < 10,
                "{fast} is not ten times {slow}"
            );
        }
    }

    #[test]
    fn a_standing_axis_is_done_at_once() {
        let mut ramp = Ramp::new(7, 0, 0);
        assert!(ramp.is_done());
        assert_eq!(ramp.next_target(), 7);
    }
}
