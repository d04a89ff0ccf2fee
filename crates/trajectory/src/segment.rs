//! A stretch of a profile with constant jerk.

use crate::fixed::{self, FRACTION_BITS, TIME_BITS};

/// Constant jerk from the end of the segment before it to its own end.
///
/// The position is a cubic whose coefficients are the exact values of the floats below: a sample has the rounding of a position
/// unit, not that of a float.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Segment {
    /// Ticks from the start of the profile to the end of the segment.
    pub(crate) end: u64,
    /// Position at its start, in units from the start of the profile.
    pub(crate) position: i64,
    /// At its start.
    pub(crate) velocity: f32,
    /// The part of the velocity that is too small for the other float: the share of this segment in what rounding has left over.
    pub(crate) correction: f32,
    /// At its start.
    pub(crate) acceleration: f32,
    /// A number of which a sixth is a float too.
    pub(crate) jerk: f32,
}

impl Segment {
    pub(crate) const EMPTY: Self = Self {
        end: 0,
        position: 0,
        velocity: 0.0,
        correction: 0.0,
        acceleration: 0.0,
        jerk: 0.0,
    };

    /// Position in units from the start of the profile, `elapsed` ticks after the start of the segment of `duration` ticks.
    pub(crate) fn position_at(&self, elapsed: u64, duration: u64) -> i64 {
        self.position.wrapping_add(self.way(elapsed, duration))
    }

    /// Way since the start of the segment. The time is a share of the next power of two above the duration, so the coefficients are
    /// scaled by shifts and a share needs no division. `elapsed` is at most `duration`.
    pub(crate) fn way(&self, elapsed: u64, duration: u64) -> i64 {
        let free = duration.leading_zeros();
        let share = elapsed.wrapping_shl(free);
        let cycles = (u64::BITS - TIME_BITS) as i32 - free as i32;
        let units = FRACTION_BITS as i32;
        let mut linear = fixed::scaled(self.velocity, cycles + units);
        if self.correction != 0.0 {
            linear = linear.wrapping_add(fixed::scaled(self.correction, cycles + units));
        }
        let square = fixed::scaled(self.acceleration, 2 * cycles + units - 1);
        let cubic = fixed::scaled(self.jerk / 6.0, 3 * cycles + units);
        let slope = fixed::part_of(cubic, share).wrapping_add(square);
        let slope = fixed::part_of(slope, share).wrapping_add(linear);
        fixed::part_of(slope, share)
    }

    /// Velocity and acceleration `elapsed` ticks after its start, to 24 bits.
    pub(crate) fn motion_at(&self, elapsed: u64) -> (f32, f32) {
        let cycles = fixed::cycles(elapsed);
        let change = self.jerk * cycles;
        (
            self.velocity + self.correction + (self.acceleration + 0.5 * change) * cycles,
            self.acceleration + change,
        )
    }

    /// Its highest velocity in a direction, to 22 bits.
    pub(crate) fn velocity_towards(&self, direction: f32, duration: u64) -> f32 {
        let (end, last) = self.motion_at(duration);
        let sign = 1_f32.copysign(direction);
        let most = (sign * self.velocity).max(sign * end);
        // It rises first and falls then.
        if sign * self.acceleration > 0.0 && sign * last < 0.0 {
            let gain = 0.5 * self.acceleration * self.acceleration / self.jerk.abs();
            return most.max(sign * self.velocity + gain);
        }
        most
    }

    /// Whether its coefficients, scaled for its duration, are small enough to be summed up.
    pub(crate) fn fits(&self, duration: u64) -> bool {
        // Twice the duration is not below the power of two by which it is scaled.
        let cycles = 2.0 * fixed::cycles(duration);
        let largest = ((self.jerk.abs() / 6.0 * cycles + 0.5 * self.acceleration.abs()) * cycles
            + self.velocity.abs())
            * cycles;
        // Also false for what is no number.
        largest < LARGEST_COUNTS
    }
}

/// What the terms of a segment may sum up to, in counts: half the range of a position. They are up to ten times the way.
const LARGEST_COUNTS: f32 = (1_u64 << 38) as f32;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_highest_velocity_is_at_an_end_or_between_them() {
        let highest = |acceleration, jerk, direction, cycles: u64| {
            let segment = Segment {
                velocity: 3.0,
                acceleration,
                jerk,
                ..Segment::EMPTY
            };
            segment.velocity_towards(direction, cycles << TIME_BITS)
        };
        assert_eq!(highest(2.0, -1.0, 1.0, 4), 5.0);
        assert_eq!(highest(2.0, -1.0, 0.5, 1), 4.5);
        assert_eq!(highest(2.0, -1.0, -1.0, 4), -3.0);
        assert_eq!(highest(2.0, -1.0, -1.0, 6), 3.0);
        assert_eq!(highest(-2.0, 1.0, -7.0, 4), -1.0);
        assert_eq!(highest(-2.0, 1.0, 1.0, 1), 3.0);
        assert_eq!(highest(0.0, 0.0, 1.0, 4), 3.0);
    }
}
