//! Where requests go among the frames of a cycle: a strategy, because it decides about jitter and not about safety.

use core::cmp::Ordering;
use core::fmt::Debug;

use bus_plan::ResponseWindow;
use bus_user::Instant;

/// A strategy. [`BehindFrames`] is the simplest one.
pub trait RequestPlacement: Debug {
    /// A cycle begins. `window` tells how long the drives take to answer, as far as is known.
    fn begin_cycle(
        &mut self,
        cycle: u32,
        axes: u8,
        window: impl FnOnce() -> Option<ResponseWindow>,
    );

    /// The controller accepted the frame of a cycle.
    fn frame_accepted(&mut self);

    /// When a request that is accepted now will have left the controller.
    fn request_leaves(&self, now: Instant, cycle_started: Instant) -> Instant;

    /// Whether it is the turn of the requests, with the frames of these axes (one bit an axis) still to come.
    fn is_reached(&self, due: u64) -> bool;

    /// Whether each cycle should have its requests, also such that are not due yet.
    fn needs_requests(&self) -> bool {
        false
    }

    /// Whether a short or a long request fits better beside frames of this length in bits; `None` when it does not matter.
    fn preference(&mut self, frames_bits: impl FnOnce() -> u32) -> Option<Ordering> {
        let _ = frames_bits;
        None
    }
}

/// Requests behind all frames of the cycle.
#[derive(Debug, Clone, Copy, Default)]
pub struct BehindFrames;

impl RequestPlacement for BehindFrames {
    fn begin_cycle(&mut self, _: u32, _: u8, _: impl FnOnce() -> Option<ResponseWindow>) {}

    fn frame_accepted(&mut self) {}

    fn request_leaves(&self, now: Instant, _: Instant) -> Instant {
        now
    }

    fn is_reached(&self, due: u64) -> bool {
        due == 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_wait_for_the_last_frame_and_leave_at_once() {
        let (now, started) = (Instant::from_us(90), Instant::from_us(20));
        assert_eq!(
            [0, 1, 2].map(|due| BehindFrames.is_reached(due)),
            [true, false, false]
        );
        assert_eq!(BehindFrames.request_leaves(now, started), now);
        assert!(!BehindFrames.needs_requests());
    }
}
