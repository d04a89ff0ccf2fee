//! The jerk-limited solver.
//!
//! A change of velocity from `(v, a)` to `(v1, 0)` has a closed form ([`motion`]). A move to rest at a target is a change to a highest
//! velocity, a cruise, and a change to rest. The way grows with the highest velocity, so that is found by bisection; a second bisection
//! covers a start that brakes already and has to brake later ([`travel`]). A start beyond the limits is brought back inside first
//! ([`brake`]). See the README for the derivation.
//!
//! What is called in several places, outside the bisections, is not inlined: it saves more than 1 KiB of flash and costs few
//! instructions.

mod bounds;
mod brake;
mod motion;
mod travel;

use crate::builder::{Builder, PlanError};
use crate::limits::{Limits, State};
use crate::quantity::Position;

use bounds::Bounds;
pub(crate) use bounds::{VELOCITY_MARGIN, inside};
use motion::Motion;

/// A target that is no further than this share of the way from where the fastest stop ends is where it ends: the planned jerk and the
/// rounding of the way move that place by about as much. What is left over is spread. A move that turns back for it would take up to
/// 1.03 times the optimum.
const SAME_PLACE: f32 = 1.0 / 524_288.0;

/// See [`crate::Profile::to_rest`].
pub(crate) fn to_rest(
    builder: &mut Builder,
    start: &State,
    target: Position,
    limits: &Limits,
) -> Result<(), PlanError> {
    let bounds = Bounds::new(limits, start);
    let motion = Motion::of(start).back_inside(&bounds, builder)?;
    let distance = builder.distance_to(target);
    let stop = motion.way_to(0.0, &bounds);
    if (distance - stop).abs() <= SAME_PLACE * stop.abs() {
        return motion.change_to(0.0, &bounds, builder);
    }
    let sign = if distance < stop { -1.0 } else { 1.0 };
    motion
        .times(sign)
        .travel(sign * distance, sign, &bounds, builder)
}

/// See [`crate::Profile::to_velocity`].
pub(crate) fn to_velocity(
    builder: &mut Builder,
    start: &State,
    velocity: f32,
    limits: &Limits,
) -> Result<(), PlanError> {
    let bounds = Bounds::new(limits, start);
    let motion = Motion::of(start).acceleration_inside(&bounds, builder)?;
    motion.change_to(velocity, &bounds, builder)
}
