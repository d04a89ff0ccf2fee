//! The jerk-limited solver.
//!
//! A change of velocity from `(v, a)` to `(v1, 0)` has a closed form. A move to rest at a target is a change to a highest velocity,
//! a cruise, and a change to rest. The way grows with the highest velocity, so that is found by bisection; a second bisection covers
//! a start that brakes already and has to brake later. See the README for the derivation.
//!
//! What is called in several places, outside the bisections, is not inlined: it saves more than 1 KiB of flash and costs few instructions.

use crate::bisection::last_not_beyond;
use crate::builder::{Builder, PlanError};
use crate::limits::{Limits, State};
use crate::quantity::Position;

/// Limits are planned with by this much smaller, which is what rounding may add: a relative 2^-18.
const MARGIN: f32 = 1.0 - 1.0 / 262_144.0;

/// The limit to plan with. A start that is exactly at its limit is inside.
pub(crate) fn inside(limit: f32, actual: f32) -> f32 {
    let planned = limit * MARGIN;
    if actual.abs() <= limit {
        planned.max(actual.abs())
    } else {
        planned
    }
}

/// Shortest time in which the full acceleration is built up, and the full velocity: 2^-12 cycles. Shorter ones would not be many
/// ticks long.
const STEEPEST: f32 = 4_096.0;

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
    let sign = if distance < motion.way_to(0.0, &bounds) {
        -1.0
    } else {
        1.0
    };
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

/// Limits to plan with.
struct Bounds {
    velocity: f32,
    acceleration: f32,
    jerk: f32,
    /// Velocity that is gained while the acceleration goes from zero to its limit and back to zero.
    knee: f32,
}

impl Bounds {
    fn new(limits: &Limits, start: &State) -> Self {
        let velocity = inside(limits.velocity(), start.velocity);
        let acceleration = inside(
            limits.acceleration().min(STEEPEST * velocity),
            start.acceleration,
        );
        let jerk = divisible_by_six((limits.jerk() * MARGIN).min(STEEPEST * acceleration));
        Self {
            velocity,
            acceleration,
            jerk,
            knee: acceleration * acceleration / jerk,
        }
    }

    /// Largest acceleration of a change that gains this much from zero acceleration to zero acceleration.
    fn peak_acceleration(&self, gain: f32) -> f32 {
        if gain >= self.knee {
            self.acceleration
        } else {
            libm::sqrtf(self.jerk * gain)
        }
    }

    /// Time at the largest acceleration in such a change.
    fn hold_cycles(&self, gain: f32) -> f32 {
        (gain / self.acceleration - self.acceleration / self.jerk).max(0.0)
    }

    /// Duration of such a change.
    fn change_cycles(&self, gain: f32) -> f32 {
        if gain >= self.knee {
            gain / self.acceleration + self.acceleration / self.jerk
        } else {
            2.0 * libm::sqrtf(gain.max(0.0) / self.jerk)
        }
    }
}

/// The nearest smaller number of which a sixth is a float too, so that a position is the exact integral of the jerk.
fn divisible_by_six(jerk: f32) -> f32 {
    let sixth = f32::from_bits((jerk / 6.0).to_bits() & !0b11);
    6.0 * sixth
}

/// Velocity and acceleration, seen in a direction: mirrored when it is backward.
#[derive(Debug, Clone, Copy)]
struct Motion {
    velocity: f32,
    acceleration: f32,
}

impl Motion {
    const fn of(start: &State) -> Self {
        Self {
            velocity: start.velocity,
            acceleration: start.acceleration,
        }
    }

    const fn steady(velocity: f32) -> Self {
        Self {
            velocity,
            acceleration: 0.0,
        }
    }

    fn times(self, sign: f32) -> Self {
        Self {
            velocity: sign * self.velocity,
            acceleration: sign * self.acceleration,
        }
    }

