//! An axis that has fallen behind its set-points is led back to them.

/// Parts of a count in which velocities are kept.
pub const FRACTION: i32 = 256;

/// What a step may be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepLimits {
    /// Largest step, in counts per cycle.
    pub most_counts: u16,
    /// Largest change of the step from one cycle to the next, in 1/256 counts per cycle; 0 counts as 1.
    pub change_256ths: u32,
}

/// How far an axis is behind a set-point that moves, and its velocity.
///
/// The axis gains on the set-point as fast as its limits allow, and only as much as it can lose again until it is there: it does not go
/// past. The set-point moves with the velocity that it had in the last cycle, as far as the axis knows; it may move otherwise in each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Lag {
    /// From the axis to the set-point, in counts.
    pub owed_counts: i32,
    /// The part of it that was owed before the set-point moved in this cycle.
    pub left_over_counts: i32,
    /// Velocity of the axis in 1/256 counts per cycle, at most [`StepLimits::most_counts`] in size.
    pub velocity_256ths: i32,
}

/// A step, and the velocity that it leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Step {
    /// In counts; never further than to the set-point.
    pub counts: i32,
    /// In 1/256 counts per cycle.
    pub velocity_256ths: i32,
    /// Whether the axis is at its set-point then, and as fast as it.
    pub is_met: bool,
}

impl Lag {
    /// The step of this cycle.
    #[must_use]
    pub fn step(&self, limits: &StepLimits) -> Step {
        const ONE: i64 = FRACTION as i64;
        let change = i64::from(limits.change_256ths.max(1));
        let owed = i64::from(self.owed_counts);
        let left_over = i64::from(self.left_over_counts);
        let target_velocity = (owed - left_over) * ONE;
        let wanted = target_velocity
            + extra(left_over.unsigned_abs() * ONE as u64, change as u64) * left_over.signum();
        let before = i64::from(self.velocity_256ths);
        let most = i64::from(limits.most_counts) * ONE;
        // In place of `clamp`, which panics where its bounds could be the wrong way round.
        let velocity = wanted.max(before - change).min(before + change);
        let velocity = velocity.max(-most).min(most);
        let step = (velocity / ONE).max(owed.min(0)).min(owed.max(0));
        let kept = if step == velocity / ONE {
            velocity
        } else {
            step * ONE
        };
        Step {
            // Both at most 2^16 counts in size.
            counts: step as i32,
            velocity_256ths: kept as i32,
            is_met: step == owed && step * ONE == target_velocity,
        }
    }
}

/// Velocity beyond that of the set-point from which what is left over is just enough to slow down again by `change` in every cycle: the
/// largest `r` for which `r + (r - change) + (r - 2 change) + …`, as long as these are positive, is at most `left`. At least a count in a
/// cycle, and never more than is left. All in 1/256 counts, `left` at most 2^39.
fn extra(left: u64, change: u64) -> i64 {
    let quotient = |dividend: u64, divisor: u64| dividend.checked_div(divisor).unwrap_or(0);
    // The cycles behind the first one, m: change * m (m + 1) / 2 <= left.
    let cycles = (root(1 + quotient(8 * left, change)) - 1) / 2;
    let extra = quotient(left, cycles + 1) + cycles * change / 2;
    extra.max(FRACTION as u64).min(left) as i64
}

