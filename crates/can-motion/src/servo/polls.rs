//! Which value of which axis is read next: due dates in cycles.

use crate::servo::config::PollPeriods;
use crate::servo::poll_kind::PollKind;

/// This part of a period may be caught up when a poll was late, so that its mean period stays.
const KEPT_PART: u32 = 4;

const KINDS: usize = PollKind::ALL.len();

/// Cycles of a period, 1..=65535; `None` for one that has fewer or more.
pub(super) fn cycles_of(period_us: u32, cycle_us: u32) -> Option<u16> {
    let cycles = u16::try_from(period_us.checked_div(cycle_us)?).ok()?;
    (cycles != 0).then_some(cycles)
}

/// Due dates of one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PollClock {
    /// Cycle in which the next request of each kind is due.
    next: [u32; KINDS],
    /// Cycles from one request of each kind to the next, 0 for a poll that is off.
    period: [u16; KINDS],
    /// The one that is due longest, or soonest: it stays that while time passes.
    first: Option<PollKind>,
}

/// A poll whose time has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct DuePoll {
    pub(crate) kind: PollKind,
    /// Cycles since it was due; below 0 it is not due yet.
    pub(crate) overdue: i32,
}

/// Cycles since a date; below 0 it is still to come.
#[inline]
const fn overdue(next: u32, period: u32, cycle: u32) -> i32 {
    let since = cycle.wrapping_sub(next).cast_signed();
    // A date is never more than a period ahead: what looks so was passed longer ago than the count of cycles reaches.
    if since < 0 && since.unsigned_abs() > period {
        i32::MAX - 1
    } else {
        since
    }
}

impl PollClock {
    /// First due dates are spread by `rank`, so that axes do not ask all at once.
    pub(crate) fn new(periods: &PollPeriods, cycle_us: u32, rank: u32) -> Self {
        let period = PollKind::ALL.map(|kind| {
            let period = periods.of(kind).and_then(|us| cycles_of(us, cycle_us));
            period.unwrap_or(0)
        });
        let mut place = rank * KINDS as u32;
        let next = period.map(|period| {
            let spread = place.checked_rem(period.into()).unwrap_or(0);
            place += 1;
            spread
        });
        let mut clock = Self {
            next,
            period,
            first: None,
        };
        clock.find_first(0);
        clock
    }

    /// The kind of poll that is due longest, or soonest.
    pub(crate) const fn first(&self) -> Option<PollKind> {
        self.first
    }

    /// The poll that is due longest, or soonest when none is due.
    #[inline]
    pub(crate) fn most_overdue(&self, cycle: u32) -> Option<DuePoll> {
        let kind = self.first?;
        Some(DuePoll {
            kind,
            overdue: self.overdue(kind, cycle),
        })
    }

    /// Cycles since the date of a poll; below 0 it is still to come.
    #[inline]
    fn overdue(&self, kind: PollKind, cycle: u32) -> i32 {
        let [next, period] = self.of(kind);
        overdue(next, period, cycle)
    }

    /// When it is due, and its period.
    #[inline]
    fn of(&self, kind: PollKind) -> [u32; 2] {
        let place = kind as usize;
        match (self.next.get(place), self.period.get(place)) {
            (Some(&next), Some(&period)) => [next, period.into()],
            _ => [0; 2],
        }
    }

    fn find_first(&mut self, cycle: u32) {
        let (mut first, mut longest) = (None, i32::MIN);
        for kind in PollKind::ALL {
            let [next, period] = self.of(kind);
            if period != 0 {
                let overdue = overdue(next, period, cycle);
                if overdue > longest {
                    (first, longest) = (Some(kind), overdue);
                }
            }
        }
        self.first = first;
    }

    /// A request went out: the next one is due a period later, less what this one was late, up to a part of the period. More is
    /// forgotten: on a full bus every poll would owe it, and one that begins anew would wait behind all others for it.
    pub(crate) fn asked(&mut self, kind: PollKind, cycle: u32) {
        let [_, period] = self.of(kind);
        let late = self.overdue(kind, cycle).max(0).unsigned_abs();
        let kept = late.min(period / KEPT_PART);
        self.set(kind, cycle.wrapping_add(period - kept));
        self.find_first(cycle);
    }

