//! Points in time as an axis keeps them, in half the room.

use bus_user::Instant;

/// The greatest age that a [`Stamp`] shows, about 18 minutes: what is older looks that old, never younger. Waiting times are shorter.
pub(crate) const MOST_AGE_US: u32 = 1 << 30;

/// How often stamps are [kept](Stamp::keep) at least: a stamp that is that much older than [`MOST_AGE_US`] is still told from a later one.
pub(crate) const KEPT_EVERY_US: u32 = 1 << 28;

/// A point in time: the lower half of its [`Instant`].
///
/// It is compared with the present, from which it may be up to 2^31 us away. Whoever has one calls [`Self::keep`] every
/// [`KEPT_EVERY_US`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Stamp(u32);

impl Stamp {
    /// What has not happened yet.
    pub(crate) const ZERO: Self = Self(0);

    #[inline]
    pub(crate) const fn of(at: Instant) -> Self {
        Self(at.as_us() as u32)
    }

    /// Microseconds since then, 0 for a later point.
    #[inline]
    pub(crate) const fn age_us(self, now: Instant) -> u32 {
        let age = Self::of(now).0.wrapping_sub(self.0).cast_signed();
        if age < 0 { 0 } else { age as u32 }
    }

    /// Whether it was so many microseconds ago, or more; more than [`MOST_AGE_US`] count as that.
    #[inline]
    pub(crate) const fn has_lasted(self, now: Instant, us: u32) -> bool {
        let us = if us < MOST_AGE_US { us } else { MOST_AGE_US };
        Self::of(now).0.wrapping_sub(self.0).cast_signed() >= us.cast_signed()
    }

    /// Whether the point has come.
    #[inline]
    pub(crate) const fn has_come(self, now: Instant) -> bool {
        Self::of(now).0.wrapping_sub(self.0).cast_signed() >= 0
    }

    /// The point so many microseconds later.
    #[inline]
    pub(crate) const fn after(self, us: u32) -> Self {
        Self(self.0.wrapping_add(us))
    }

    /// The point so many microseconds before.
    #[inline]
    pub(crate) const fn before(self, us: u32) -> Self {
        Self(self.0.wrapping_sub(us))
    }

    /// The point in full, seen from the present or from a moment close to it.
    #[inline]
    pub(crate) const fn at(self, now: Instant) -> Instant {
        let age = Self::of(now).0.wrapping_sub(self.0).cast_signed();
        Instant::from_us(now.as_us().wrapping_sub(age as i64 as u64))
    }

    /// Lets the point look as old as [`MOST_AGE_US`] when it is older. `is_long_ago`: nobody kept it for so long that it is.
    #[inline(never)]
    pub(crate) const fn keep(&mut self, now: Instant, is_long_ago: bool) {
        if is_long_ago || self.age_us(now) > MOST_AGE_US {
            self.0 = Self::of(now).0.wrapping_sub(MOST_AGE_US);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn near_points_are_what_they_are(at in any::<u64>(), away in -(1_i64 << 31) + 1..1 << 31) {
            let Some(now) = at.checked_add_signed(away) else { return Ok(()) };
            let (at, now) = (Instant::from_us(at), Instant::from_us(now));
            let stamp = Stamp::of(at);
            prop_assert_eq!(stamp.at(now), at);
            prop_assert_eq!(u64::from(stamp.age_us(now)), now.us_since(at));
            prop_assert_eq!(stamp.has_come(now), now >= at);
            prop_assert_eq!(stamp.after(7), Stamp::of(at + 7));
            prop_assert_eq!(Stamp::of(at + 7).before(7), stamp);
        }

        /// Whatever the pauses are: a point never looks younger than it is, up to the greatest age.
        #[test]
        fn an_old_point_never_looks_young(start in 0..1_u64 << 40, pauses in proptest::collection::vec(1..1_u64 << 33, 1..40)) {
            let at = Instant::from_us(start);
            let (mut stamp, mut now) = (Stamp::of(at), at);
            for pause in pauses {
                let is_long_ago = pause >= u64::from(MOST_AGE_US);
                now = Instant::from_us(now.as_us() + pause);
                stamp.keep(now, is_long_ago);
                let age = now.us_since(at).min(u64::from(MOST_AGE_US));
                prop_assert_eq!(u64::from(stamp.age_us(now)), age);
            }
        }
    }
}
