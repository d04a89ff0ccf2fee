//! The curve of one axis from one set-point to the next, and what it needs.
//!
//! A curve of fifth degree goes through the set-points. Its velocity and acceleration at a set-point are those of the parabola
//! through it and its neighbours, so neither has a step: straight lines would need an infinite acceleration at every set-point, and
//! cubics an infinite jerk.

use trajectory::curve::{Border, Piece};
use trajectory::{Position, Time};

use crate::config::AxisLimits;
use crate::polynomial::{Needs, Polynomial, share_of};
use crate::refusal::Refusal;

/// Positions may have been rounded to whole counts: half a count either way. What that makes of the needs of a curve whose
/// set-points are a cycle apart; it falls with the distance, its square and its cube.
const ROUNDING: Needs = Needs {
    velocity: 1.0,
    acceleration: 5.0,
    jerk: 20.0,
};
/// The same for a second difference.
const ROUNDING_OF_DIFFERENCE: f32 = 2.0;

/// Velocity and acceleration, in counts per cycle and per cycle².
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Slope {
    pub(crate) velocity: f32,
    pub(crate) acceleration: f32,
}

/// Position of an axis at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    pub(crate) time: Time,
    pub(crate) position: Position,
}

pub(crate) fn counts(position: Position) -> f32 {
    position.units() as f32 / Position::UNITS as f32
}

/// Mean velocity from one point to the next.
pub(crate) fn chord(from: Point, to: Point) -> f32 {
    counts(to.position.distance_from(from.position)) / to.time.since(from.time).cycles()
}

/// The mean acceleration around a point, between the middles of both chords.
pub(crate) fn mean_acceleration(before: Point, here: Point, after: Point) -> f32 {
    2.0 * (chord(here, after) - chord(before, here)) / after.time.since(before.time).cycles()
}

impl Slope {
    /// Of the parabola through three points, in the middle one.
    pub(crate) fn between(before: Point, here: Point, after: Point) -> Self {
        let (first, second) = (chord(before, here), chord(here, after));
        let (left, right) = (
            here.time.since(before.time).cycles(),
            after.time.since(here.time).cycles(),
        );
        Self {
            velocity: (first * right + second * left) / (left + right),
            acceleration: mean_acceleration(before, here, after),
        }
    }
}

/// The curve from one point to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stretch {
    pub(crate) from: Point,
    pub(crate) to: Point,
    pub(crate) leaving: Slope,
    pub(crate) arriving: Slope,
}

impl Stretch {
    /// The curve, exact at both ends.
    pub(crate) fn piece(&self) -> Piece {
        let [leaving, arriving] = self.borders();
        Piece::quintic(self.from.position, self.to.position, leaving, arriving)
    }

    /// How it leaves and arrives, in units of its duration.
    pub(crate) fn borders(&self) -> [Border; 2] {
        let duration = self.to.time.since(self.from.time);
        [self.leaving, self.arriving].map(|slope| Border {
            velocity: Position::at_velocity(slope.velocity, duration),
            acceleration: Position::at_velocity(
                slope.acceleration * duration.cycles() / 2.0,
                duration,
            ),
        })
    }

    fn cycles(&self) -> f32 {
        self.to.time.since(self.from.time).cycles()
    }

    /// Coefficients of the powers 1 to 5 of the share of the duration, in counts.
    fn coefficients(&self) -> [f32; 5] {
        let h = self.cycles();
        let way = counts(self.to.position.distance_from(self.from.position));
        let (l, r) = (self.leaving.velocity * h, self.arriving.velocity * h);
        let (a, b) = (
            self.leaving.acceleration * h * h / 2.0,
            self.arriving.acceleration * h * h / 2.0,
        );
        // From the differences to the straight line, which are small where the way is long.
        let (l_off, r_off) = (l - way, r - way);
        [
            l,
            a,
            -6.0 * l_off - 4.0 * r_off - 3.0 * a + b,
            8.0 * l_off + 7.0 * r_off + 3.0 * a - 2.0 * b,
            -3.0 * l_off - 3.0 * r_off - a + b,
        ]
    }

    fn polynomial(&self) -> Polynomial {
        Polynomial::new(self.coefficients(), self.cycles())
    }

    /// The largest velocity, acceleration and jerk on the way.
    pub(crate) fn needs(&self) -> Needs {
        self.polynomial().needs()
    }

    /// The lowest and the highest position on the way.
    pub(crate) fn extent(&self) -> (Position, Position) {
        let (piece, turns) = (self.piece(), self.polynomial().turns());
        let (from, to) = (self.from.position, self.to.position);
        let ends = (from.min(to), from.max(to));
        turns.iter().fold(ends, |(lowest, highest), &turn| {
            let at = piece.at(share_of(turn));
            (lowest.min(at), highest.max(at))
        })
    }

    /// The highest rate at which this axis keeps its limits on the way: at least 1 where the set-points keep them.
    pub(crate) fn highest_rate(&self, needs: &Needs, limits: &AxisLimits) -> f32 {
        needs.highest_rate(&self.most(limits))
    }

    /// What the set-points may need, with what their rounding to whole counts makes of it.
    fn most(&self, limits: &AxisLimits) -> Needs {
        let h = self.cycles().max(1.0);
        Needs {
            velocity: limits.velocity() + ROUNDING.velocity / h,
            acceleration: limits.acceleration() + ROUNDING.acceleration / (h * h),
            jerk: limits.jerk() + ROUNDING.jerk / (h * h * h),
        }
    }

    /// Refuses what needs more than the limits of the set-points.
    pub(crate) fn check_velocity(
        &self,
        axis: usize,
        needs: &Needs,
        limits: &AxisLimits,
    ) -> Result<(), Refusal> {
        let (expected, actual) = (self.most(limits).velocity, needs.velocity);
        if actual > expected {
            return Err(Refusal::Velocity {
                axis,
                expected,
                actual,
            });
        }
        Ok(())
    }

    /// The same for acceleration and jerk.
    pub(crate) fn check_acceleration(
        &self,
        axis: usize,
        needs: &Needs,
        limits: &AxisLimits,
    ) -> Result<(), Refusal> {
        let most = self.most(limits);
        if needs.acceleration > most.acceleration {
            return Err(Refusal::Acceleration {
                axis,
                expected: most.acceleration,
                actual: needs.acceleration,
            });
        }
        if needs.jerk > most.jerk {
            return Err(Refusal::Jerk {
                axis,
                expected: most.jerk,
                actual: needs.jerk,
            });
        }
        Ok(())
    }
}

/// Refuses a mean acceleration that is more than the limit of the set-points. Returns the highest rate at which it stays within it.
pub(crate) fn check_mean_acceleration(
    axis: usize,
    [before, here, after]: [Point; 3],
    limits: &AxisLimits,
) -> Result<f32, Refusal> {
    let (left, right) = (
        here.time.since(before.time).cycles(),
        after.time.since(here.time).cycles(),
    );
    let expected = limits.acceleration() + ROUNDING_OF_DIFFERENCE / (left * right);
    let actual = mean_acceleration(before, here, after).abs();
    if actual > expected {
        return Err(Refusal::Acceleration {
            axis,
            expected,
            actual,
        });
    }
    // What needs nothing has no limit: the quotient is infinite then.
    Ok(libm::sqrtf(expected / actual))
}
