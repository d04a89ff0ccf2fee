//! Velocity and acceleration, and the fastest change to a constant velocity.

use crate::builder::{Builder, PlanError};
use crate::limits::State;

use super::bounds::Bounds;

/// Velocity and acceleration, seen in a direction: mirrored when it is backward.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motion {
    pub(super) velocity: f32,
    pub(super) acceleration: f32,
}

impl Motion {
    pub(super) const fn of(start: &State) -> Self {
        Self {
            velocity: start.velocity,
            acceleration: start.acceleration,
        }
    }

    pub(super) const fn steady(velocity: f32) -> Self {
        Self {
            velocity,
            acceleration: 0.0,
        }
    }

    pub(super) fn times(self, sign: f32) -> Self {
        Self {
            velocity: sign * self.velocity,
            acceleration: sign * self.acceleration,
        }
    }

    /// Velocity that is gained or lost while the largest jerk brings the acceleration to zero, without its sign.
    pub(super) fn release(self, bounds: &Bounds) -> f32 {
        0.5 * self.acceleration * self.acceleration / bounds.jerk
    }

    /// Velocity once the largest jerk has brought the acceleration to zero.
    pub(super) fn released(self, bounds: &Bounds) -> f32 {
        self.velocity + self.release(bounds).copysign(self.acceleration)
    }

    /// The direction of the first jerk of a change to a velocity.
    pub(super) fn sign_to(self, velocity: f32, bounds: &Bounds) -> f32 {
        if velocity >= self.released(bounds) {
            1.0
        } else {
            -1.0
        }
    }

    /// Way of the fastest change to a constant velocity.
    pub(super) fn way_to(self, velocity: f32, bounds: &Bounds) -> f32 {
        let sign = self.sign_to(velocity, bounds);
        let base = Base::of(self.times(sign), bounds);
        let velocity = sign * velocity;
        sign * base.way_to(velocity, velocity - base.velocity, bounds)
    }

    /// The fastest change to a constant velocity.
    #[inline(never)]
    pub(super) fn change_to(
        self,
        velocity: f32,
        bounds: &Bounds,
        builder: &mut Builder,
    ) -> Result<(), PlanError> {
        let sign = self.sign_to(velocity, bounds);
        let (motion, velocity) = (self.times(sign), sign * velocity);
        let gain = velocity - Base::of(motion, bounds).velocity;
        motion.rise_to(velocity, gain, sign, bounds, builder)
    }

    /// The same where the first jerk is positive in the direction `sign`; `gain` is the velocity that is gained from [`Base`] on.
    pub(super) fn rise_to(
        self,
        velocity: f32,
        gain: f32,
        sign: f32,
        bounds: &Bounds,
        builder: &mut Builder,
    ) -> Result<(), PlanError> {
        let j = bounds.jerk;
        let peak = bounds.peak_acceleration(gain).max(self.acceleration);
        let raised = Self {
            velocity: self.velocity
                + 0.5 * (peak - self.acceleration) * (peak + self.acceleration) / j,
            acceleration: peak,
        };
        let lowered = Self {
            velocity: velocity - 0.5 * peak * peak / j,
            acceleration: peak,
        };
        self.push((peak - self.acceleration) / j, sign * j, sign, builder)?;
        raised.push(bounds.hold_cycles(gain), 0.0, sign, builder)?;
        lowered.push(peak / j, -sign * j, sign, builder)
    }

    pub(super) fn push(
        self,
        cycles: f32,
        jerk: f32,
        sign: f32,
        builder: &mut Builder,
    ) -> Result<(), PlanError> {
        let Self {
            velocity,
            acceleration,
        } = self.times(sign);
        builder.push(cycles, velocity, acceleration, jerk)
    }
}

/// Where a rise would have started, or will start, without acceleration. From there on it is symmetric: the mean velocity is the mean
/// of its ends.
pub(super) struct Base {
    pub(super) velocity: f32,
    /// Way to there, `-acceleration / jerk` cycles away.
    pub(super) way: f32,
}

impl Base {
    pub(super) fn of(motion: Motion, bounds: &Bounds) -> Self {
        let (v, a, j) = (motion.velocity, motion.acceleration, bounds.jerk);
        Self {
            velocity: v - motion.release(bounds),
            way: (a * a / (3.0 * j) - v) * (a / j),
        }
    }

    /// Way of the rise to a velocity that is `gain` higher than that of the base.
    pub(super) fn way_to(&self, velocity: f32, gain: f32, bounds: &Bounds) -> f32 {
        self.way + 0.5 * (self.velocity + velocity) * bounds.change_cycles(gain)
    }

    /// The same, and then to rest.
    pub(super) fn way_over(&self, velocity: f32, gain: f32, bounds: &Bounds) -> f32 {
        self.way_to(velocity, gain, bounds) + 0.5 * velocity * bounds.change_cycles(velocity)
    }
}
