//! An axis that follows a target which moves.

use crate::builder::PlanError;
use crate::limits::{Limits, State};
use crate::profile::Profile;
use crate::quantity::{Position, Time};

/// Follows a target, cycle by cycle, within the limits.
///
/// A target that stands is reached on the fastest profile, which is planned once. A new target is planned for from where the axis is
/// then, so it may come in every cycle; one that moves with a known velocity is followed without lag.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tracker {
    limits: Limits,
    profile: Profile,
    /// Target and its velocity that the profile was planned for.
    target: Position,
    drift: f32,
    /// Since the profile was planned.
    time: Time,
}

impl Tracker {
    /// Largest velocity of a target that is followed without lag, as a share of the limit. What is left is to catch up with.
    pub const FASTEST_TARGET: f32 = 15.0 / 16.0;

    /// An axis that stands at a count.
    #[must_use]
    pub const fn at_rest(counts: i32, limits: Limits) -> Self {
        Self {
            limits,
            profile: Profile::rest(counts),
            target: Position::from_counts(counts),
            drift: 0.0,
            time: Time::ZERO,
        }
    }

    /// The axis one cycle later, on its way to a target that stands.
    ///
    /// # Errors
    /// [`PlanError`] as in [`Profile::to_rest`]; the axis is then where it was, and its target too.
    pub fn next(&mut self, target: Position) -> Result<Position, PlanError> {
        if self.drift != 0.0 || target != self.target {
            self.plan(target, 0.0)?;
        }
        Ok(self.step())
    }

    /// The axis one cycle later, on its way to a target that is here now and moves with this velocity in counts per cycle. One that is
    /// faster than [`Self::FASTEST_TARGET`] of the limit is followed like one that is not, so it gains.
    ///
    /// # Errors
    /// As [`Self::next`].
    pub fn follow(&mut self, target: Position, velocity: f32) -> Result<Position, PlanError> {
        let most = Self::FASTEST_TARGET * self.limits.velocity();
        // What is no number stays what it is, and is refused by the plan.
        let velocity = if velocity > most {
            most
        } else if velocity < -most {
            -most
        } else {
            velocity
        };
        self.plan(target, velocity)?;
        Ok(self.step())
    }

    /// Other limits from here on.
    ///
    /// # Errors
    /// As [`Self::next`]; the limits are then the old ones.
    pub fn set_limits(&mut self, limits: Limits) -> Result<(), PlanError> {
        let before = core::mem::replace(&mut self.limits, limits);
        // Where the target has moved to since it was told.
        let target = self.moved(self.target);
        let planned = self.plan(target, self.drift);
        if planned.is_err() {
            self.limits = before;
        }
        planned
    }

    /// Position, velocity and acceleration of the axis.
    #[must_use]
    pub fn state(&self) -> State {
        let state = self.profile.state(self.time);
        State {
            position: self.moved(state.position),
            velocity: state.velocity + self.drift,
            acceleration: state.acceleration,
        }
    }

    /// Whether the axis is at its target and as fast as it.
    #[must_use]
    pub const fn is_there(&self) -> bool {
        self.profile.is_done(self.time)
    }

    /// Plans in the frame of the target, with the velocity that its own one leaves of the limit.
    fn plan(&mut self, target: Position, drift: f32) -> Result<(), PlanError> {
        let state = self.state();
        let start = State {
            velocity: state.velocity - drift,
            ..state
        };
        let limits = self.limits.less_velocity(drift.abs())?;
        let profile = Profile::to_rest(&start, target, &limits)?;
        *self = Self {
            limits: self.limits,
            profile,
            target,
            drift,
            time: Time::ZERO,
        };
        Ok(())
    }

    fn step(&mut self) -> Position {
        self.time = self.time.after(Time::from_cycles(1));
        self.moved(self.profile.position(self.time))
    }

    /// From the frame of the target to the world.
    fn moved(&self, position: Position) -> Position {
        position.moved_by(Position::at_velocity(self.drift, self.time))
    }
}