/// The square root, rounded down, bit by bit: that of the core library is faster, but has a table of half a KiB, and few cycles need one.
const fn root(square: u64) -> u64 {
    let (mut rest, mut root) = (square, 0);
    // The highest power of four that is not above it.
    let mut bit = 1 << ((square | 1).ilog2() & !1);
    while bit != 0 {
        let with_bit = root + bit;
        root >>= 1;
        if rest >= with_bit {
            rest -= with_bit;
            root += bit;
        }
        bit >>= 2;
    }
    root
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    const LIMITS: StepLimits = StepLimits {
        most_counts: 100,
        change_256ths: 10 * 256,
    };

    /// Steps towards set-points that move by so much in each cycle, from standstill and so far behind.
    fn steps(behind: i32, by: &[i32], limits: &StepLimits) -> Vec<Step> {
        let (mut left_over_counts, mut velocity_256ths) = (behind, 0);
        by.iter()
            .map(|by| {
                let lag = Lag {
                    owed_counts: left_over_counts + by,
                    left_over_counts,
                    velocity_256ths,
                };
                let step = lag.step(limits);
                left_over_counts = lag.owed_counts - step.counts;
                velocity_256ths = step.velocity_256ths;
                step
            })
            .collect()
    }

    proptest! {
        #[test]
        fn the_root_is_that_of_the_standard_library(square: u64, shift in 0..64_u32) {
            prop_assert_eq!(root(square >> shift), (square >> shift).isqrt());
        }

        #[test]
        fn the_root_of_a_square_is_exact(side: u32) {
            let square = u64::from(side) * u64::from(side);
            prop_assert_eq!(root(square), u64::from(side));
            prop_assert_eq!(root(square.saturating_sub(1)), square.saturating_sub(1).isqrt());
        }
    }

    #[test]
    fn a_way_at_rest_is_a_trapezoid() {
        let counts: Vec<i32> = steps(300, &[0; 16], &LIMITS)
            .iter()
            .map(|step| step.counts)
            .collect();
        assert_eq!(
            counts,
            [10, 20, 30, 40, 50, 50, 40, 30, 20, 10, 0, 0, 0, 0, 0, 0]
        );
    }

    #[test]
    fn a_set_point_that_moves_is_met_and_followed() {
        let steps = steps(80, &[60; 40], &LIMITS);
        let met = steps.iter().position(|step| step.is_met).unwrap();
        assert_eq!(steps[met].counts, 60);
        assert!(steps.iter().all(|step| step.counts <= 100));
        assert_eq!(
            steps
                .iter()
                .take(met + 1)
                .map(|step| step.counts)
                .sum::<i32>(),
            80 + 60 * (met as i32 + 1)
        );
    }

    #[test]
    fn an_axis_at_its_set_point_stays() {
        for limits in [
            LIMITS,
            StepLimits {
                most_counts: 0,
                change_256ths: 0,
            },
        ] {
            let [step] = steps(0, &[0], &limits)[..] else {
                panic!("one step")
            };
            assert_eq!(
                step,
                Step {
                    counts: 0,
                    velocity_256ths: 0,
                    is_met: true
                }
            );
        }
    }

    proptest! {
        /// Any numbers: within the limits, and not past the set-point.
        #[test]
        fn a_step_keeps_its_limits(
            owed in any::<i32>(),
            left_over in any::<i32>(),
            share in -1.0..=1.0_f64,
            most_counts in any::<u16>(),
            change_256ths in any::<u32>(),
        ) {
            let velocity_256ths = (share * f64::from(most_counts) * 256.0) as i32;
            let lag = Lag { owed_counts: owed, left_over_counts: left_over, velocity_256ths };
            let step = lag.step(&StepLimits { most_counts, change_256ths });
            prop_assert!(step.counts.unsigned_abs() <= u32::from(most_counts));
            prop_assert!(step.velocity_256ths.unsigned_abs() <= u32::from(most_counts) * 256);
            prop_assert!(step.counts.unsigned_abs() <= owed.unsigned_abs());
            prop_assert!(step.counts == 0 || step.counts.signum() == owed.signum());
            // Faster by the limit at most; slower by more only where it would go past.
            let faster = (i64::from(step.velocity_256ths) - i64::from(velocity_256ths)) * i64::from(step.counts.signum());
            prop_assert!(faster <= i64::from(change_256ths.max(1)), "{}", faster);
        }

        /// A set-point that stands is reached, without a change beyond the limit on the way.
        #[test]
        fn what_is_left_over_arrives(behind in -20_000..=20_000_i32, most_counts in 1..=500_u16, change in 1..=500_u32) {
            let limits = StepLimits { most_counts, change_256ths: change * 256 };
            let steps = steps(behind, &[0; 45_000], &limits);
            prop_assert_eq!(steps.iter().map(|step| step.counts).sum::<i32>(), behind);
            prop_assert!(steps.last().is_some_and(|step| step.is_met));
            for pair in steps.windows(2) {
                prop_assert!((pair[1].counts - pair[0].counts).unsigned_abs() <= change + 1, "{:?}", pair);
            }
        }
    }
}
