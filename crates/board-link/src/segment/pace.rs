//! How fast a player goes: as ordered, as the limits allow, and slow enough to come to rest before what was admitted ends.

use trajectory::Time;

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
}
