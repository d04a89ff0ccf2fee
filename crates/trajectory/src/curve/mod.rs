//! Curves through given points at given times: keyframes, motion files.
//!
//! A piece goes from one point to the next as a polynomial of the share of its duration that has passed. It is computed with integers
//! alone, exact at both ends and to 2^-20 counts between them, the same on every machine.

mod keyframes;

use crate::fixed::part_of;
use crate::quantity::Position;

pub use keyframes::{Keyframe, KeyframeError, KeyframeMotion, Playhead};

/// The share of a duration that has passed, 0 to 1, in steps of 2^-32.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Share(u64);

/// Everything.
const WHOLE: Share = Share(u64::MAX);
/// The last step before it.
const LAST: Share = Share((u32::MAX as u64) << 32);

impl Share {
    /// `elapsed` out of `duration`, in any unit, to three steps; 1 when it is over.
    #[must_use]
    pub const fn of(elapsed: u64, duration: u64) -> Self {
        if elapsed >= duration {
            return WHOLE;
        }
        // Down to 32 bits, so that the dividend fits 64. Just before the end both are the same then: that is the last step, and not 1.
        let places = 32_u32.saturating_sub(duration.leading_zeros());
        match ((elapsed >> places) << 32).checked_div(duration >> places) {
            Some(share) if share <= u32::MAX as u64 => Self(share << 32),
            _ => LAST,
        }
    }

    /// This share of a way of fewer than 2^20 counts, rounded to the nearest to 2^-11 counts.
    #[inline]
    pub(crate) const fn of_few_counts(self, way: i32) -> i32 {
        let share = (self.0 >> 33) as i64;
        ((share * way as i64 + (1 << 30)) >> 31) as i32
    }

    /// This share of a way, rounded to the nearest count, a half upward.
    pub(crate) const fn of_counts(self, way: i32) -> i32 {
        // Digits of 31 bits make every product one signed multiplication of the processor.
        let high = (self.0 >> 33) as i64 * way as i64;
        let low = ((self.0 >> 2) & 0x7FFF_FFFF) as i64;
        let low = (low * way as i64) >> 31;
        ((high + low + (1 << 30)) >> 31) as i32
    }

    /// The share of the way of a [`Piece::minimum_jerk`] that has passed: a [`Piece::line`] there is the same curve, computed once for any
    /// number of axes.
    #[must_use]
    pub const fn with_minimum_jerk(self) -> Self {
        /// The highest coefficient, 15 of these, stays below 2^62.
        const WAY_BITS: u32 = 57;
        let passed = way_at(minimum_jerk(1 << WAY_BITS), self).cast_unsigned();
        if passed >= 1 << WAY_BITS {
            return WHOLE;
        }
        Self(passed << (u64::BITS - WAY_BITS))
    }
}

/// The way from one point to the next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Piece {
    start: Position,
    /// Coefficients of the powers 1 to 5 of the share, in position units.
    coefficients: [i64; 5],
}

impl Piece {
    /// A straight line: constant velocity.
    #[must_use]
    pub const fn line(from: Position, to: Position) -> Self {
        Self {
            start: from,
            coefficients: [distance(from, to), 0, 0, 0, 0],
        }
    }

    /// A cubic that leaves and arrives with given velocities, each as the way that it would go in the duration of the piece.
    #[must_use]
    pub const fn cubic(
        from: Position,
        to: Position,
        leaving: Position,
        arriving: Position,
    ) -> Self {
        let (way, leaving, arriving) = (distance(from, to), leaving.units(), arriving.units());
        let square = way.wrapping_mul(3).wrapping_sub(leaving.wrapping_mul(2));
        let cube = leaving.wrapping_add(arriving);
        Self {
            start: from,
            coefficients: [
                leaving,
                square.wrapping_sub(arriving),
                cube.wrapping_sub(way.wrapping_mul(2)),
                0,
                0,
            ],
        }
    }

