//! The set-points of one move after the other, one a cycle.

use trajectory::{Limits, PlanError, Position, Profile, State, Time};

/// A profile and how far it is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mover {
    profile: Profile,
    time: Time,
}

impl Mover {
    pub(crate) const fn at_rest(counts: i32) -> Self {
        Self {
            profile: Profile::rest(counts),
            time: Time::ZERO,
        }
    }

    /// From the present state to rest at a count.
    pub(crate) fn go_to(&mut self, counts: i32, limits: &Limits) -> Result<(), PlanError> {
        let profile = Profile::to_rest(&self.state(), Position::from_counts(counts), limits)?;
        *self = Self {
            profile,
            time: Time::ZERO,
        };
        Ok(())
    }

    /// From the present state to rest, as soon as the limits allow.
    pub(crate) fn stop(&mut self, limits: &Limits) -> Result<(), PlanError> {
        let profile = Profile::stop(&self.state(), limits)?;
        *self = Self {
            profile,
            time: Time::ZERO,
        };
        Ok(())
    }

    /// The set-point of the next cycle.
    pub(crate) fn advance(&mut self) {
        self.time = self.time.after(Time::from_cycles(1));
    }

    pub(crate) fn set_point(&self) -> i32 {
        self.profile.position(self.time).counts()
    }

    /// Counts per cycle.
    pub(crate) fn velocity(&self) -> f32 {
        self.state().velocity
    }

    pub(crate) const fn is_at_rest(&self) -> bool {
        self.profile.is_done(self.time)
    }

    fn state(&self) -> State {
        self.profile.state(self.time)
    }
}
