//! Which request goes out in a cycle, and where.

use core::cmp::Ordering;

use bus_plan::ResponseWindow;
use bus_user::Instant;

use crate::core::axis::Axis;
use crate::core::calendar::{SOONEST, URGENT};
use crate::core::family::{Drive, Family};
use crate::core::group::{Axes, mask};
use crate::core::late::Late;
use crate::core::placement::RequestPlacement;

/// So many cycles a poll may go before one that is due longer, to even out the length of a cycle.
const COUNTERWEIGHT_CYCLES: i32 = 14;

/// The requests of a cycle.
#[derive(Debug)]
pub(crate) struct Schedule<F: Family> {
    pub(crate) placement: Late<F::Placement>,
    /// Requests that may still go out in this cycle.
    left: u8,
    /// The axis whose request is next. What it asks is decided anew each time when it is offered.
    pub(crate) next: Option<u8>,
    /// Where the search for the next request starts, so that equals take turns.
    turn: u8,
    /// Frames of the cycle that were accepted.
    accepted: u8,
    /// The axes whose frames may go out behind the next request, one bit each.
    behind: u64,
    quiet_until: Instant,
}

impl<F: Family> Schedule<F> {
    pub(crate) const fn new() -> Self {
        Self {
            placement: Late::Not,
            left: 0,
            next: None,
            turn: 0,
            accepted: 0,
            behind: 0,
            quiet_until: Instant::from_us(0),
        }
    }

    pub(crate) fn begin_cycle<const N: usize>(
        &mut self,
        now: Instant,
        cycle: u32,
        requests: u8,
        axes: &mut Axes<N, F>,
    ) {
        self.left = requests;
        self.accepted = 0;
        if let Some(placement) = self.placement.get_mut() {
            placement.begin_cycle(cycle, axes.len() as u8, || {
                let windows = axes.iter().map(|axis| axis.drive.response_window());
                windows.fold(None, ResponseWindow::union)
            });
        }
        self.choose(now, cycle, axes);
    }

    /// Whether it is the turn of a request, with the frames of these axes still to come.
    #[inline]
    pub(crate) const fn is_reached<const N: usize>(&self, due: u64) -> bool {
        mask::<N>(due & !self.behind) == 0
    }

    /// The frame of a cycle was accepted.
    #[inline]
    pub(crate) const fn frame_accepted(&mut self) {
        self.accepted = self.accepted.wrapping_add(1);
    }

    /// When a request that is accepted now will have left the controller.
    pub(crate) fn request_leaves(&self, now: Instant, started: Instant) -> Instant {
        self.placement.get().map_or(now, |placement| {
            placement.request_leaves(now, started, self.accepted.into())
        })
    }

    /// The request of an axis was accepted.
    pub(crate) fn accepted(&mut self, index: usize) {
        self.left = self.left.saturating_sub(1);
        self.turn = (index as u8).wrapping_add(1);
    }

    /// A request came back: it did not use its place in the budget. Without another try in this cycle the requests of the highest
    /// drive would give way for ever to those of lower ones in a controller that sorts by identifier.
    pub(crate) fn returned(&mut self) {
        self.left = self.left.saturating_add(1);
    }

    /// No requests for a while, but for what stops a motion of a drive itself.
    pub(crate) fn be_quiet(&mut self, now: Instant, us: u32) {
        self.quiet_until = now + us;
        self.set_next(None);
    }

    fn set_next(&mut self, next: Option<usize>) {
        self.next = next.map(|index| index as u8);
        let before = self.placement.get().map(RequestPlacement::before);
        self.behind = !before.filter(|_| next.is_some()).unwrap_or(u64::MAX);
    }

    /// Whether each cycle should have its requests.
    pub(crate) fn needs_requests(&self) -> bool {
        let needs = |placement: &F::Placement| placement.needs_requests();
        self.placement.get().is_some_and(needs)
    }

