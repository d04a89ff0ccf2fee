//! Back inside the limits.

use crate::builder::{Builder, PlanError};

use super::bounds::Bounds;
use super::motion::Motion;

impl Motion {
    /// Brings the acceleration inside its limit; returns what is left.
    pub(super) fn acceleration_inside(
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
    pub(super) fn back_inside(
        self,
        bounds: &Bounds,
        builder: &mut Builder,
    ) -> Result<Self, PlanError> {
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
    pub(super) fn is_too_fast(self, bounds: &Bounds) -> bool {
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
    pub(super) fn brake(
        self,
        sign: f32,
        bounds: &Bounds,
        builder: &mut Builder,
    ) -> Result<Self, PlanError> {
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
}
