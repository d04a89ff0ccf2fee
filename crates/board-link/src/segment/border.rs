//! How an axis passes from one segment to the next, and what a step between them needs.

use trajectory::Position;

use super::{AxisSegment, Segment, Shape};
use crate::config::AxisLimits;
use crate::polynomial::Needs;
use crate::reason::Reason;
use crate::refused::Refused;

/// What the rounding of two velocities to 2^-24 counts can make of their difference, in counts per cycle.
const ROUNDING: f64 = 1.0 / (1 << 20) as f64;
/// Part of a limit that rounding may take.
const TOLERANCE: f32 = 1.0 / 65_536.0;
/// A second and a third difference take so much of a step of the acceleration: the highest value of the B-spline of degree two.
const STEP_IN_JERK: f64 = 0.75;

/// Velocity and acceleration, in counts and cycles.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Slope {
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
}

/// Where an axis is when a segment ends, and what that segment needed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Edge {
    pub(super) position: Position,
    pub(super) slope: Slope,
    pub(super) needs: Needs,
}

/// How an axis leaves and arrives in a segment.
pub(super) fn slopes(axis: &AxisSegment, from: Position, segment: &Segment) -> [Slope; 2] {
    let way = Position::from_units(axis.end).distance_from(from).units();
    let (velocities, accelerations) = match axis.shape {
        Shape::Line => ([way; 2], [0; 2]),
        Shape::MinimumJerk => ([0; 2], [0; 2]),
        // All values are at most 2^56.
        Shape::Cubic { leaving, arriving } => {
            let first = 3 * way - 2 * leaving - arriving;
            let last = leaving + 2 * arriving - 3 * way;
            ([leaving, arriving], [first, last])
        }
        Shape::Quintic {
            leaving,
            leaving_acceleration,
            arriving,
            arriving_acceleration,
        } => (
            [leaving, arriving],
            [leaving_acceleration, arriving_acceleration],
        ),
    };
    let cycles = segment.duration as f64 / (1_u64 << 32) as f64;
    let counts = |units: i64| units as f64 / Position::UNITS as f64;
    [0, 1].map(|end| {
        let of = |values: [i64; 2]| counts(if end == 0 { values[0] } else { values[1] });
        Slope {
            velocity: of(velocities) / cycles,
            acceleration: 2.0 * of(accelerations) / (cycles * cycles),
        }
    })
}

/// What both segments may need at most, the step between them included. Returns what the second one needs with the step.
///
/// A step of the velocity is seen by the drives as an acceleration in the one or two cycles around it: it is taken where the limit has
/// room for it on top of what both segments need.
pub(super) fn pass(
    axis: usize,
    before: &Edge,
    start: Slope,
    needs: Needs,
    limits: &AxisLimits,
) -> Result<Needs, Refused> {
    let velocity = (start.velocity - before.slope.velocity).abs();
    let acceleration = (start.acceleration - before.slope.acceleration).abs();
    let mut with_step = needs;
    if velocity > ROUNDING {
        let both = needs.acceleration.max(before.needs.acceleration);
        with_step.acceleration = both + velocity as f32;
        let both = needs.jerk.max(before.needs.jerk);
        with_step.jerk = both + (velocity + STEP_IN_JERK * acceleration) as f32;
        let is_allowed = with_step.acceleration <= allowed(limits.acceleration())
            && with_step.jerk <= allowed(limits.jerk());
        if !is_allowed {
            let (expected, actual) = (before.slope.velocity, start.velocity);
            return Err(Reason::VelocityStep.at(axis, units(expected), units(actual)));
        }
    } else if acceleration as f32 > TOLERANCE * limits.acceleration() {
        let both = needs.jerk.max(before.needs.jerk);
        with_step.jerk = both + (STEP_IN_JERK * acceleration) as f32;
        if with_step.jerk > allowed(limits.jerk()) {
            let (expected, actual) = (before.slope.acceleration, start.acceleration);
            return Err(Reason::AccelerationStep.at(axis, units(expected), units(actual)));
        }
    }
    Ok(with_step)
}

/// Whether an axis may stand still where a segment ends.
pub(super) fn rests(edge: &Edge, limits: &AxisLimits) -> bool {
    pass(0, edge, Slope::default(), Needs::default(), limits).is_ok()
}

/// Refuses what needs more than the limits.
pub(super) fn check_needs(axis: usize, needs: &Needs, limits: &AxisLimits) -> Result<(), Refused> {
    let checks = [
        (Reason::Velocity, needs.velocity, limits.velocity()),
        (
            Reason::Acceleration,
            needs.acceleration,
            limits.acceleration(),
        ),
        (Reason::Jerk, needs.jerk, limits.jerk()),
    ];
    for (reason, actual, most) in checks {
        // What is no number is too much.
        if actual.is_nan() || actual > allowed(most) {
            return Err(reason.at(axis, units(f64::from(most)), units(f64::from(actual))));
        }
    }
    Ok(())
}

fn allowed(limit: f32) -> f32 {
    limit * (1.0 + TOLERANCE)
}

/// In units of 2^-24; what does not fit ends at the ends of 64 bits.
pub(super) fn units(counts: f64) -> i64 {
    (counts * Position::UNITS as f64) as i64
}
