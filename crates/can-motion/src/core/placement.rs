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

    /// When a request that is accepted now, behind so many frames of the cycle, will have left the controller.
    fn request_leaves(&self, now: Instant, cycle_started: Instant, frames: u32) -> Instant;

    /// The axes whose frames of a cycle go out before its requests, one bit an axis: all of them by default.
    fn before(&self) -> u64 {
        u64::MAX
    }

    /// Whether each cycle should have its requests, also such that are not due yet.
    fn needs_requests(&self) -> bool {
        false
    }

    /// Whether a short or a long request fits better beside frames of this length in bits; `None` when it does not matter.
    fn preference(&mut self, frames_bits: u32) -> Option<Ordering> {
        let _ = frames_bits;
        None
    }
}

/// Requests behind all frames of the cycle.
#[derive(Debug, Clone, Copy, Default)]
pub struct BehindFrames;

impl RequestPlacement for BehindFrames {
    fn begin_cycle(&mut self, _: u32, _: u8, _: impl FnOnce() -> Option<ResponseWindow>) {}

    fn request_leaves(&self, now: Instant, _: Instant, _: u32) -> Instant {
        now
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_wait_for_the_last_frame_and_leave_at_once() {
        let (now, started) = (Instant::from_us(90), Instant::from_us(20));
        assert_eq!(BehindFrames.before(), u64::MAX);
        assert_eq!(BehindFrames.request_leaves(now, started, 3), now);
        assert!(!BehindFrames.needs_requests());
    }
}