    /// The curve of fifth degree that leaves and arrives with given velocities, each as the way that it would go in the duration of the
    /// piece, and with given accelerations, each as the way that it would go from rest in that time. Pieces that share these at
    /// their border make a curve without a step of the acceleration.
    #[must_use]
    pub const fn quintic(from: Position, to: Position, leaving: Border, arriving: Border) -> Self {
        let way = distance(from, to);
        let (l, r) = (leaving.velocity.units(), arriving.velocity.units());
        let (a, b) = (leaving.acceleration.units(), arriving.acceleration.units());
        let cube = sum([(10, way), (-6, l), (-4, r), (-3, a), (1, b)]);
        let fourth = sum([(-15, way), (8, l), (7, r), (3, a), (-2, b)]);
        let fifth = sum([(6, way), (-3, l), (-3, r), (-1, a), (1, b)]);
        Self {
            start: from,
            coefficients: [l, a, cube, fourth, fifth],
        }
    }

    /// From rest to rest with the least jerk: `10 u³ - 15 u⁴ + 6 u⁵`. Velocity and acceleration are zero at both ends; the highest velocity,
    /// in the middle, is 15/8 of the mean one.
    #[must_use]
    pub const fn minimum_jerk(from: Position, to: Position) -> Self {
        Self {
            start: from,
            coefficients: minimum_jerk(distance(from, to)),
        }
    }

    /// Where it starts.
    #[must_use]
    pub const fn start(&self) -> Position {
        self.start
    }

    /// Coefficients of the powers 1 to 5 of the share, in position units.
    #[must_use]
    pub const fn coefficients(&self) -> [i64; 5] {
        self.coefficients
    }

    /// The position at a share of the duration.
    #[must_use]
    pub const fn at(&self, share: Share) -> Position {
        let way = way_at(self.coefficients, share);
        self.start.moved_by(Position::from_units(way))
    }
}

/// The coefficients of [`Piece::minimum_jerk`].
#[inline(always)]
const fn minimum_jerk(way: i64) -> [i64; 5] {
    [
        0,
        0,
        way.wrapping_mul(10),
        way.wrapping_mul(-15),
        way.wrapping_mul(6),
    ]
}

/// The way that has passed at a share of the duration, from coefficients of the powers 1 to 5. Inlined: constant ones take less.
#[inline(always)]
const fn way_at([one, two, three, four, five]: [i64; 5], share: Share) -> i64 {
    if share.0 == WHOLE.0 {
        let three = three.wrapping_add(four).wrapping_add(five);
        return one.wrapping_add(two).wrapping_add(three);
    }
    let way = part_of(five, share.0).wrapping_add(four);
    let way = part_of(way, share.0).wrapping_add(three);
    let way = part_of(way, share.0).wrapping_add(two);
    let way = part_of(way, share.0).wrapping_add(one);
    part_of(way, share.0)
}

/// How a piece leaves or arrives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Border {
    /// Velocity times duration.
    pub velocity: Position,
    /// Half the acceleration times the square of the duration.
    pub acceleration: Position,
}

const fn sum([a, b, c, d, e]: [(i64, i64); 5]) -> i64 {
    let (ab, cd) = (
        product(a).wrapping_add(product(b)),
        product(c).wrapping_add(product(d)),
    );
    ab.wrapping_add(cd).wrapping_add(product(e))
}

const fn product((factor, value): (i64, i64)) -> i64 {
    value.wrapping_mul(factor)
}

const fn distance(from: Position, to: Position) -> i64 {
    to.distance_from(from).units()
}

/// The mean velocity between two points of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chord {
    /// Duration, in any unit.
    pub duration: f32,
    /// Mean velocity, in any unit.
    pub velocity: f32,
}

impl Chord {
    /// The velocity at the point between this chord and the next one, with which cubics stay between their points: the weighted
    /// harmonic mean of both after Fritsch and Butland (1984), 0 where the direction turns.
    #[must_use]
    pub fn velocity_before(self, next: Self) -> f32 {
        if self.velocity * next.velocity <= 0.0 {
            return 0.0;
        }
        let before = 2.0 * next.duration + self.duration;
        let after = next.duration + 2.0 * self.duration;
        (before + after) / (before / self.velocity + after / next.velocity)
    }
}

#[cfg(test)]
mod tests;
