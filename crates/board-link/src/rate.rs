//! The rate at which the time of the set-points runs: 0 to 2 times that of the cycles, with a bounded change, and a bounded change of
//! the change.

use trajectory::Time;

const RATE_BITS: u32 = 30;
/// The time of the set-points runs as that of the cycles.
pub(crate) const ONE: i64 = 1 << RATE_BITS;
const TIME_BITS: u32 = 32;

/// A rate, and how it changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Rate {
    rate: i64,
    /// Change in a cycle, in units of `unit`.
    steps: i64,
    /// Half the largest change of the change.
    unit: i64,
    most_steps: i64,
}

impl Rate {
    /// Standing still; `ramp` is the largest change in a cycle, `ramp_change` that of the change. The slowest ramp takes 2^30 cycles.
    pub(crate) fn standing(ramp: f32, ramp_change: f32) -> Self {
        // Half of it: the last change before a goal is whatever is left, and comes on top.
        let unit = ((ramp_change / 2.0 * ONE as f32) as i64).clamp(1, ONE);
        let most = ((ramp * ONE as f32) as i64).clamp(1, ONE);
        Self {
            rate: 0,
            steps: 0,
            unit,
            most_steps: most.checked_div(unit).unwrap_or(1).max(1),
        }
    }

    /// The same at a rate that it has at once; for axes that are at rest whatever the rate.
    pub(crate) const fn running_at(self, rate: i64) -> Self {
        Self {
            rate,
            steps: 0,
            ..self
        }
    }

    /// The rate, 0 to 2.
    pub(crate) fn value(&self) -> f32 {
        of_one(self.rate)
    }

    /// The rate, 1 as [`ONE`]: at most 2^31.
    pub(crate) const fn bits(&self) -> u32 {
        self.rate as u32
    }

    pub(crate) const fn is_steady(&self) -> bool {
        self.steps == 0
    }

    pub(crate) fn is_standing(&self) -> bool {
        self.rate == 0 && self.steps == 0
    }

    /// At once; for an axis that is at rest whatever the rate.
    pub(crate) fn stand(&mut self) {
        self.rate = 0;
        self.steps = 0;
    }

    /// One cycle later, on the way to a rate. Returns the time of the set-points that has passed. The rate never goes beyond the one
    /// that it was on the way to.
    pub(crate) fn advance(&mut self, goal: i64) -> Time {
        let before = self.rate;
        if self.steps == 0 && before == goal {
            let ticks = before << (TIME_BITS - RATE_BITS);
            return Time::from_ticks(ticks.unsigned_abs());
        }
        let left = goal - self.rate;
        // Seen from the side of the goal, everything is a rise.
        let sign = if left < 0 { -1 } else { 1 };
        let rising = self.steps * sign;
        let ends_at = |steps: i64| steps * (steps + 1) / 2 * self.unit;
        let next = if rising < 0 {
            rising + 1
        } else {
            let faster = (rising + 1).min(self.most_steps);
            let fits = |steps: i64| ends_at(steps) <= left.abs();
            let slower = (rising - 1).max(0);
            [faster, rising]
                .into_iter()
                .find(|&steps| fits(steps))
                .unwrap_or(slower)
        };
        self.steps = next * sign;
        self.rate += self.steps * self.unit;
        if self.steps == 0 && (goal - self.rate).abs() < self.unit {
            // The rest is smaller than the smallest change.
            self.rate = goal;
        }
        self.rate = self.rate.clamp(0, 2 * ONE);
        // The mean of both rates.
        let ticks = (before + self.rate) << (TIME_BITS - RATE_BITS - 1);
        Time::from_ticks(ticks.unsigned_abs())
    }

    /// The time of the set-points that passes until the rate is down at a goal, when it rises for one cycle more first: whoever has less
    /// must not let it rise.
    pub(crate) fn way_down_after_a_rise_to(&self, goal: i64) -> f32 {
        let mut next = *self;
        next.steps = (next.steps + 1).min(next.most_steps);
        next.rate = (next.rate + next.steps * next.unit).clamp(0, 2 * ONE);
        let passed = self.value().max(next.value());
        passed + next.way_down_to(goal)
    }

