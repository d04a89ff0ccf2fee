//! Time and position: exact numbers, because sums of millions of cycles shall not drift.

use core::fmt;

use crate::fixed::{self, FRACTION_BITS, TIME_BITS};

/// A time in cycles, with 32 bits behind the point: up to 2^32 cycles, which are 49 days at 1 kHz.
///
/// A cycle is whatever the user calls one: the period of the set-points, usually 1 ms. All limits are per cycle too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Time(u64);

impl Time {
    /// The start.
    pub const ZERO: Self = Self(0);
    /// The latest time.
    pub const MAX: Self = Self(u64::MAX);

    /// Whole cycles.
    #[must_use]
    pub const fn from_cycles(cycles: u32) -> Self {
        Self((cycles as u64) << TIME_BITS)
    }

    /// A time in any unit of which `per_cycle` make a cycle, for instance microseconds, rounded down; [`Time::MAX`] when it is later
    /// than that or `per_cycle` is 0.
    #[must_use]
    pub const fn from_units(units: u64, per_cycle: u32) -> Self {
        let per_cycle = per_cycle as u64;
        let (Some(whole), Some(rest)) =
            (units.checked_div(per_cycle), units.checked_rem(per_cycle))
        else {
            return Self::MAX;
        };
        if whole >> TIME_BITS != 0 {
            return Self::MAX;
        }
        // The rest is below 2^32. The division cannot fail: it did not above.
        match (rest << TIME_BITS).checked_div(per_cycle) {
            Some(fraction) => Self((whole << TIME_BITS) | fraction),
            None => Self::MAX,
        }
    }

    /// In units of 2^-32 cycles.
    #[must_use]
    pub const fn from_ticks(ticks: u64) -> Self {
        Self(ticks)
    }

    /// In units of 2^-32 cycles.
    #[must_use]
    pub const fn ticks(self) -> u64 {
        self.0
    }

    /// In cycles, to 24 bits.
    #[must_use]
    pub fn cycles(self) -> f32 {
        fixed::cycles(self.0)
    }

    /// The first whole cycle that is not earlier.
    #[must_use]
    pub const fn whole_cycles(self) -> u32 {
        let whole = self.0 >> TIME_BITS;
        let has_fraction = self.0 as u32 != 0;
        (whole as u32).saturating_add(has_fraction as u32)
    }

    /// Later by another time; ends at [`Time::MAX`].
    #[must_use]
    pub const fn after(self, other: Self) -> Self {
        Self(self.0.saturating_add(other.0))
    }

    /// Time since another one; 0 when that one is later.
    #[must_use]
    pub const fn since(self, other: Self) -> Self {
        Self(self.0.saturating_sub(other.0))
    }
}

/// A position in counts, with 24 bits behind the point: up to 2^39 counts either way.
///
/// The fraction is what makes replanning in every cycle exact: a velocity below one count per cycle is not lost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Position(i64);

impl Position {
    /// The origin.
    pub const ZERO: Self = Self(0);
    /// Units of a count.
    pub const UNITS: i64 = 1 << FRACTION_BITS;

    /// Whole counts.
    #[must_use]
    pub const fn from_counts(counts: i32) -> Self {
        Self((counts as i64) << FRACTION_BITS)
    }

    /// In units of 2^-24 counts.
    #[must_use]
    pub const fn from_units(units: i64) -> Self {
        Self(units)
    }

    /// In units of 2^-24 counts.
    #[must_use]
    pub const fn units(self) -> i64 {
        self.0
    }

    /// The way at a constant velocity in counts per cycle, exact to a unit.
    #[must_use]
    pub fn at_velocity(velocity: f32, time: Time) -> Self {
        Self(fixed::travelled(velocity, time.ticks()))
    }

    /// The set-point: the nearest count, a half rounded up, and the lower 32 bits of it. An axis that turns for ever wraps, as the
    /// counters of drives do; the difference of two set-points by `wrapping_sub` stays the step.
    #[must_use]
    pub const fn counts(self) -> i32 {
        self.wide_counts() as i32
    }

    /// The nearest count, a half rounded up, without wrapping.
    #[must_use]
    pub const fn wide_counts(self) -> i64 {
        self.0.wrapping_add(1 << (FRACTION_BITS - 1)) >> FRACTION_BITS
    }

    /// Moved by a distance.
    #[must_use]
    pub const fn moved_by(self, distance: Self) -> Self {
        Self(self.0.wrapping_add(distance.0))
    }

    /// The distance from another position to this one.
    #[must_use]
    pub const fn distance_from(self, other: Self) -> Self {
        Self(self.0.wrapping_sub(other.0))
    }
}

impl fmt::Display for Time {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} cycles", self.cycles())
    }
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} counts", self.wide_counts())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_in_microseconds_are_cycles() {
        assert_eq!(Time::from_units(3_000, 1_000), Time::from_cycles(3));
        assert_eq!(Time::from_units(250, 1_000).ticks(), 1 << 30);
        assert_eq!(Time::from_units(7, 0), Time::MAX);
        assert_eq!(Time::from_units(1 << 32, 1), Time::MAX);
        assert_eq!(
            Time::from_units((1 << 32) - 1, 1),
            Time::from_cycles(u32::MAX)
        );
        assert_eq!(Time::from_units(u64::MAX, u32::MAX), Time::MAX);
    }

    #[test]
    fn cycles_are_rounded_up_to_whole_ones() {
        assert_eq!(Time::from_cycles(5).whole_cycles(), 5);
        assert_eq!(Time::from_units(5_001, 1_000).whole_cycles(), 6);
        assert_eq!(Time::MAX.whole_cycles(), u32::MAX);
        assert_eq!(Time::ZERO.whole_cycles(), 0);
    }

    #[test]
    fn times_end_at_their_range() {
        assert_eq!(Time::MAX.after(Time::from_cycles(1)), Time::MAX);
        assert_eq!(Time::from_cycles(1).since(Time::from_cycles(2)), Time::ZERO);
        assert_eq!(
            Time::from_cycles(3).since(Time::from_cycles(2)).cycles(),
            1.0
        );
    }

    #[test]
    fn set_points_are_the_nearest_counts() {
        let half = Position::from_units(1 << 23);
        assert_eq!(half.counts(), 1);
        assert_eq!(Position::from_units((1 << 23) - 1).counts(), 0);
        assert_eq!(Position::from_units(-(1 << 23)).counts(), 0);
        assert_eq!(Position::from_counts(-7).counts(), -7);
        assert_eq!(
            Position::from_counts(i32::MIN)
                .distance_from(Position::from_counts(i32::MAX))
                .wide_counts(),
            -0xFFFF_FFFF
        );
    }

    #[test]
    fn set_points_beyond_32_bits_wrap() {
        let beyond = Position::from_counts(i32::MAX).moved_by(Position::from_counts(3));
        assert_eq!(beyond.wide_counts(), i64::from(i32::MAX) + 3);
        assert_eq!(beyond.counts().wrapping_sub(i32::MAX), 3);
    }
}
