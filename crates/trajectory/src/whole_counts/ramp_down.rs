//! A group slows down together, in proportion, on the line that it moves along.

/// The way of one axis from its velocity to standstill, in a given number of cycles.
///
/// The velocity falls by the same share in every cycle. Axes that take the same number of cycles keep the ratio of their velocities,
/// which is the direction of their path, and stop in the same cycle. Each set-point is computed from the start, so rounding does not add
/// up. 16 bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RampDown {
    start_counts: i32,
    velocity_counts: i32,
    cycles: u32,
    elapsed: u32,
}

impl RampDown {
    /// Before the first cycle: the latest set-point, the velocity in counts per cycle that led there, and the cycles until it is 0. With
    /// 0 cycles the axis stands at once.
    #[must_use]
    pub const fn new(start_counts: i32, velocity_counts: i32, cycles: u32) -> Self {
        Self {
            start_counts,
            velocity_counts,
            cycles,
            elapsed: 0,
        }
    }

    /// Cycles in which a velocity falls to zero when it changes by at most `change` in each, both in the same unit; no change counts as
    /// 1. The largest number of a group is for all of it.
    #[must_use]
    pub const fn cycles_to_stop(velocity: i32, change: u32) -> u32 {
        // `div_ceil` panics where the divisor is not known to the compiler.
        let size = velocity.unsigned_abs();
        match (size.checked_div(change), size.checked_rem(change)) {
            (Some(whole), Some(rest)) => whole + (rest != 0) as u32,
            _ => size,
        }
    }

    /// A cycle later; behind the end nothing changes.
    pub const fn advance(&mut self) {
        if self.elapsed < self.cycles {
            self.elapsed += 1;
        }
    }

    /// The set-point, rounded towards the start; wraps beyond 32 bits.
    #[must_use]
    pub const fn set_point(&self) -> i32 {
        self.after(self.elapsed)
    }

    /// The last set-point, known from the beginning; beyond 32 bits the end of 32 bits, so that it is inside no travel.
    #[must_use]
    pub const fn end(&self) -> i32 {
        // Below 2^62.
        let way = self.way_after(self.cycles) as i64;
        let way = if self.velocity_counts < 0 { -way } else { way };
        let end = self.start_counts as i64 + way;
        if end > i32::MAX as i64 {
            i32::MAX
        } else if end < i32::MIN as i64 {
            i32::MIN
        } else {
            end as i32
        }
    }

    /// The velocity in counts per cycle, rounded towards zero: what is left of the first one.
    #[must_use]
    pub const fn velocity(&self) -> i32 {
        let left = (self.cycles - self.elapsed) as u64;
        let size = self.velocity_counts.unsigned_abs() as u64 * left;
        match size.checked_div(self.cycles as u64) {
            Some(size) => self.forward(size),
            None => 0,
        }
    }

    /// Whether the last set-point is reached.
    #[must_use]
    pub const fn is_done(&self) -> bool {
        self.elapsed >= self.cycles
    }

    const fn after(&self, elapsed: u32) -> i32 {
        let way = self.way_after(elapsed);
        self.start_counts.wrapping_add(self.forward(way))
    }

    /// The counts that lie behind it, whatever its direction.
    const fn way_after(&self, elapsed: u32) -> u64 {
        let (cycles, elapsed) = (self.cycles as u64, elapsed as u64);
        // Sum over k = 1..=elapsed of velocity * (1 - k / cycles). At most cycles squared.
        let doubled = 2 * cycles;
        let Some(twice) = doubled.checked_sub(elapsed + 1) else {
            return 0;
        };
        product_over(
            self.velocity_counts.unsigned_abs(),
            elapsed * twice,
            doubled,
        )
    }

    /// In the direction of the velocity; the lower 32 bits.
    const fn forward(&self, size: u64) -> i32 {
        if self.velocity_counts < 0 {
            (size as i32).wrapping_neg()
        } else {
            size as i32
        }
    }
}

