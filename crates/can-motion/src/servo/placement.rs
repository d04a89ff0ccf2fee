//! Where in the cycle the requests go out, so that their replies do not meet set-points.
//!
//! Every request and reply of a drive outranks its set-points and those of all later drives. A request at a fixed place among the
//! set-points shifts those behind it by the same time in every cycle, which harms nobody; a reply that meets them at times and at
//! times does not is jitter. So the requests go to the place from which every reply falls between two bursts of set-points,
//! as far as the responses of the drives are known. Where there is no such place, or the plan of the bus has no room for
//! requests before set-points, they go behind all set-points.

use core::cmp::Ordering;

use bus_plan::{Burst, ResponseWindow};
use bus_user::Instant;

use crate::core::placement::RequestPlacement;
use crate::servo::plan::BusPlan;

/// Cycles from one choice of the place of requests to the next.
const PLACEMENT_CYCLES: u32 = 32;

/// So far from the mean the length of the set-points may be without a request that evens it out.
const USUAL_BITS: u32 = 1;

/// The place of requests from which their replies meet no set-point, as far as the plan has room for it; behind all set-points
/// otherwise, and until the responses of the drives are known.
#[derive(Debug, Clone, Copy)]
pub struct Aligned {
    cycle_us: u32,
    burst: Burst,
    /// The plan of the bus has room for requests anywhere.
    may_choose: bool,
    /// Set-points before the requests; `None`: all of them.
    before: Option<u8>,
    /// The axes of these set-points, one bit each.
    before_mask: u64,
    /// Mean length of the set-points of a cycle lately, in sixteenths of a bit.
    mean_sixteenths: u32,
}

impl Aligned {
    /// Requests behind all set-points, until the responses are known, or for ever when `may_choose` is false.
    pub(crate) const fn new(cycle_us: u32, burst: Burst, may_choose: bool) -> Self {
        Self {
            cycle_us,
            burst,
            may_choose,
            before: None,
            before_mask: u64::MAX,
            mean_sixteenths: 0,
        }
    }

    /// Chooses the place anew for so many set-points. A place that still fits is kept.
    pub(crate) fn choose(&mut self, set_points: u8, window: Option<ResponseWindow>) {
        let Some(window) = window.filter(|_| self.may_choose) else {
            return;
        };
        let (burst, cycle_us) = (self.burst, self.cycle_us);
        self.before = burst.place(cycle_us, set_points, window, self.before);
        let first_behind = self
            .before
            .and_then(|before| 1_u64.checked_shl(before.into()));
        self.before_mask =
            first_behind.map_or(u64::MAX, |first_behind| first_behind.wrapping_sub(1));
    }
}

impl RequestPlacement for Aligned {
    fn begin_cycle(
        &mut self,
        cycle: u32,
        axes: u8,
        window: impl FnOnce() -> Option<ResponseWindow>,
    ) {
        if cycle.is_multiple_of(PLACEMENT_CYCLES) {
            self.choose(axes, window());
        }
    }

    /// Behind what was accepted before it in this cycle.
    fn request_leaves(&self, now: Instant, cycle_started: Instant, frames: u32) -> Instant {
        let accepted_us = frames.saturating_mul(self.burst.set_point_us);
        now.max(cycle_started + accepted_us) + self.burst.request_us
    }

    fn before(&self) -> u64 {
        self.before_mask
    }

    /// Where requests come before set-points, each cycle must have its requests, or set-points would shift.
    fn needs_requests(&self) -> bool {
        self.before.is_some()
    }

    /// Beside set-points of extreme length a request whose length evens them out. Most set-points are of medium length and leave the
    /// choice to the due dates.
    fn preference(&mut self, set_points_bits: u32) -> Option<Ordering> {
        let mean_bits = self.mean_sixteenths / 16;
        // A sixteenth of the difference, as the mean is in sixteenths.
        self.mean_sixteenths = self
            .mean_sixteenths
            .saturating_add(set_points_bits)
            .saturating_sub(mean_bits);
        if set_points_bits + USUAL_BITS < mean_bits {
            Some(Ordering::Greater)
        } else if set_points_bits > mean_bits + USUAL_BITS {
            Some(Ordering::Less)
        } else {
            None
        }
    }
}

