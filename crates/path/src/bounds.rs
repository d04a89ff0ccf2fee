//! How fast a piece of a path may be passed, from the limits of the axes.
//!
//! With `q(s)` an axis along the path and `v`, `a`, `j` the derivatives of `s` by time, the axis has the velocity `q' v`, the acceleration
//! `q' a + q'' v²` and the jerk `q' j + 3 q'' v a + q''' v³`. A piece is known by upper bounds of `q'`, `q''` and `q'''` of each axis.

use trajectory::Limits;

use crate::length;
use crate::machine::Machine;
use crate::order::Order as _;
use crate::roots::{cube_root_below, hypotenuse, square_root};
use crate::shape::{Direction, Kind, Shape};

/// Shares of the limits that a velocity may need by itself; the rest is left for its changes.
const ACCELERATION_SHARE: f32 = 0.6;
const ROUND_ACCELERATION_SHARE: f32 = 0.8;
const JERK_SHARE: f32 = 0.5;

/// Planned with this much less: what rounding and the steps of whole cycles may add.
const MARGIN: f32 = 1.0 - 1.0 / 128.0;

/// Upper bounds of the derivatives of an axis along a piece, in counts per unit, unit² and unit³.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Slopes {
    first: f32,
    second: f32,
    third: f32,
    /// Whether the first and the second derivative are never large at the same place, as on a circle.
    is_round: bool,
}

/// The highest velocity along a piece of which the axes have these slopes, at most `fastest`, in units per cycle.
pub(crate) fn velocity<const A: usize>(
    slopes: &[Slopes; A],
    limits: &[Limits; A],
    fastest: f32,
) -> f32 {
    let mut velocity = fastest;
    for (slopes, limits) in slopes.iter().zip(limits) {
        velocity = velocity.lower(slopes.velocity(limits));
    }
    velocity
}

/// The acceleration along a piece that the axes allow up to a velocity, in units per cycle². The acceleration along the path changes by
/// up to twice its largest value in `filter` cycles.
pub(crate) fn acceleration<const A: usize>(
    slopes: &[Slopes; A],
    limits: &[Limits; A],
    velocity: f32,
    filter: f32,
) -> f32 {
    let mut acceleration = f32::MAX;
    for (slopes, limits) in slopes.iter().zip(limits) {
        acceleration = acceleration.lower(slopes.acceleration(limits, velocity, filter));
    }
    acceleration
}

/// Velocity and acceleration that the axes allow at least along a piece that is bent by at most so many radians per unit.
pub(crate) fn least<const S: usize, const A: usize>(
    machine: &impl Machine<S, A>,
    limits: &[Limits; A],
    bend: f32,
    filter: f32,
) -> (f32, f32) {
    let mut squares = [0.0; A];
    for place in 0..S {
        let mut vector = [0.0; S];
        if let Some(part) = vector.get_mut(place) {
            *part = 1.0;
        }
        for (square, rate) in squares.iter_mut().zip(machine.rates(&vector)) {
            *square += rate * rate;
        }
    }
    let slopes = squares.map(|square| {
        let first = square_root(square);
        Slopes {
            first,
            second: first * bend,
            third: first * bend * bend,
            is_round: false,
        }
    });
    let velocity = velocity(&slopes, limits, length::FASTEST);
    (velocity, acceleration(&slopes, limits, velocity, filter))
}

impl Slopes {
    pub(crate) const NONE: Self = Self {
        first: 0.0,
        second: 0.0,
        third: 0.0,
        is_round: false,
    };

    fn velocity(&self, limits: &Limits) -> f32 {
        let share = if self.is_round {
            ROUND_ACCELERATION_SHARE
        } else {
            ACCELERATION_SHARE
        };
        let mut most = MARGIN * limits.velocity() / self.first;
        if self.second > 0.0 {
            most = most.lower(square_root(share * limits.acceleration() / self.second));
        }
        if self.third > 0.0 && limits.jerk().is_finite() {
            most = most.lower(cube_root_below(JERK_SHARE * limits.jerk() / self.third));
        }
        most
    }

    fn acceleration(&self, limits: &Limits, velocity: f32, filter: f32) -> f32 {
        let (a, j) = (MARGIN * limits.acceleration(), MARGIN * limits.jerk());
        let across = self.second * velocity * velocity;
        let along = if self.is_round {
            square_root((a - across) * (a + across))
        } else {
            a - across
        };
        let most = along / self.first;
        if !j.is_finite() {
            return most;
        }
        let needed = self.third * velocity * velocity * velocity;
        let per_acceleration = 2.0 * self.first / filter + 3.0 * self.second * velocity;
        most.lower((j - needed) / per_acceleration)
    }
}

/// Of a line or an arc that starts in a direction.
pub(crate) fn slopes<const S: usize, const A: usize>(
    shape: &Shape<S>,
    start: &Direction<S>,
    machine: &impl Machine<S, A>,
) -> [Slopes; A] {
    let mut slopes = [Slopes::NONE; A];
    match &shape.kind {
        Kind::Line { .. } => {
            for (slopes, rate) in slopes.iter_mut().zip(machine.rates(&start.tangent)) {
                slopes.first = rate.abs();
            }
        }
        Kind::Arc { plane, rate, .. } => of_arc(&mut slopes, start, *plane, *rate, machine),
        // Has its own function.
        Kind::Blend { .. } => {}
    }
    slopes
}

