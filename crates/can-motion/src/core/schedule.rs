//! Which request goes out in a cycle, and where.

use core::cmp::Ordering;

use bus_plan::ResponseWindow;
use bus_user::Instant;

use crate::core::family::{CycleConfig, Drive, Family, Wanted};
use crate::core::group::Axes;
use crate::core::placement::RequestPlacement;

/// So many cycles a poll may go before one that is due longer, to even out the length of a cycle.
const COUNTERWEIGHT_CYCLES: i32 = 14;

/// The requests of a cycle.
#[derive(Debug)]
pub(crate) struct Schedule<F: Family> {
    pub(crate) placement: F::Placement,
    /// Requests that may still go out in this cycle.
    left: u8,
    /// The axis whose request is next. What it asks is decided anew each time when it is offered.
    pub(crate) next: Option<usize>,
    /// Where the search for the next request starts, so that equals take turns.
    turn: usize,
    quiet_until: Instant,
}

impl<F: Family> Schedule<F> {
    pub(crate) fn new(placement: F::Placement) -> Self {
        Self {
            placement,
            left: 0,
            next: None,
            turn: 0,
            quiet_until: Instant::default(),
        }
    }

    pub(crate) fn begin_cycle<const N: usize>(
        &mut self,
        now: Instant,
        cycle: u32,
        config: &F::Config,
        axes: &Axes<N, F>,
    ) {
        self.left = config.requests_per_cycle();
        self.placement.begin_cycle(cycle, axes.len() as u8, || {
            let windows = axes.iter().map(|axis| axis.drive.response_window());
            windows.fold(None, ResponseWindow::union)
        });
        self.choose(now, cycle, axes);
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
        let may_be_early = self.placement.needs_requests() && axes.due != 0;
        let earliest = if may_be_early { i32::MIN } else { 0 };
        let wanted = |index| {
            let axis = axes.get(index)?;
            axis.drive.wanted(&axis.view(), now, cycle)
        };
        let overdue = |wanted: Wanted<F::Request>| Some(wanted.overdue_cycles);
        let is_due = |due: i32| due >= earliest;
        let Some((index, due)) = self.best(axes.len(), |at| {
            overdue(wanted(at)?).filter(|due| is_due(*due))
        }) else {
            return;
        };
        let preference = match due {
            Wanted::<F::Request>::URGENT => None,
            _ if !may_be_early => None,
            _ => self.placement.preference(|| due_bits(axes)),
        };
        let balanced = preference.and_then(|preference| {
            self.best(axes.len(), |at| {
                let other = wanted(at)?;
                let is_soon = other.overdue_cycles > due.saturating_sub(COUNTERWEIGHT_CYCLES);
                let bits = axes.get(at)?.drive.request_bits(other.request);
                is_soon.then_some(match preference {
                    Ordering::Less => -i32::from(bits),
                    Ordering::Equal | Ordering::Greater => i32::from(bits),
                })
            })
        });
        self.next = Some(balanced.map_or(index, |(index, _)| index));
    }

    /// The first axis of the highest rank, in turn.
    fn best(&self, axes: usize, rank: impl Fn(usize) -> Option<i32>) -> Option<(usize, i32)> {
        let turn = self.turn.min(axes);
        let mut best: Option<(usize, i32)> = None;
        for index in (turn..axes).chain(0..turn) {
            if let Some(rank) = rank(index)
                && best.is_none_or(|(_, highest)| rank > highest)
            {
                best = Some((index, rank));
            }
        }
        best
    }
}

/// Length of the frames of this cycle that are still to come.
fn due_bits<const N: usize, F: Family>(axes: &Axes<N, F>) -> u32 {
    let due = axes
        .iter()
        .enumerate()
        .filter(|(index, _)| axes.due & 1 << index != 0);
    due.map(|(_, axis)| u32::from(axis.drive.cycle_frame_bits()))
        .sum()
}
