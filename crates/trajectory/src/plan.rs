//! The ways to make a profile. Not inlined: each is kilobytes.

use crate::builder::{Builder, PlanError};
use crate::limits::{Limits, Quantity, State, check};
use crate::profile::Profile;
use crate::quantity::Position;
use crate::{jerk, trapezoid};

impl Profile {
    /// The fastest move from any state to rest at a target.
    ///
    /// A start beyond the limits is brought back inside first, as fast as they allow; a fast start may overshoot the target and come
    /// back: check [`Self::extent`] where the travel is limited. Without a limit of the jerk the acceleration of the start counts as
    /// zero.
    ///
    /// # Errors
    /// [`PlanError`] when the start is out of range, or the move is longer than 2^30 cycles or 2^34 counts.
    #[inline(never)]
    pub fn to_rest(start: &State, target: Position, limits: &Limits) -> Result<Self, PlanError> {
        let mut builder = Builder::starting(start, limits)?;
        if limits.has_jerk() {
            jerk::to_rest(&mut builder, start, target, limits)?;
        } else {
            trapezoid::to_rest(&mut builder, start, target, limits)?;
        }
        builder.end_at(target)?;
        Ok(builder.finish())
    }

    /// The fastest change to a constant velocity, which then goes on for ever; an acceleration beyond its limit is reduced first.
    ///
    /// # Errors
    /// [`PlanError`] when the start or the velocity is out of range, or the change is longer than 2^30 cycles or 2^34 counts.
    #[inline(never)]
    pub fn to_velocity(start: &State, velocity: f32, limits: &Limits) -> Result<Self, PlanError> {
        let most = limits.velocity();
        check(Quantity::Velocity, velocity, (-most, most))?;
        let mut builder = Builder::starting(start, limits)?;
        if limits.has_jerk() {
            jerk::to_velocity(&mut builder, start, velocity, limits)?;
        } else {
            trapezoid::to_velocity(&mut builder, start, velocity, limits)?;
        }
        builder.go_on(velocity);
        Ok(builder.finish())
    }

    /// The fastest way to rest, wherever that is: [`Self::end_position`] says where, usually between two counts.
    ///
    /// # Errors
    /// As [`Self::to_velocity`].
    pub fn stop(start: &State, limits: &Limits) -> Result<Self, PlanError> {
        Self::to_velocity(start, 0.0, limits)
    }
}
