//! How an axis passes from one segment to the next, and what a step between them needs.

use trajectory::Position;

use super::{AxisSegment, Segment, Shape};
use crate::config::AxisLimits;
use crate::polynomial::Needs;
use crate::reason::Reason;
use crate::refused::Refused;

/// Velocities and accelerations here are whole numbers of 2^-40 counts: 64 bits of an integer say more than those of a float, and a
/// processor without floats of 64 bits needs no arithmetic for them (4 KB).
const PLACES: u32 = 40;
/// So many places more than those of a position.
const MORE_PLACES: u32 = PLACES - Position::UNITS.trailing_zeros();
/// What the rounding of two velocities to 2^-24 counts can make of their difference.
const ROUNDING: u64 = 1 << (PLACES - 20);
/// Part of a limit that rounding may take.
const TOLERANCE: f32 = 1.0 / 65_536.0;

/// Velocity and acceleration, in 2^-40 counts and cycles.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Slope {
    pub(super) velocity: i64,
    acceleration: i64,
}

/// Where an axis is when a segment ends, and what that segment needed.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Edge {
    pub(super) position: Position,
    pub(super) slope: Slope,
    pub(super) needs: Needs,
    /// The latest steps, the newest first.
    pub(super) steps: [Step; 3],
}

/// A step between two segments.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Step {
    /// Of the velocity, which an acceleration of one cycle sees.
    velocity: f32,
    /// What a jerk over two cycles sees of the steps of velocity and acceleration.
    in_jerk: f32,
    /// Cycles from there to the end of the latest segment.
    pub(super) ago: f32,
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
    [0, 1].map(|end| {
        let of = |values: [i64; 2]| if end == 0 { values[0] } else { values[1] };
        let per_cycle = |way: i64, places| per_cycle(way, segment.duration, places);
        Slope {
            velocity: per_cycle(of(velocities), MORE_PLACES),
            acceleration: per_cycle(per_cycle(2 * of(accelerations), MORE_PLACES), 0),
        }
    })
}

/// A change in a cycle, of one in a duration in units of 2^-32 cycles; with so many binary places more, cut off there. What needs more
/// than 63 bits is far beyond every limit, and ends there.
fn per_cycle(change: i64, duration: u64, places: u32) -> i64 {
    let divisor = duration.max(1);
    let (mut quotient, mut rest) = (
        change.unsigned_abs() / divisor,
        change.unsigned_abs() % divisor,
    );
    let mut left = 32 + places;
    while left > 0 {
        // As many places as fit, two or three times.
        let step = rest.leading_zeros().clamp(1, left);
        let shifted = rest << step;
        let is_too_much = quotient.leading_zeros() <= step;
        quotient = if is_too_much {
            i64::MAX as u64
        } else {
            (quotient << step) | (shifted / divisor)
        };
        (rest, left) = (shifted % divisor, left - step);
    }
    quotient as i64 * change.signum()
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
) -> Result<(Needs, Step), Refused> {
    let velocity = start.velocity.abs_diff(before.slope.velocity);
    let acceleration = start.acceleration.abs_diff(before.slope.acceleration);
    // A second and a third difference take so much of a step of the acceleration: the highest value of the B-spline of degree two.
    let in_jerk = 0.75 * counts(acceleration);
    let step = Step {
        velocity: counts(velocity),
        in_jerk: counts(velocity) + in_jerk,
        ago: 0.0,
    };
    // Differences over one, two cycles see the steps just before as well.
    let recent = |within: f32| before.steps.iter().filter(move |step| step.ago < within);
    let before_velocity: f32 = recent(1.0).map(|step| step.velocity).sum();
    let before_in_jerk: f32 = recent(2.0).map(|step| step.in_jerk).sum();
    let mut with_step = needs;
    if velocity > ROUNDING {
        let both = needs.acceleration.max(before.needs.acceleration);
        with_step.acceleration = both + step.velocity + before_velocity;
        let both = needs.jerk.max(before.needs.jerk);
        with_step.jerk = both + step.in_jerk + before_in_jerk;
        let is_allowed = with_step.acceleration <= allowed(limits.acceleration())
            && with_step.jerk <= allowed(limits.jerk());
        if !is_allowed {
            let (expected, actual) = (before.slope.velocity, start.velocity);
            return Err(Reason::VelocityStep.at(axis, units(expected), units(actual)));
        }
    } else if counts(acceleration) > TOLERANCE * limits.acceleration() {
        let both = needs.jerk.max(before.needs.jerk);
        with_step.jerk = both + in_jerk + before_in_jerk;
        if with_step.jerk > allowed(limits.jerk()) {
            let (expected, actual) = (before.slope.acceleration, start.acceleration);
            return Err(Reason::AccelerationStep.at(axis, units(expected), units(actual)));
        }
    }
    Ok((with_step, step))
}

/// Whether an axis may stand still where a segment ends.
#[inline(never)]
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
            return Err(reason.at(axis, nearest_units(most), nearest_units(actual)));
        }
    }
    Ok(())
}

fn allowed(limit: f32) -> f32 {
    limit * (1.0 + TOLERANCE)
}

fn counts(slope: u64) -> f32 {
    slope as f32 / (1_u64 << PLACES) as f32
}

/// Of a velocity or an acceleration, in units of 2^-24.
pub(super) const fn units(slope: i64) -> i64 {
    slope / (1 << MORE_PLACES)
}

/// Counts in units of 2^-24; what does not fit ends at the ends of 64 bits.
pub(super) fn nearest_units(counts: f32) -> i64 {
    (counts * Position::UNITS as f32) as i64
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        /// With every size of both, and what does not fit.
        #[test]
        fn a_change_in_a_cycle_is_the_exact_quotient(
            change in (any::<i64>(), 0_u32..63).prop_map(|(change, down)| change >> down),
            duration in (1_u64.., 0_u32..63).prop_map(|(ticks, down)| (ticks >> 1 >> down).max(1)),
            places in 0_u32..20,
        ) {
            let exact = i128::from(change).checked_mul(1_i128 << (32 + places)).unwrap() / i128::from(duration);
            let most = i128::from(i64::MAX);
            let expected = exact.clamp(-most, most);
            prop_assert_eq!(i128::from(per_cycle(change, duration, places)), expected);
        }
    }
}
