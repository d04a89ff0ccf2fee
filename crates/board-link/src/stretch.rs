//! The curve of one axis from one set-point to the next, and what it needs.
//!
//! A curve of fifth degree goes through the set-points. Its velocity and acceleration at a set-point are those of the parabola
//! through it and its neighbours, so neither has a step: straight lines would need an infinite acceleration at every set-point, and
//! cubics an infinite jerk.

use trajectory::curve::{Border, Piece};
use trajectory::{Position, Time};

use crate::config::AxisLimits;
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
/// Places at which the velocity is looked at; between them it is bounded by the jerk.
const PLACES: u8 = 16;

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

/// The largest velocity, acceleration and jerk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Needs {
    pub(crate) velocity: f32,
    pub(crate) acceleration: f32,
    pub(crate) jerk: f32,
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
        let duration = self.to.time.since(self.from.time);
        let border = |slope: Slope| Border {
            velocity: Position::at_velocity(slope.velocity, duration),
            acceleration: Position::at_velocity(
                slope.acceleration * duration.cycles() / 2.0,
                duration,
            ),
        };
        Piece::quintic(
            self.from.position,
            self.to.position,
            border(self.leaving),
            border(self.arriving),
        )
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

    /// The largest velocity, acceleration and jerk on the way, or a little more.
    pub(crate) fn needs(&self) -> Needs {
        let h = self.cycles();
        let [c1, c2, c3, c4, c5] = self.coefficients();
        let jerk_at = |u: f32| (6.0 * c3 + (24.0 * c4 + 60.0 * c5 * u) * u) / (h * h * h);
        let acceleration_at =
            |u: f32| (2.0 * c2 + (6.0 * c3 + (12.0 * c4 + 20.0 * c5 * u) * u) * u) / (h * h);
        let velocity_at =
            |u: f32| (c1 + (2.0 * c2 + (3.0 * c3 + (4.0 * c4 + 5.0 * c5 * u) * u) * u) * u) / h;
        let jerk = largest(jerk_at, [-c4 / (5.0 * c5), 0.0]);
        let acceleration = largest(acceleration_at, turns(c3, c4, c5));
        let step = h / f32::from(PLACES);
        let velocity = places().map(velocity_at).fold(0.0, larger) + jerk * step * step / 8.0;
        Needs {
            velocity,
            acceleration,
            jerk,
        }
    }

    /// The lowest and the highest position on the way.
    pub(crate) fn extent(&self) -> (Position, Position) {
        let [c1, c2, c3, c4, c5] = self.coefficients();
        let at = |u: f32| (c1 + (c2 + (c3 + (c4 + c5 * u) * u) * u) * u) * u;
        let velocity =
            |u: f32| c1 + (2.0 * c2 + (3.0 * c3 + (4.0 * c4 + 5.0 * c5 * u) * u) * u) * u;
        let way = counts(self.to.position.distance_from(self.from.position));
        let (mut lowest, mut highest) = (way.min(0.0), way.max(0.0));
        for (from, to) in places().zip(places().skip(1)) {
            if velocity(from) * velocity(to) < 0.0 {
                let place = at(turn_between(&velocity, from, to));
                (lowest, highest) = (lowest.min(place), highest.max(place));
            }
        }
        let moved = |by: f32| {
            let units = Position::at_velocity(by, Time::from_cycles(1));
            self.from.position.moved_by(units)
        };
        (moved(lowest), moved(highest))
    }

    /// The highest rate at which this axis keeps its limits on the way: at least 1 where the set-points keep them.
    pub(crate) fn highest_rate(&self, needs: &Needs, limits: &AxisLimits) -> f32 {
        let most = self.most(limits);
        let by_velocity = most.velocity / needs.velocity;
        let by_acceleration = libm::sqrtf(most.acceleration / needs.acceleration);
        let by_jerk = libm::cbrtf(most.jerk / needs.jerk);
        // What needs nothing has no limit: the quotient is infinite or no number, which `min` passes over.
        by_velocity.min(by_acceleration).min(by_jerk).min(2.0)
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

/// Refuses a mean acceleration that is more than the limit of the set-points.
pub(crate) fn check_mean_acceleration(
    axis: usize,
    [before, here, after]: [Point; 3],
    limits: &AxisLimits,
) -> Result<(), Refusal> {
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
    Ok(())
}

fn places() -> impl Iterator<Item = f32> {
    (0..=PLACES).map(|place| f32::from(place) / f32::from(PLACES))
}

/// Where the velocity is zero between two places at which it has different signs.
fn turn_between(velocity: &impl Fn(f32) -> f32, mut from: f32, mut to: f32) -> f32 {
    let sign = velocity(from);
    // More halves make no difference to a number of 24 bits.
    for _ in 0..20 {
        let middle = (from + to) / 2.0;
        if velocity(middle) * sign > 0.0 {
            from = middle;
        } else {
            to = middle;
        }
    }
    from
}

/// Where the jerk is zero: the roots of `c3 + 4 c4 u + 10 c5 u²`, the one that does not cancel first, the other one from their product.
fn turns(c3: f32, c4: f32, c5: f32) -> [f32; 2] {
    let root = libm::sqrtf((4.0 * c4 * c4 - 10.0 * c3 * c5).max(0.0));
    let sum = -2.0 * c4 + if c4 > 0.0 { -root } else { root };
    [sum / (10.0 * c5), c3 / sum]
}

/// The larger size; what is no number is larger than everything.
fn larger(most: f32, value: f32) -> f32 {
    if value.abs() <= most {
        most
    } else {
        value.abs()
    }
}

/// The largest size at both ends and at the places between them.
fn largest(of: impl Fn(f32) -> f32, inner: [f32; 2]) -> f32 {
    let inner = inner.into_iter().filter(|&u| u > 0.0 && u < 1.0);
    [0.0, 1.0]
        .into_iter()
        .chain(inner)
        .map(of)
        .fold(0.0, larger)
}
