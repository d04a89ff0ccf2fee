//! Which request goes out in a cycle, and where.

use core::cmp::Ordering;

use bus_plan::ResponseWindow;
use bus_user::Instant;

use crate::core::family::{Drive, Family, Wanted};
use crate::core::group::Axes;
use crate::core::late::Late;
use crate::core::placement::RequestPlacement;

/// So many cycles a poll may go before one that is due longer, to even out the length of a cycle.
const COUNTERWEIGHT_CYCLES: i32 = 14;
/// Of an axis that asks nothing.
const NOT_WANTED: i32 = i32::MIN;

/// The requests of a cycle.
#[derive(Debug)]
pub(crate) struct Schedule<F: Family> {
    pub(crate) placement: Late<F::Placement>,
    /// Requests that may still go out in this cycle.
    left: u8,
    /// The axis whose request is next. What it asks is decided anew each time when it is offered.
    pub(crate) next: Option<usize>,
    /// Where the search for the next request starts, so that equals take turns.
    turn: usize,
    quiet_until: Instant,
}

impl<F: Family> Schedule<F> {
    pub(crate) const fn new() -> Self {
        Self {
            placement: Late::Not,
            left: 0,
            next: None,
            turn: 0,
            quiet_until: Instant::from_us(0),
        }
    }

    pub(crate) fn begin_cycle<const N: usize>(
        &mut self,
        now: Instant,
        cycle: u32,
        requests: u8,
        axes: &Axes<N, F>,
    ) {
        self.left = requests;
        if let Some(placement) = self.placement.get_mut() {
            placement.begin_cycle(cycle, axes.len() as u8, || {
                let windows = axes.iter().map(|axis| axis.drive.response_window());
                windows.fold(None, ResponseWindow::union)
            });
        }
        self.choose(now, cycle, axes);
    }

    /// Whether it is the turn of the requests, with the frames of these axes still to come.
    #[inline]
    pub(crate) fn is_reached(&self, due: u64) -> bool {
        let is_reached = |placement: &F::Placement| placement.is_reached(due);
        self.placement.get().is_some_and(is_reached)
    }

    /// The frame of a cycle was accepted.
    #[inline]
    pub(crate) fn frame_accepted(&mut self) {
        if let Some(placement) = self.placement.get_mut() {
            placement.frame_accepted();
        }
    }

    /// When a request that is accepted now will have left the controller.
    pub(crate) fn request_leaves(&self, now: Instant, started: Instant) -> Instant {
        self.placement
            .get()
            .map_or(now, |placement| placement.request_leaves(now, started))
    }

    /// The request of an axis was accepted.
    pub(crate) fn accepted(&mut self, index: usize) {
        self.left = self.left.saturating_sub(1);
        self.turn = index.wrapping_add(1);
    }

    /// A request came back: it did not use its place in the budget. Without another try in this cycle the requests of the highest
    /// drive would give way for ever to those of lower ones in a controller that sorts by identifier.
    pub(crate) fn returned(&mut self) {
        self.left = self.left.saturating_add(1);
    }

    /// No requests for a while.
    pub(crate) fn be_quiet(&mut self, now: Instant, us: u32) {
        self.quiet_until = now + us;
        self.next = None;
    }

    /// Picks the axis whose request is due longest, or soonest.
    pub(crate) fn choose<const N: usize>(&mut self, now: Instant, cycle: u32, axes: &Axes<N, F>) {
        self.next = None;
        if self.left == 0 || now < self.quiet_until {
            return;
        }
        // Where frames of the cycle come behind the requests, a cycle without a request would move them.
        let needs_requests = |placement: &F::Placement| placement.needs_requests();
        let may_be_early = axes.due != 0 && self.placement.get().is_some_and(needs_requests);
        let earliest = if may_be_early { NOT_WANTED + 1 } else { 0 };
        let mut overdue = [NOT_WANTED; N];
        for (axis, overdue) in axes.iter().zip(&mut overdue) {
            if let Some(cycles) = axis.drive.overdue(&axis.view, now, cycle) {
                *overdue = cycles;
            }
        }
        let Some((index, longest)) = self.first_best(&overdue, axes.len(), earliest) else {
            return;
        };
        self.next = Some(index);
        if !may_be_early || longest == Wanted::<F::Request>::URGENT {
            return;
        }
        let Some(placement) = self.placement.get_mut() else {
            return;
        };
        let Some(preference) = placement.preference(|| due_bits(axes)) else {
            return;
        };
        let soon = longest.saturating_sub(COUNTERWEIGHT_CYCLES);
        for (axis, rank) in axes.iter().zip(&mut overdue) {
            let bits = i32::from(axis.drive.poll_bits());
            *rank = match preference {
                _ if *rank <= soon => NOT_WANTED,
                Ordering::Less => -bits,
                Ordering::Equal | Ordering::Greater => bits,
            };
        }
        self.next = self
            .first_best(&overdue, axes.len(), NOT_WANTED)
            .map(|(index, _)| index);
    }

    /// The first axis of the highest rank from `least` on, in turn.
    fn first_best(&self, ranks: &[i32], axes: usize, least: i32) -> Option<(usize, i32)> {
        let mut index = if self.turn < axes { self.turn } else { 0 };
        let mut best: Option<(usize, i32)> = None;
        for _ in 0..axes {
            if let Some(&rank) = ranks.get(index)
                && best.map_or(rank >= least, |(_, highest)| rank > highest)
            {
                best = Some((index, rank));
            }
            index = if index + 1 < axes { index + 1 } else { 0 };
        }
        best
    }
}

/// About the length of the frames of this cycle that are still to come.
fn due_bits<const N: usize, F: Family>(axes: &Axes<N, F>) -> u32 {
    let (mut bits, mut due) = (0, axes.due);
    for axis in axes.iter() {
        if due & 1 != 0 {
            bits += u32::from(axis.drive.cycle_frame_bits());
        }
        due >>= 1;
    }
    bits
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dyn;

    #[test]
    fn among_equals_the_turn_decides_also_when_all_are_urgent() {
        let mut schedule = Schedule::<Dyn>::new();
        for rank in [0, i32::MAX] {
            for turn in [0, 1, 2, 0] {
                assert_eq!(
                    schedule.first_best(&[rank; 3], 3, 0),
                    Some((turn, rank)),
                    "turn {turn}"
                );
                schedule.accepted(turn);
            }
            schedule.turn = 0;
        }
        assert_eq!(
            schedule.first_best(&[NOT_WANTED, -1, 5], 3, 0),
            Some((2, 5))
        );
        assert_eq!(schedule.first_best(&[NOT_WANTED, -1], 2, 0), None);
    }
}
