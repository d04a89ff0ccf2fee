//! Whether a wheel in position mode stands where its latest target is.

use bus_user::Instant;

use crate::wheel::drive::Wheel;
use crate::wheel::event::{Log, WheelEventKind};
use crate::wheel::way::Way;

impl Wheel {
    /// The application has set a target.
    pub(super) fn begin_way(&mut self, before: i32) {
        if self.is_position() && self.ledger.target() != before {
            self.way = Way::Waiting;
        }
    }

    /// A frame has left.
    pub(super) fn note_way(&mut self, now: Instant) {
        if self.way == Way::Waiting && self.ledger.sent() == self.ledger.target() {
            self.way = Way::Running { since: now };
        }
    }

    /// A position came in: the wheel has arrived when it stands near its target and its drive says that it has reached it.
    pub(super) fn judge_arrival(&mut self, log: &mut Log<'_>) {
        let is_under_way = matches!(self.way, Way::Running { .. } | Way::Late);
        let (Some(position), Some(status)) = (self.feedback.position_counts, self.status()) else {
            return;
        };
        let off = position.value.abs_diff(self.ledger.target());
        let is_near = off <= self.config.arrival.within_counts;
        if is_under_way && is_near && self.still_since.is_some() && status.target_reached() {
            self.way = Way::Over;
            let counts = position.value;
            log.push(WheelEventKind::Arrived { counts });
        }
    }

    /// Time passes: a wheel that has not arrived in time is said once.
    pub(super) fn watch_way(&mut self, log: &mut Log<'_>) {
        let (Way::Running { since }, Some(limit_us)) = (self.way, self.config.arrival.limit_us)
        else {
            return;
        };
        if log.now.us_since(since) >= u64::from(limit_us) {
            self.way = Way::Late;
            let position = self.feedback.position_counts.map_or(0, |read| read.value);
            let off_counts = position.wrapping_sub(self.ledger.target());
            log.push(WheelEventKind::NotArrived { off_counts });
        }
    }
}