    /// Picks the axis whose request is due longest, or soonest.
    pub(crate) fn choose<const N: usize>(
        &mut self,
        now: Instant,
        cycle: u32,
        axes: &mut Axes<N, F>,
    ) {
        let next = if self.left == 0 {
            None
        } else if now >= self.quiet_until {
            axes.look_ahead(now, cycle);
            self.find(cycle, axes)
        } else {
            Self::find_stop(now, cycle, axes)
        };
        self.set_next(next);
    }

    /// A motion that a drive makes by itself is stopped in the quiet time too.
    #[cold]
    fn find_stop<const N: usize>(now: Instant, cycle: u32, axes: &mut Axes<N, F>) -> Option<usize> {
        if !F::MAKES_MOVES {
            return None;
        }
        axes.look_ahead(now, cycle);
        let is_one = |axis: &Axis<F>| {
            axis.view.facts.is_to_stop_itself() && axis.asks.overdue(cycle) >= URGENT
        };
        axes.iter().position(is_one)
    }

    fn find<const N: usize>(&mut self, cycle: u32, axes: &Axes<N, F>) -> Option<usize> {
        // Where frames of the cycle come behind the requests, a cycle without a request would move them.
        let may_be_early = axes.due != 0 && self.needs_requests();
        let earliest = if may_be_early { SOONEST } else { 0 };
        let overdue = |axis: &Axis<F>| axis.asks.overdue(cycle);
        let (index, longest) = self.first_best(axes.list(), earliest, overdue)?;
        if !may_be_early || longest >= URGENT {
            return Some(index);
        }
        let preference = self
            .placement
            .get_mut()
            .and_then(|placement| placement.preference(axes.due_bits));
        let Some(preference) = preference else {
            return Some(index);
        };
        let soon = longest.saturating_sub(COUNTERWEIGHT_CYCLES);
        let fits = |axis: &Axis<F>| {
            let bits = i32::from(axis.drive.poll_bits());
            match preference {
                _ if overdue(axis) <= soon => i32::MIN,
                Ordering::Less => -bits,
                Ordering::Equal | Ordering::Greater => bits,
            }
        };
        let best = self.first_best(axes.list(), -i32::from(u8::MAX), fits);
        best.map(|(index, _)| index)
    }

    /// The first of the highest rank from `least` on, in turn.
    #[inline]
    fn first_best<T>(
        &self,
        all: &[T],
        least: i32,
        rank: impl Fn(&T) -> i32,
    ) -> Option<(usize, i32)> {
        let turn = usize::from(self.turn);
        let (mut best, mut highest) = (usize::MAX, least - 1);
        for (index, one) in all.iter().enumerate() {
            let rank = rank(one);
            // Among equals the first from the turn on, or else the first of all.
            if rank > highest || (rank == highest && best < turn && turn <= index) {
                (best, highest) = (index, rank);
            }
        }
        (best != usize::MAX).then_some((best, highest))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dyn;

    #[test]
    fn among_equals_the_turn_decides_also_when_all_are_urgent() {
        let mut schedule = Schedule::<Dyn>::new();
        let best = |schedule: &Schedule<Dyn>, ranks: &[i32]| {
            schedule.first_best(ranks, SOONEST, |rank| *rank)
        };
        for rank in [0, URGENT] {
            for turn in [0, 1, 2, 0] {
                assert_eq!(
                    best(&schedule, &[rank; 3]),
                    Some((turn, rank)),
                    "turn {turn}"
                );
                schedule.accepted(turn);
            }
            schedule.turn = 0;
        }
        assert_eq!(best(&schedule, &[i32::MIN, -1, 5]), Some((2, 5)));
        assert_eq!(best(&schedule, &[i32::MIN, i32::MIN]), None);
        // A place that is no longer there.
        schedule.turn = 9;
        assert_eq!(best(&schedule, &[1, 2]), Some((1, 2)));
    }
}
