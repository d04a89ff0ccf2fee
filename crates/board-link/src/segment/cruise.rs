//! Cycles in which nothing changes: no order, nothing new from the admission, the same rate, the same segment, enough ahead. They are nearly
//! all of a stream, and add to the time what the cycle before has added.

use trajectory::Time;

use super::phase::StreamPhase;
use super::player::Player;

/// How a player goes on while nothing changes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cruise {
    /// Changes of the admission when this was worked out.
    changes: u32,
    /// What a cycle adds to the time of the stream.
    step: Time,
    /// The start of the segment, and the time up to which this holds.
    start: Time,
    until: Time,
}

impl Cruise {
    /// Nothing is known: the next cycle is worked out anew.
    pub(super) const NONE: Self = Self {
        changes: 0,
        step: Time::ZERO,
        start: Time::ZERO,
        until: Time::ZERO,
    };
}

impl<const AXES: usize> Player<'_, AXES> {
    /// One cycle as the one before; whether it was.
    #[inline(always)]
    pub(super) fn cruise(&mut self, out: &mut [i32]) -> bool {
        let cruise = &self.cruise;
        let time = self.time.after(cruise.step);
        if time >= cruise.until || self.shared.changes() != cruise.changes {
            return false;
        }
        self.time = time;
        let elapsed = time.since(cruise.start);
        if !self.quick.write(elapsed, out) {
            self.write_doubts(elapsed, out);
        }
        self.publish_time();
        true
    }

    /// What follows a cycle that was worked out after so many changes of the admission.
    pub(super) fn next_cruise(&mut self, changes: u32) -> Cruise {
        let (rate, goal) = (self.rate.bits(), self.goal_of_orders());
        let is_steady = self.rate.is_steady() && i64::from(rate) == goal;
        if self.phase() != StreamPhase::Moving || !is_steady || self.short_of.is_some() {
            return Cruise::NONE;
        }
        let Some(head) = self.segments.peek() else {
            return Cruise::NONE;
        };
        let (start, mut until) = (head.start, head.end);
        if !self.is_ended {
            let tail = self.shared.tail();
            // A cycle more, for the fraction: that in which it begins to brake is worked out.
            let way = self.way_down_to(tail.floor()) as u32 + 1;
            until = until.min(Time::from_cycles(tail.cycles.saturating_sub(way)));
        }
        Cruise {
            changes,
            step: self.rate.advance(goal),
            start,
            until,
        }
    }
}
