//! Timed segments: what a host sends ahead of time, and what a board plays.
//!
//! A segment takes every axis from where the one before ended to a new position, in a given time, along a polynomial. All numbers are
//! integers, so a host and a board make the same [`Piece`] of it, to the last bit.

mod admission;
mod begin;
mod border;
mod checks;
mod cruise;
mod halves;
mod orders;
mod pace;
mod phase;
mod player;
mod preview;
mod queue;
mod quick;
mod split;

use serde::{Deserialize, Serialize};
use trajectory::curve::{Border, Piece};
use trajectory::{Position, Time};

pub use admission::Admission;
pub use begin::{Begin, SegmentConfig};
pub use phase::{PlayerState, StreamPhase};
pub use player::Player;
pub use preview::SegmentPreview;
pub use queue::SegmentQueue;

/// The largest number of axes of a segment and of a board.
pub const MOST_AXES: usize = 14;
/// Values of a segment are at most so large, in units of 2^-24 counts: 2^32 counts. Every sum of them that a curve needs fits 64 bits.
const LARGEST: i64 = 1 << 56;

/// One of each axis, in the order of the axes.
pub type OfAxes<T> = heapless::Vec<T, MOST_AXES>;

/// A step of the motion: every axis, the same time.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Segment {
    /// In units of 2^-32 cycles: [`Time::ticks`].
    pub duration: u64,
    /// Where the axes go, and how.
    pub axes: OfAxes<AxisSegment>,
}

/// The way of one axis in a segment. Positions are in units of 2^-24 counts: [`Position::units`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct AxisSegment {
    /// The position at the end of the segment; it starts where the one before ended.
    pub end: i64,
    /// The way there.
    pub shape: Shape,
}

/// The way from one position to the next. Velocities are ways in the duration of the segment, accelerations ways from rest in that time
/// (half the acceleration times the square of the duration), in units of 2^-24 counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Shape {
    /// Constant velocity: [`Piece::line`].
    Line,
    /// With velocities at both ends: [`Piece::cubic`].
    Cubic {
        /// Velocity at the start.
        leaving: i64,
        /// Velocity at the end.
        arriving: i64,
    },
    /// With velocities and accelerations at both ends: [`Piece::quintic`].
    Quintic {
        /// Velocity at the start.
        leaving: i64,
        /// Acceleration at the start.
        leaving_acceleration: i64,
        /// Velocity at the end.
        arriving: i64,
        /// Acceleration at the end.
        arriving_acceleration: i64,
    },
    /// From rest to rest: [`Piece::minimum_jerk`].
    MinimumJerk,
}

impl Segment {
    /// The duration.
    #[must_use]
    pub const fn time(&self) -> Time {
        Time::from_ticks(self.duration)
    }
}

impl AxisSegment {
    /// The curve from a position on: the same on every machine.
    #[must_use]
    #[inline(never)]
    pub const fn piece(&self, from: Position) -> Piece {
        let to = Position::from_units(self.end);
        match self.shape {
            Shape::Line => Piece::line(from, to),
            Shape::Cubic { leaving, arriving } => Piece::cubic(
                from,
                to,
                Position::from_units(leaving),
                Position::from_units(arriving),
            ),
            Shape::Quintic {
                leaving,
                leaving_acceleration,
                arriving,
                arriving_acceleration,
            } => Piece::quintic(
                from,
                to,
                border(leaving, leaving_acceleration),
                border(arriving, arriving_acceleration),
            ),
            Shape::MinimumJerk => Piece::minimum_jerk(from, to),
        }
    }

    /// Whether every value is small enough for the sums of a curve.
    fn fits(&self, from: Position) -> bool {
        let fits = |value: i64| value.unsigned_abs() <= LARGEST.unsigned_abs();
        let way = self.end.checked_sub(from.units());
        let shape = match self.shape {
            Shape::Line | Shape::MinimumJerk => true,
            Shape::Cubic { leaving, arriving } => fits(leaving) && fits(arriving),
            Shape::Quintic {
                leaving,
                leaving_acceleration,
                arriving,
                arriving_acceleration,
            } => [
                leaving,
                leaving_acceleration,
                arriving,
                arriving_acceleration,
            ]
            .into_iter()
            .all(fits),
        };
        shape && way.is_some_and(fits)
    }
}

const fn border(velocity: i64, acceleration: i64) -> Border {
    Border {
        velocity: Position::from_units(velocity),
        acceleration: Position::from_units(acceleration),
    }
}