    /// The time of the set-points that passes until the rate is down at a goal, or a little more.
    fn way_down_to(&self, goal: i64) -> f32 {
        let unit = of_one(self.unit);
        let (steps, most) = (self.steps as i32 as f32, self.most_steps as i32 as f32);
        let rising = steps.max(0.0);
        // What is rising goes on rising a little.
        let top = of_one(self.rate) + unit * rising * (rising + 1.0) / 2.0;
        let fall = top - of_one(goal);
        if fall <= 0.0 {
            return 0.0;
        }
        let cycles = if fall >= unit * most * most {
            fall / (unit * most) + most
        } else {
            2.0 * root_or_more(fall / unit)
        };
        // Two cycles more: the fall begins in the next one, and is a staircase.
        top * (rising + 2.0) + (top + of_one(goal)) / 2.0 * cycles
    }
}

/// A rate in parts of one. It is at most 2^31, which a processor with 32 bits converts by itself.
fn of_one(rate: i64) -> f32 {
    rate as u32 as f32 / ONE as f32
}

/// The square root of a positive number, or up to 0.2 % more. The exact one has a table of a quarter of a KiB.
fn root_or_more(square: f32) -> f32 {
    // The mean of its bits and those of 1 halves the exponent, and is within 7 %; after a step of Newton no root is too small.
    let guess = f32::from_bits((square.to_bits() + 1.0_f32.to_bits()) / 2);
    (guess + square / guess) / 2.0
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// Whatever the goals: change and change of the change are bounded, no goal is overshot, and each is reached.
        #[test]
        fn changes_are_bounded(
            goals in proptest::collection::vec((0..=2 * ONE, 1..400_usize), 1..20),
            ramp in 1.0e-4_f32..0.2,
            share in 0.01_f32..1.0,
        ) {
            let mut rate = Rate::standing(ramp, ramp * share);
            let highest = goals.iter().map(|goal| goal.0).max().unwrap_or(0);
            let (mut before, mut change_before) = (0, 0);
            let mut step = |rate: &mut Rate, goal| {
                rate.advance(goal);
                let change = rate.rate - before;
                assert!(change.abs() <= (ramp * ONE as f32) as i64 + 1);
                let most = (ramp * share * ONE as f32) as i64 + 1;
                assert!((change - change_before).abs() <= most, "{change} {change_before}");
                assert!((0..=highest).contains(&rate.rate));
                (before, change_before) = (rate.rate, change);
            };
            for &(goal, cycles) in &goals {
                for _ in 0..cycles {
                    step(&mut rate, goal);
                }
            }
            let goal = goals[goals.len() - 1].0;
            for _ in 0..100_000 {
                if rate.rate == goal && rate.steps == 0 { break; }
                step(&mut rate, goal);
            }
            prop_assert_eq!((rate.rate, rate.steps), (goal, 0));
        }

        #[test]
        fn a_root_is_exact_or_a_little_more(bits in 1.0e-20_f32.to_bits()..1.0e20_f32.to_bits()) {
            let square = f32::from_bits(bits);
            let share = f64::from(root_or_more(square)) / f64::from(square).sqrt();
            prop_assert!((1.0 - 1.0e-7..1.002).contains(&share), "{share}");
        }

        /// It is down at the goal within the way that was said, from wherever it is.
        #[test]
        fn it_is_down_within_its_way(
            first in 0..=2 * ONE,
            cycles in 0..400_usize,
            goal in 0..=2 * ONE,
            ramp in 1.0e-3_f32..0.2,
            share in 0.01_f32..1.0,
        ) {
            let mut rate = Rate::standing(ramp, ramp * share);
            for _ in 0..cycles {
                rate.advance(first);
            }
            let said = rate.way_down_to(goal);
            let mut way = 0.0;
            while rate.rate > goal {
                way += rate.advance(goal).cycles();
            }
            prop_assert!(way <= said * 1.000_1 + 1e-3, "{way} of {said}");
        }
    }
}
