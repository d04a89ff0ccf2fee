//! When the request of an axis is due: worked out when something happens to the axis, and read in every cycle.

use bus_user::Instant;

use crate::core::family::Outlook;

/// Ranks of what is not a poll: the number of cycles for which a poll has been due is far from both.
pub(crate) const URGENT: i32 = 1 << 30;
/// The rank of the poll that is furthest from its date.
pub(crate) const SOONEST: i32 = -URGENT;

/// Microseconds of a tick, as a power of two.
const TICK_BITS: u32 = 12;
/// The longest time for which a date is believed: ticks of 16 bits are compared with the present.
const LONGEST_US: u32 = 1 << 26;

/// When the request of an axis is due. Packed, because there is one for each axis.
#[derive(Debug, Clone, Copy)]
#[repr(Rust, packed(2))]
pub(crate) struct Due {
    /// The cycle.
    cycle: u32,
    /// The tick at which it is worked out anew at the latest.
    until: Tick,
}

/// A point in time in ticks of about 4 ms, up to two minutes from the present.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Tick(u16);

impl Tick {
    pub(crate) const fn of(now: Instant) -> Self {
        Self((now.as_us() as u32 >> TICK_BITS) as u16)
    }

    /// Whether it is now, or was before.
    #[inline]
    pub(crate) const fn has_come(self, now: Self) -> bool {
        now.0.wrapping_sub(self.0).cast_signed() >= 0
    }

    pub(crate) const fn earlier(self, other: Self) -> Self {
        if self.has_come(other) { self } else { other }
    }
}

impl Due {
    /// Nothing was worked out yet.
    pub(crate) const NEW: Self = Self {
        cycle: 0,
        until: Tick(0),
    };

    pub(crate) fn new(outlook: Outlook, now: Instant, cycle: u32) -> Self {
        let rank = match outlook.overdue_cycles {
            Some(i32::MAX) => URGENT,
            // What has waited longer than any machine runs is as late as can be.
            Some(cycles) => cycles.clamp(SOONEST, URGENT / 2),
            None => 2 * SOONEST,
        };
        Self {
            cycle: cycle.wrapping_sub(rank.cast_unsigned()),
            until: Tick::of(now + outlook.for_us.min(LONGEST_US)),
        }
    }

    /// For how many cycles the request has been due: below [`SOONEST`] when there is none, from [`URGENT`] on when it goes before every
    /// poll.
    #[inline]
    pub(crate) const fn overdue(&self, cycle: u32) -> i32 {
        cycle.wrapping_sub(self.cycle).cast_signed()
    }

    pub(crate) const fn until(&self) -> Tick {
        self.until
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cycle_adds_one() {
        let due = |overdue| Due::new(Outlook::now(overdue), Instant::default(), u32::MAX - 2);
        let after_five = |overdue| due(overdue).overdue(2);
        assert_eq!(after_five(Some(-7)), -2);
        assert_eq!(after_five(Some(3)), 8);
        assert_eq!(after_five(Some(i32::MAX)), URGENT + 5);
        assert!(after_five(None) < SOONEST);
        // However late a poll is, it is none that goes before all others.
        assert!((0..URGENT).contains(&after_five(Some(i32::MAX - 1))));
        assert!(after_five(Some(i32::MIN + 1)) >= SOONEST);
    }

    #[test]
    fn a_tick_comes_and_stays_passed_for_two_minutes() {
        let at = |us| Tick::of(Instant::from_us(us));
        for start in [0, 0x0FFF_F000, 0xFFFF_FFFF_FFFF] {
            let tick = at(start + 10_000);
            assert!(!tick.has_come(at(start)));
            assert!(tick.has_come(at(start + 10_000)));
            assert!(tick.has_come(at(start + 120_000_000)));
            assert!(at(start).earlier(tick).has_come(at(start)));
            assert!(tick.earlier(at(start)).has_come(at(start)));
        }
    }
}