    /// Velocity that is gained or lost while the largest jerk brings the acceleration to zero, without its sign.
    fn release(self, bounds: &Bounds) -> f32 {
        0.5 * self.acceleration * self.acceleration / bounds.jerk
    }

    /// Velocity once the largest jerk has brought the acceleration to zero.
    fn released(self, bounds: &Bounds) -> f32 {
        self.velocity + self.release(bounds).copysign(self.acceleration)
    }

    /// The direction of the first jerk of a change to a velocity.
    fn sign_to(self, velocity: f32, bounds: &Bounds) -> f32 {
        if velocity >= self.released(bounds) {
            1.0
        } else {
            -1.0
        }
    }

    /// Way of the fastest change to a constant velocity.
    fn way_to(self, velocity: f32, bounds: &Bounds) -> f32 {
        let sign = self.sign_to(velocity, bounds);
        let base = Base::of(self.times(sign), bounds);
        let velocity = sign * velocity;
        sign * base.way_to(velocity, velocity - base.velocity, bounds)
    }

    /// The fastest change to a constant velocity.
    #[inline(never)]
    fn change_to(
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
    fn rise_to(
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

    fn push(
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

    /// Brings the acceleration inside its limit; returns what is left.
    fn acceleration_inside(
        self,
        bounds: &Bounds,
        builder: &mut Builder,
    ) -> Result<Self, PlanError> {
        let sign = 1_f32.copysign(self.acceleration);
        let Self {
            velocity: v,
            acceleration: a,
        } = self.times(sign);
        let (most, j) = (bounds.acceleration, bounds.jerk);
        if a <= most {
            return Ok(self);
        }
        self.push((a - most) / j, -sign * j, 1.0, builder)?;
        let inside = Self {
            velocity: v + 0.5 * (a - most) * (a + most) / j,
            acceleration: most,
        };
        Ok(inside.times(sign))
    }

    /// Brings acceleration and velocity inside their limits, as fast as these allow; returns what is left.
    fn back_inside(self, bounds: &Bounds, builder: &mut Builder) -> Result<Self, PlanError> {
        let motion = self.acceleration_inside(bounds, builder)?;
        for sign in [1.0, -1.0] {
            if motion.times(sign).is_too_fast(bounds) {
                let inside = motion.times(sign).brake(sign, bounds, builder)?;
                return Ok(inside.times(sign));
            }
        }
        Ok(motion)
    }

    /// Whether the velocity ahead is beyond its limit, or will be whatever the jerk.
    fn is_too_fast(self, bounds: &Bounds) -> bool {
        let released = self.released(bounds);
        if self.acceleration > 0.0 {
            released > bounds.velocity
        } else {
            // A brake so hard that the velocity backward becomes too high is the other direction's.
            self.velocity > bounds.velocity && released >= -bounds.velocity
        }
    }

    /// The beginning of a change to the limit backward, until the velocity ahead is inside.
    #[inline(never)]
    fn brake(self, sign: f32, bounds: &Bounds, builder: &mut Builder) -> Result<Self, PlanError> {
        let (v, a, j, most) = (
            self.velocity,
            self.acceleration,
            bounds.jerk,
            bounds.velocity,
        );
        let gain = v + most + self.release(bounds);
        let peak = bounds.peak_acceleration(gain).max(-a);
        let last = libm::sqrtf((a * a + 2.0 * j * (v - most)).max(0.0));
        if last <= peak {
            self.push((a + last) / j, -sign * j, sign, builder)?;
            return Ok(Self {
                velocity: most,
                acceleration: -last,
            });
        }
        self.push((a + peak) / j, -sign * j, sign, builder)?;
        let braking = Self {
            velocity: v + 0.5 * (a - peak) * (a + peak) / j,
            acceleration: -peak,
        };
        let cycles = ((braking.velocity - most) / peak)
            .max(0.0)
            .min(bounds.hold_cycles(gain));
        braking.push(cycles, 0.0, sign, builder)?;
        Ok(Self {
            velocity: braking.velocity - peak * cycles,
            acceleration: -peak,
        })
    }

    /// The fastest way to rest `distance` counts ahead, which is not nearer than where the fastest stop ends.
    fn travel(
        self,
        distance: f32,
        sign: f32,
        bounds: &Bounds,
        builder: &mut Builder,
    ) -> Result<(), PlanError> {
        let base = Base::of(self, bounds);
        let released = self.released(bounds);
        let brakes = self.acceleration < 0.0 && released > 0.0;
        if brakes && distance < base.way_over(released, 0.0, bounds) {
            return self.brake_later(distance, sign, bounds, builder);
        }
        let lowest = released.max(0.0).min(bounds.velocity);
        // Exact where a small gain needs it: zero for a start that brakes or does not accelerate.
        let least_gain = if released >= 0.0 {
            self.release(bounds) + self.release(bounds).copysign(self.acceleration)
        } else {
            -base.velocity
        };
        let way_over = |more: f32| base.way_over(lowest + more, least_gain + more, bounds);
        let most = bounds.velocity - lowest;
        let rest = distance - way_over(most);
        // The gain is searched, not the velocity: near a start that is fast already it has the more digits.
        let more = if rest >= 0.0 {
            most
        } else {
            last_not_beyond(0.0, most, |more| way_over(more) <= distance)
        };
        let peak = lowest + more;
        self.rise_to(peak, least_gain + more, sign, bounds, builder)?;
        if rest >= 0.0 {
            builder.push_cruise(rest / peak, sign * peak)?;
        }
        Self::steady(sign * peak).change_to(0.0, bounds, builder)
    }

    /// A start that brakes and is too near for more velocity: brakes less for a while, then to rest.
    fn brake_later(
        self,
        distance: f32,
        sign: f32,
        bounds: &Bounds,
        builder: &mut Builder,
    ) -> Result<(), PlanError> {
        let less = last_not_beyond(0.0, -self.acceleration, |less| {
            let (way, motion) = self.braking_less(less, bounds);
            way + motion.way_to(0.0, bounds) <= distance
        });
        self.push(less / bounds.jerk, sign * bounds.jerk, sign, builder)?;
        let (_, motion) = self.braking_less(less, bounds);
        motion.times(sign).change_to(0.0, bounds, builder)
    }

    /// Way and motion until the acceleration has changed by `less`.
    fn braking_less(self, less: f32, bounds: &Bounds) -> (f32, Self) {
        let Self {
            velocity: v,
            acceleration: a,
        } = self;
        let cycles = less / bounds.jerk;
        let way = (v + (0.5 * a + less * (1.0 / 6.0)) * cycles) * cycles;
        let motion = Self {
            velocity: v + (a + 0.5 * less) * cycles,
            acceleration: a + less,
        };
        (way, motion)
    }
}

/// Where a rise would have started, or will start, without acceleration. From there on it is symmetric: the mean velocity is the mean
/// of its ends.
struct Base {
    velocity: f32,
    /// Way to there, `-acceleration / jerk` cycles away.
    way: f32,
}

impl Base {
    fn of(motion: Motion, bounds: &Bounds) -> Self {
        let (v, a, j) = (motion.velocity, motion.acceleration, bounds.jerk);
        Self {
            velocity: v - motion.release(bounds),
            way: (a * a / (3.0 * j) - v) * (a / j),
        }
    }

    /// Way of the rise to a velocity that is `gain` higher than that of the base.
    fn way_to(&self, velocity: f32, gain: f32, bounds: &Bounds) -> f32 {
        self.way + 0.5 * (self.velocity + velocity) * bounds.change_cycles(gain)
    }

    /// The same, and then to rest.
    fn way_over(&self, velocity: f32, gain: f32, bounds: &Bounds) -> f32 {
        self.way_to(velocity, gain, bounds) + 0.5 * velocity * bounds.change_cycles(velocity)
    }
}