/// `factor * number / divisor`, rounded down, for a factor of at most 2^31 and a divisor of 1 to 2^33; wraps beyond 64 bits.
const fn product_over(factor: u32, number: u64, divisor: u64) -> u64 {
    let factor = factor as u64;
    // What machines do: one division.
    if let Some(product) = factor.checked_mul(number) {
        return match product.checked_div(divisor) {
            Some(quotient) => quotient,
            None => 0,
        };
    }
    let (Some(whole), Some(rest)) = (number.checked_div(divisor), number.checked_rem(divisor))
    else {
        return 0;
    };
    // The rest is below 2^33.
    match (factor * rest).checked_div(divisor) {
        Some(share) => factor.wrapping_mul(whole).wrapping_add(share),
        None => 0,
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use proptest::prelude::*;

    use super::*;

    fn set_points(start: i32, velocity: i32, cycles: u32) -> Vec<i32> {
        let mut ramp = RampDown::new(start, velocity, cycles);
        (0..=cycles)
            .map(|_| {
                ramp.advance();
                ramp.set_point()
            })
            .collect()
    }

    #[test]
    fn the_velocity_falls_in_even_steps_to_zero() {
        assert_eq!(set_points(0, 100, 4), [75, 125, 150, 150, 150]);
        assert_eq!(set_points(0, -100, 4), [-75, -125, -150, -150, -150]);
        let mut ramp = RampDown::new(0, -40, 4);
        let velocities = [(); 5].map(|()| {
            ramp.advance();
            ramp.velocity()
        });
        assert_eq!(velocities, [-30, -20, -10, 0, 0]);
    }

    #[test]
    fn cycles_to_stop_are_rounded_up() {
        for (velocity, change, cycles) in [
            (0, 5, 0),
            (4, 5, 1),
            (5, 5, 1),
            (6, 5, 2),
            (-6, 5, 2),
            (100, 25, 4),
            (-101, 25, 5),
            (7, 0, 7),
            (i32::MIN, 1, 1 << 31),
            (i32::MIN, u32::MAX, 1),
        ] {
            assert_eq!(RampDown::cycles_to_stop(velocity, change), cycles);
        }
    }

    #[test]
    fn an_axis_without_cycles_stands_at_once() {
        let mut ramp = RampDown::new(7, 5, 0);
        assert!(ramp.is_done());
        ramp.advance();
        assert_eq!((ramp.set_point(), ramp.end(), ramp.velocity()), (7, 7, 0));
    }

    #[test]
    fn set_points_wrap_at_the_end_of_32_bits() {
        assert_eq!(
            set_points(i32::MAX, 10, 2),
            [i32::MIN + 4, i32::MIN + 4, i32::MIN + 4]
        );
        assert_eq!(size_of::<RampDown>(), 16);
    }

    #[test]
    fn an_end_beyond_32_bits_is_the_end_of_32_bits() {
        for (start, velocity, cycles, end) in [
            (i32::MAX - 5, 10, 2, i32::MAX),
            (i32::MIN + 4, -10, 2, i32::MIN),
            (i32::MIN, 10, 2, i32::MIN + 5),
            // The fastest step and the slowest acceleration of a drive: 3.4e10 counts.
            (0, 16_384, 4_194_304, i32::MAX),
            (0, i32::MIN, u32::MAX, i32::MIN),
            (0, i32::MAX, u32::MAX, i32::MAX),
        ] {
            assert_eq!(RampDown::new(start, velocity, cycles).end(), end);
        }
    }

    proptest! {
        /// In exact arithmetic: where it is, that it changes by no more than it may, and that it ends where it said.
        #[test]
        fn every_set_point_is_that_of_exact_arithmetic(
            start in any::<i32>(),
            velocity in any::<i32>(),
            cycles in prop_oneof![1..1_000_u32, 1..=u32::MAX],
            share in 0.0..=1.0_f64,
        ) {
            let elapsed = (share * f64::from(cycles)) as u32;
            let ramp = RampDown { start_counts: start, velocity_counts: velocity, cycles, elapsed };
            let (v, n, k) = (i128::from(velocity), i128::from(cycles), i128::from(elapsed));
            // Towards zero, as the division of integers is.
            let way = v * k * (2 * n - k - 1) / (2 * n);
            prop_assert_eq!(ramp.set_point(), (i128::from(start) + way) as i32);
            prop_assert_eq!(i128::from(ramp.velocity()), v * (n - k) / n);
            let end = i128::from(start) + v * (n - 1) / 2;
            let ends = (i128::from(i32::MIN), i128::from(i32::MAX));
            prop_assert_eq!(i128::from(ramp.end()), end.clamp(ends.0, ends.1));
            prop_assert_eq!(ramp.is_done(), elapsed == cycles);
        }

        /// Two axes stay in proportion, and neither changes its step by more than its limit and a count of rounding.
        #[test]
        fn a_group_stays_on_its_line(
            fast in -16_384..=16_384_i32,
            slow in -16_384..=16_384_i32,
            changes in (1..2_000_u32, 1..2_000_u32),
        ) {
            let cycles = RampDown::cycles_to_stop(fast, changes.0).max(RampDown::cycles_to_stop(slow, changes.1));
            let (x, y) = (set_points(0, fast, cycles), set_points(0, slow, cycles));
            for (x, y) in x.iter().zip(&y) {
                let off = i64::from(*x) * i64::from(slow) - i64::from(*y) * i64::from(fast);
                prop_assert!(off.abs() <= i64::from(fast.abs().max(slow.abs())), "{} {}", x, y);
            }
            for (points, velocity, change) in [(x, fast, changes.0), (y, slow, changes.1)] {
                let mut before = (0, velocity);
                for point in points {
                    let step = point - before.0;
                    prop_assert!((step - before.1).unsigned_abs() <= change + 1, "{} after {}", step, before.1);
                    before = (point, step);
                }
                prop_assert_eq!(before.1, 0);
            }
        }
    }
}