    /// The request came back unsent: it is due at once.
    pub(crate) fn returned(&mut self, kind: PollKind, cycle: u32) {
        self.set(kind, cycle);
        self.find_first(cycle);
    }

    fn set(&mut self, kind: PollKind, cycle: u32) {
        if let Some(next) = self.next.get_mut(kind as usize) {
            *next = cycle;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    fn clock() -> PollClock {
        PollClock::new(&PollPeriods::DEFAULT, 1_000, 0)
    }

    #[test]
    fn polls_that_are_off_are_never_due() {
        let clock = PollClock::new(&PollPeriods::OFF, 1_000, 3);
        assert_eq!(clock.most_overdue(1_000_000), None);
    }

    #[test]
    fn each_kind_comes_once_a_period() {
        let mut clock = clock();
        let mut asked = [0; 2];
        for cycle in 0..200 {
            if let Some(poll) = clock.most_overdue(cycle).filter(|poll| poll.overdue >= 0) {
                asked[poll.kind as usize] += 1;
                clock.asked(poll.kind, cycle);
            }
        }
        assert_eq!(asked, [10, 10]);
    }

    #[test]
    fn the_longest_overdue_goes_first_even_when_the_cycle_count_wraps() {
        let mut clock = clock();
        let start = u32::MAX - 5;
        clock.returned(PollKind::Status, start.wrapping_add(3));
        clock.returned(PollKind::Position, start);
        let first = clock.most_overdue(start.wrapping_add(10)).unwrap();
        assert_eq!((first.kind, first.overdue), (PollKind::Position, 10));
        clock.asked(PollKind::Position, start.wrapping_add(10));
        let second = clock.most_overdue(start.wrapping_add(10)).unwrap();
        assert_eq!((second.kind, second.overdue), (PollKind::Status, 7));
    }

    #[test]
    fn a_poll_that_was_not_asked_for_very_long_is_due() {
        for cycles in [1_000, 1 << 31, (1 << 31) + 1, u32::MAX - 100] {
            let overdue = clock().most_overdue(cycles).unwrap().overdue;
            assert!(overdue > 0, "{cycles}: {overdue}");
        }
    }

    #[test]
    fn a_late_poll_does_not_come_twice_to_catch_up() {
        let mut clock = clock();
        clock.asked(PollKind::Status, 500);
        let next = clock.most_overdue(519).unwrap();
        assert_ne!(next.kind, PollKind::Status);
    }

    /// 12 drives with two polls each ask for 24 requests in 20 cycles; now and then another request takes the turn of a poll.
    #[test]
    fn on_a_full_bus_polls_take_turns() {
        let mut clocks: Vec<_> = (0..12)
            .map(|rank| PollClock::new(&PollPeriods::DEFAULT, 1_000, rank))
            .collect();
        let mut asked = [[0_u32; 2]; 12];
        let mut oldest = 0;
        for cycle in (0..20_000).filter(|cycle| cycle % 87 != 0) {
            let polls = clocks.iter().enumerate();
            let (axis, poll) = polls
                .filter_map(|(axis, clock)| Some((axis, clock.most_overdue(cycle)?)))
                .max_by_key(|(_, poll)| poll.overdue)
                .unwrap();
            clocks[axis].asked(poll.kind, cycle);
            let last = core::mem::replace(&mut asked[axis][poll.kind as usize], cycle);
            oldest = oldest.max(cycle - last);
        }
        assert!(oldest <= 26, "{oldest} cycles");
    }

    #[test]
    fn an_early_poll_does_not_put_the_next_one_off() {
        let mut clock = clock();
        for cycle in (0..1_000).step_by(5) {
            let soonest = clock.most_overdue(cycle).unwrap();
            assert!((-20..5).contains(&soonest.overdue));
            clock.asked(soonest.kind, cycle);
        }
    }
}
