//! The solver without a limit of the jerk: closed forms with one square root.

use crate::builder::{Builder, PlanError};
use crate::jerk::{VELOCITY_MARGIN, inside};
use crate::limits::{Limits, State};
use crate::quantity::Position;

/// See [`crate::Profile::to_rest`].
pub(crate) fn to_rest(
    builder: &mut Builder,
    start: &State,
    target: Position,
    limits: &Limits,
) -> Result<(), PlanError> {
    let acceleration = limits.acceleration();
    let stop = 0.5 * start.velocity * start.velocity.abs() / acceleration;
    let distance = builder.distance_to(target);
    let sign = if distance < stop { -1.0 } else { 1.0 };
    let (velocity, distance) = (sign * start.velocity, sign * distance);
    // Way to the highest velocity and from there to rest, as a velocity squared.
    let square = acceleration * distance + 0.5 * velocity * velocity;
    let highest = libm::sqrtf(square.max(0.0));
    let peak = highest.min(inside(limits.velocity(), velocity, VELOCITY_MARGIN));
    push_change(velocity, peak, sign, acceleration, builder)?;
    if peak < highest {
        let way = sign * builder.distance_to(target) - 0.5 * peak * peak / acceleration;
        builder.push_cruise(way / peak, sign * peak)?;
    }
    push_change(peak, 0.0, sign, acceleration, builder)
}

/// See [`crate::Profile::to_velocity`].
pub(crate) fn to_velocity(
    builder: &mut Builder,
    start: &State,
    velocity: f32,
    limits: &Limits,
) -> Result<(), PlanError> {
    push_change(
        start.velocity,
        velocity,
        1.0,
        limits.acceleration(),
        builder,
    )
}

/// A change from one velocity to another, both in the direction `sign`.
fn push_change(
    from: f32,
    to: f32,
    sign: f32,
    acceleration: f32,
    builder: &mut Builder,
) -> Result<(), PlanError> {
    let change = to - from;
    let acceleration = sign * acceleration.copysign(change);
    builder.push(
        change.abs() / acceleration.abs(),
        sign * from,
        acceleration,
        0.0,
    )
}
