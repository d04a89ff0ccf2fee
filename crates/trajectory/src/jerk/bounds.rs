//! The limits that the solver plans with, and what they make of a symmetric change of velocity.
//!
//! Each is smaller than what it is given by what rounding may add to it, and not by more: near the fastest stop a limit that is smaller
//! by a share `e` costs up to `1.8 e^(1/3)` of the duration for the jerk, and `1.9 e^(1/2)` for the acceleration.

use crate::limits::{Limits, State};

/// What is spread of a remainder changes the velocity by up to 2^-19, see [`super::SAME_PLACE`].
pub(crate) const VELOCITY_MARGIN: f32 = 1.0 - 1.0 / 262_144.0;

/// The time to build up twice the acceleration is rounded to a float, 2^-22, and to a tick, 2^-21 with [`STEEPEST`].
const ACCELERATION_MARGIN: f32 = 1.0 - 1.0 / 1_048_576.0;

/// The limit to plan with. A start that is exactly at its limit is inside.
pub(crate) fn inside(limit: f32, actual: f32, margin: f32) -> f32 {
    let planned = limit * margin;
    if actual.abs() <= limit {
        planned.max(actual.abs())
    } else {
        planned
    }
}

/// Shortest time in which the full acceleration is built up, and the full velocity: 2^-12 cycles. Shorter ones would not be many
/// ticks long.
const STEEPEST: f32 = 4_096.0;

/// Limits to plan with.
pub(super) struct Bounds {
    pub(super) velocity: f32,
    pub(super) acceleration: f32,
    pub(super) jerk: f32,
    /// Velocity that is gained while the acceleration goes from zero to its limit and back to zero.
    pub(super) knee: f32,
}

impl Bounds {
    pub(super) fn new(limits: &Limits, start: &State) -> Self {
        let velocity = inside(limits.velocity(), start.velocity, VELOCITY_MARGIN);
        // A start that has to be caught is faster than the limit for a while.
        let release = 0.5 * start.acceleration * start.acceleration / limits.jerk();
        let fastest = velocity.max(start.velocity.abs() + release);
        let acceleration = inside(
            limits.acceleration().min(STEEPEST * fastest),
            start.acceleration,
            ACCELERATION_MARGIN,
        );
        // Without a margin: it is a constant of each segment, which nothing is added to.
        let jerk = divisible_by_six(limits.jerk().min(STEEPEST * acceleration));
        Self {
            velocity,
            acceleration,
            jerk,
            knee: acceleration * acceleration / jerk,
        }
    }

    /// Largest acceleration of a change that gains this much from zero acceleration to zero acceleration.
    pub(super) fn peak_acceleration(&self, gain: f32) -> f32 {
        if gain >= self.knee {
            self.acceleration
        } else {
            libm::sqrtf(self.jerk * gain)
        }
    }

    /// Time at the largest acceleration in such a change.
    pub(super) fn hold_cycles(&self, gain: f32) -> f32 {
        (gain / self.acceleration - self.acceleration / self.jerk).max(0.0)
    }

    /// Duration of such a change.
    pub(super) fn change_cycles(&self, gain: f32) -> f32 {
        if gain >= self.knee {
            gain / self.acceleration + self.acceleration / self.jerk
        } else {
            2.0 * libm::sqrtf(gain.max(0.0) / self.jerk)
        }
    }
}

/// The nearest number, not larger and at most 2^-21 smaller, of which a sixth is a float too, so that a position is the exact integral of
/// the jerk.
fn divisible_by_six(jerk: f32) -> f32 {
    let sixth = f32::from_bits((jerk / 6.0).to_bits() & !0b11);
    6.0 * sixth
}
