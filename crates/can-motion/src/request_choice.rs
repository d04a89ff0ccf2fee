//! Which request goes out in a cycle, and where.

use core::cmp::Ordering;

use crate::family::{Family, Hears, Sends};
use crate::master::Master;
use crate::response_watch::union;
use crate::time::Instant;

/// Cycles from one choice of the place of requests to the next.
const PLACEMENT_CYCLES: u32 = 32;

/// So many cycles a poll may go before one that is due longer, to even out the length of a cycle.
const COUNTERWEIGHT_CYCLES: i32 = 14;

/// An axis, what it wants to ask, and for how many cycles that has been due.
type Wanted<F> = (u8, <F as Family>::Request, i32);

impl<const N: usize, F: Family> Master<N, F> {
    /// Chooses the place of the requests every now and then, by what is known of the drives.
    pub(crate) fn place_requests(&mut self) {
        self.placement.begin_cycle();
        if self.cycle.cycles.is_multiple_of(PLACEMENT_CYCLES) {
            let windows = self.axes.iter().map(Hears::response_window);
            let window = windows.fold(None, union);
            self.placement.choose(self.axes.len() as u8, window);
        }
    }

    /// Picks the reading to ask for next: what a state waits for, then the poll that is due longest, or soonest.
    pub(crate) fn choose_request(&mut self, now: Instant) {
        self.request = None;
        if self.requests_left == 0 || self.bus_off || now < self.quiet_until {
            return;
        }
        // Where set-points come behind the requests, a cycle without a request would move them.
        let may_be_early = self.placement.needs_requests() && self.due != 0;
        let earliest = if may_be_early { i32::MIN } else { 0 };
        let is_due = |(_, _, overdue): Wanted<F>| overdue >= earliest;
        let Some(longest) = self.best(is_due, |(_, _, overdue)| Some(overdue)) else {
            return;
        };
        let fits_better = may_be_early.then(|| self.counterweight(longest)).flatten();
        let (index, request, _) = fits_better.unwrap_or(longest);
        self.request = Some((index, request));
    }

    /// The first best of the requests that are wanted, in turn.
    fn best(
        &self,
        is_wanted: impl Fn(Wanted<F>) -> bool,
        rank: impl Fn(Wanted<F>) -> Option<i32>,
    ) -> Option<Wanted<F>> {
        let (turn, cycle) = (usize::from(self.turn), self.cycle.cycles);
        let axes = || self.axes.iter().enumerate();
        let mut best: Option<(i32, Wanted<F>)> = None;
        for (index, axis) in axes().skip(turn).chain(axes().take(turn)) {
            let Some((request, overdue)) = axis.wanted_request(cycle) else {
                continue;
            };
            let wanted = (index as u8, request, overdue);
            if let Some(rank) = rank(wanted).filter(|_| is_wanted(wanted))
                && best.is_none_or(|(highest, _)| rank > highest)
            {
                best = Some((rank, wanted));
            }
        }
        best.map(|(_, wanted)| wanted)
    }

    /// A request that is due at nearly the same time and evens out the length of the set-points: a long one beside short
    /// set-points, a short one beside long ones.
    fn counterweight(&mut self, longest: Wanted<F>) -> Option<Wanted<F>> {
        let axes = self.axes.iter().enumerate();
        let due = axes.filter(|(index, _)| self.due & 1 << index != 0);
        let set_points_bits = due.map(|(_, axis)| u32::from(axis.set_point_bits())).sum();
        let wanted = self.placement.counterweight(set_points_bits)?;
        let (_, _, overdue) = longest;
        let is_due_soon = |other: Wanted<F>| {
            overdue < i32::MAX && other.2 > overdue.saturating_sub(COUNTERWEIGHT_CYCLES)
        };
        self.best(is_due_soon, |(index, request, _)| {
            let axis = self.axes.get(usize::from(index))?;
            let bits = i32::from(axis.request_bits(request));
            Some(match wanted {
                Ordering::Less => -bits,
                Ordering::Equal | Ordering::Greater => bits,
            })
        })
    }
}
