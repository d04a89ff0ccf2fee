//! The fastest way to rest at a place.

use crate::bisection::last_not_beyond;
use crate::builder::{Builder, PlanError};

use super::SAME_PLACE;
use super::bounds::Bounds;
use super::motion::{Base, Motion};

impl Motion {
    /// The fastest way to rest `distance` counts ahead, which is not nearer than where the fastest stop ends.
    pub(super) fn travel(
        self,
        distance: f32,
        sign: f32,
        bounds: &Bounds,
        builder: &mut Builder,
    ) -> Result<(), PlanError> {
        let base = Base::of(self, bounds);
        let released = self.released(bounds);
        let brakes = self.acceleration < 0.0 && released > 0.0;
        if brakes {
            let latest = base.way_over(released, 0.0, bounds);
            if distance - latest <= SAME_PLACE * latest.abs() {
                return self.brake_later(distance, sign, bounds, builder);
            }
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
    pub(super) fn brake_later(
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
    pub(super) fn braking_less(self, less: f32, bounds: &Bounds) -> (f32, Self) {
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
