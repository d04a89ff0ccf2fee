//! Which request goes out in a cycle, and where.

use crate::core::family::{CycleConfig, Drive, Family};
use crate::core::group::Axes;
use crate::core::placement::RequestPlacement;
use crate::core::time::Instant;
use crate::plan::union;

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
            windows.fold(None, union)
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
        let mut longest = if may_be_early { i32::MIN } else { -1 };
        let turn = self.turn.min(axes.len());
        for index in (turn..axes.len()).chain(0..turn) {
            if let Some(axis) = axes.get(index)
                && let Some(overdue_cycles) = axis.drive.overdue(&axis.view, now, cycle)
                && overdue_cycles > longest
            {
                (self.next, longest) = (Some(index), overdue_cycles);
            }
        }
    }
}