fn of_arc<const S: usize, const A: usize>(
    slopes: &mut [Slopes; A],
    start: &Direction<S>,
    plane: (usize, usize),
    rate: f32,
    machine: &impl Machine<S, A>,
) {
    let (mut radial, mut ahead, mut steady) = ([0.0; S], [0.0; S], start.tangent);
    let curvature = |place: usize| start.curvature.get(place).copied().unwrap_or(0.0);
    // Of the tangent, what turns, and what remains.
    let turning = [curvature(plane.1) / rate, -curvature(plane.0) / rate];
    for (place, ahead_of, radial_of) in [
        (plane.0, turning[0], curvature(plane.0)),
        (plane.1, turning[1], curvature(plane.1)),
    ] {
        if let Some(ahead) = ahead.get_mut(place) {
            *ahead = ahead_of;
        }
        if let Some(radial) = radial.get_mut(place) {
            *radial = radial_of / rate;
        }
        if let Some(steady) = steady.get_mut(place) {
            *steady -= ahead_of;
        }
    }
    let parts = machine
        .rates(&radial)
        .into_iter()
        .zip(machine.rates(&ahead))
        .zip(machine.rates(&steady));
    for (slopes, ((radial, ahead), steady)) in slopes.iter_mut().zip(parts) {
        let round = hypotenuse(radial, ahead);
        *slopes = Slopes {
            first: round + steady.abs(),
            second: round * rate.abs(),
            third: round * rate * rate,
            is_round: steady.abs() <= 0.001 * round,
        };
    }
}

/// The rates of the axes of each power of a blend, and 1 / length; rates are linear.
fn powers<const S: usize, const A: usize>(
    shape: &Shape<S>,
    machine: &impl Machine<S, A>,
) -> ([[f32; 5]; A], f32) {
    let mut powers = [[0.0; 5]; A];
    let Kind::Blend {
        coefficients,
        inverse,
        ..
    } = &shape.kind
    else {
        return (powers, 0.0);
    };
    for power in 0..5 {
        let mut vector = [0.0; S];
        for (part, coefficients) in vector.iter_mut().zip(coefficients) {
            *part = coefficients.get(power).copied().unwrap_or(0.0);
        }
        for (powers, rate) in powers.iter_mut().zip(machine.rates(&vector)) {
            if let Some(slot) = powers.get_mut(power) {
                *slot = rate;
            }
        }
    }
    (powers, *inverse)
}

/// The first derivatives of a blend: a polynomial lies within the hull of its Bernstein coefficients.
pub(crate) fn put_slopes_of_blend<const S: usize, const A: usize>(
    slopes: &mut [Slopes; A],
    shape: &Shape<S>,
    machine: &impl Machine<S, A>,
) {
    let (powers, inverse) = powers(shape, machine);
    for (slopes, [c, d, e, f, g]) in slopes.iter_mut().zip(powers) {
        slopes.is_round = false;
        slopes.first = inverse
            * largest([
                c,
                c + 0.5 * d,
                c + d + 0.5 * e,
                c + 1.5 * (d + e) + f,
                c + 2.0 * d + 3.0 * e + 4.0 * f + 5.0 * g,
            ]);
    }
}

/// The same of the second and the third ones.
pub(crate) fn put_bends_of_blend<const S: usize, const A: usize>(
    slopes: &mut [Slopes; A],
    shape: &Shape<S>,
    machine: &impl Machine<S, A>,
) {
    let (powers, inverse) = powers(shape, machine);
    let square = inverse * inverse;
    for (slopes, [_, d, e, f, g]) in slopes.iter_mut().zip(powers) {
        slopes.second = square
            * largest([
                2.0 * d,
                2.0 * (d + e),
                2.0 * d + 4.0 * (e + f),
                2.0 * d + 6.0 * e + 12.0 * f + 20.0 * g,
            ]);
        slopes.third = square
            * inverse
            * largest([6.0 * e, 6.0 * e + 12.0 * f, 6.0 * e + 24.0 * f + 60.0 * g]);
    }
}

fn largest<const N: usize>(values: [f32; N]) -> f32 {
    let larger = |most: f32, value: f32| {
        let size = value.abs();
        if size > most { size } else { most }
    };
    values.into_iter().fold(0.0, larger)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The parts of the jerk of an axis, each at its largest: together they use the limit up and do not exceed it.
    #[test]
    fn the_parts_of_the_jerk_add_up_to_its_limit() {
        // No acceleration is too large for these.
        let limits = Limits::new(1e4, 1e4, 0.04).unwrap();
        let filter = 100.0;
        for (first, second, third) in [
            (1.0, 0.0, 0.0),
            (1.0, 0.01, 0.0),
            (3.0, 0.002, 0.0),
            (1.0, 0.01, 1e-8),
            (0.2, 0.05, 1e-9),
        ] {
            for is_round in [false, true] {
                let slopes = Slopes {
                    first,
                    second,
                    third,
                    is_round,
                };
                for velocity in [1.0_f32, 10.0, 100.0] {
                    let a = slopes.acceleration(&limits, velocity, filter);
                    // The acceleration goes from one limit to the other while it is averaged.
                    let along = first * 2.0 * a / filter;
                    let turning = 3.0 * second * velocity * a;
                    let across = third * velocity.powi(3);
                    let share = (along + turning + across) / 0.04;
                    assert!(
                        (0.98..=1.0).contains(&share),
                        "{slopes:?} {velocity}: {share}"
                    );
                }
            }
        }
    }
}
