//! How fast a player goes: as ordered, as the limits allow, and slow enough to come to rest before what was admitted ends.

use trajectory::Time;

use super::cruise::Cruise;
use super::phase::StreamPhase;
use super::player::Player;
use super::queue::Tail;
use crate::rate::ONE;

impl<const AXES: usize> Player<'_, AXES> {
    pub(super) fn goal_of_orders(&self) -> i64 {
        if self.is_paused || self.is_stopping {
            return 0;
        }
        self.start
            .override_rate
            .min(self.shared.highest_rate().max(ONE))
    }

    /// The rate to go to.
    pub(super) fn goal(&mut self) -> i64 {
        let (goal, tail) = (self.goal_of_orders(), self.shared.tail());
        if self.short_of.is_some_and(|short_of| short_of != tail) {
            self.short_of = None;
        }
        if goal == 0 || self.is_ended {
            return goal;
        }
        let floor = tail.floor();
        let way = self.way_down_to(floor);
        // Whole cycles first: they are at most one more than there are, and nearly always enough.
        let whole = tail.cycles.saturating_sub((self.time.ticks() >> 32) as u32);
        if way + 1.0 >= whole as f32 && way >= self.left(tail) {
            self.short_of = Some(tail);
        }
        if self.short_of.is_some() {
            goal.min(floor)
        } else {
            goal
        }
    }

    /// [`Rate::way_down_after_a_rise_to`](crate::rate::Rate::way_down_after_a_rise_to), worked out once for a rate that does not change.
    pub(super) fn way_down_to(&mut self, floor: i64) -> f32 {
        if !self.rate.is_steady() {
            return self.rate.way_down_after_a_rise_to(floor);
        }
        let bits = self.rate.bits();
        if (self.way_down.0, self.way_down.1) != (bits, floor) {
            self.way_down = (bits, floor, self.rate.way_down_after_a_rise_to(floor));
        }
        self.way_down.2
    }

    /// Cycles of the stream that are admitted ahead.
    pub(super) fn left(&self, tail: Tail) -> f32 {
        Time::from_cycles(tail.cycles).since(self.time).cycles()
    }

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