impl BusPlan<'_> {
    /// How many set-points go out before the requests of a cycle once the master has seen drives use the whole response window
    /// of its configuration; `None`: all of them.
    #[must_use]
    pub fn requests_behind(&self) -> Option<u8> {
        let may_choose = self.cycle().has_room_for_requests();
        let config = self.config();
        let mut placement = Aligned::new(config.cycle_us, self.cycle().burst(), may_choose);
        placement.choose(self.axes().len() as u8, Some(config.bus.response));
        placement.before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BURST: Burst = Burst {
        set_point_us: 67,
        request_us: 57,
        reply_us: 92,
        requests: 1,
    };

    fn around(delay_us: u32, percent: u32) -> Option<ResponseWindow> {
        let spread_us = delay_us * percent / 100;
        Some(ResponseWindow {
            min_us: delay_us - spread_us,
            max_us: delay_us + spread_us,
        })
    }

    fn place(set_points: u8, window: Option<ResponseWindow>) -> Option<u8> {
        let mut placement = Aligned::new(1_000, BURST, true);
        placement.choose(set_points, window);
        placement.before
    }

    #[test]
    fn replies_that_fit_behind_the_set_points_need_no_other_place() {
        assert_eq!(place(8, around(200, 25)), None);
        assert_eq!(place(1, around(500, 25)), None);
    }

    #[test]
    fn replies_that_would_meet_the_next_set_points_are_asked_for_earlier() {
        // Behind three set-points: 201 + 57 + 375 = 633 > 593, and 201 + 57 + 625 + 92 = 975 < 1000.
        assert_eq!(place(8, around(500, 25)), Some(3));
    }

    #[test]
    fn without_a_place_that_fits_the_requests_stay_behind() {
        assert_eq!(place(8, around(2_000, 25)), None);
        assert_eq!(place(11, around(500, 25)), None);
        assert_eq!(place(8, None), None);
        let mut placement = Aligned::new(1_000, BURST, false);
        placement.choose(8, around(500, 25));
        assert_eq!(placement.before, None);
    }

    #[test]
    fn a_place_that_still_fits_is_kept() {
        let mut placement = Aligned::new(1_000, BURST, true);
        placement.choose(8, around(500, 10));
        let before = placement.before;
        placement.choose(8, around(510, 10));
        assert_eq!(placement.before, before);
    }

    #[test]
    fn the_place_is_reached_when_the_set_points_before_it_are_through() {
        let mut placement = Aligned::new(1_000, BURST, true);
        assert_eq!(placement.before(), u64::MAX);
        placement.choose(8, around(500, 25));
        assert_eq!(placement.before(), 0b111);
    }

    #[test]
    fn a_request_leaves_behind_what_was_accepted_before_it() {
        let mut placement = Aligned::new(1_000, BURST, true);
        let start = Instant::from_us(5_000);
        placement.begin_cycle(1, 8, || None);
        assert_eq!(placement.request_leaves(start, start, 0), start + 57);
        let behind_two = placement.request_leaves(start, start, 2);
        assert_eq!(behind_two, start + 2 * 67 + 57);
        let later = placement.request_leaves(start + 400, start, 2);
        assert_eq!(later, start + 457);
    }

    #[test]
    fn a_request_evens_out_what_is_far_from_the_mean() {
        let mut placement = Aligned::new(1_000, BURST, true);
        for _ in 0..200 {
            placement.preference(524);
        }
        assert_eq!(placement.preference(525), None);
        assert_eq!(placement.preference(514), Some(Ordering::Greater));
        assert_eq!(placement.preference(534), Some(Ordering::Less));
    }
}
