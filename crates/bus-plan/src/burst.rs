//! The usual time on the wire of the frames of a cycle, and what it leaves to replies.

use crate::setup::ResponseWindow;

/// Usual times on the wire, interframe space included, in microseconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Burst {
    /// A set-point, half way between its shortest and its longest frame.
    pub set_point_us: u32,
    /// The longest request.
    pub request_us: u32,
    /// The longest reply.
    pub reply_us: u32,
    /// Requests of a cycle.
    pub requests: u32,
}

impl Burst {
    /// Behind how many set-points the requests of a cycle go so that their replies meet none; `None`: behind all of them, where that does
    /// as well or where no place does. A place that still fits is kept.
    #[must_use]
    pub fn place(
        &self,
        cycle_us: u32,
        set_points: u8,
        window: ResponseWindow,
        present: Option<u8>,
    ) -> Option<u8> {
        let slack_us = |before: u8| self.slack_us(cycle_us, set_points, before, window);
        if slack_us(set_points).is_some() {
            return None;
        }
        if present.and_then(slack_us).is_some() {
            return present;
        }
        let places = (0..set_points).filter_map(|before| Some((slack_us(before)?, before)));
        places.max().map(|(_, before)| before)
    }

    /// How far replies stay away from set-points at least, when the requests of a cycle go out behind `before` of its set-points;
    /// `None` when they may meet.
    #[must_use]
    pub fn slack_us(
        &self,
        cycle_us: u32,
        set_points: u8,
        before: u8,
        window: ResponseWindow,
    ) -> Option<u32> {
        let set_points_us = |count: u8| self.set_point_us.checked_mul(u32::from(count));
        let requests_us = self.request_us.checked_mul(self.requests)?;
        let burst_us = set_points_us(set_points)?.checked_add(requests_us)?;
        let first_us = set_points_us(before)?
            .checked_add(self.request_us)?
            .checked_add(window.min_us)?;
        let last_us = set_points_us(before)?
            .checked_add(requests_us)?
            .checked_add(window.max_us)?
            .checked_add(self.reply_us.checked_mul(self.requests)?)?;
        let cycle_start_us = first_us.checked_sub(first_us.checked_rem(cycle_us)?)?;
        let behind_us = first_us.checked_sub(cycle_start_us.checked_add(burst_us)?)?;
        let ahead_us = cycle_start_us.checked_add(cycle_us)?.checked_sub(last_us)?;
        Some(behind_us.min(ahead_us))
    }
}
