//! The books of one axis: what is wanted, what was handed to the bus, and what is still owed.
//!
//! `Go_Relative_Pos_PD` is relative, so one lost or doubled frame is a permanent position error. The books hold
//! absolute counts; a step is counted when the controller has accepted its frame and taken back when the controller
//! returns that frame unsent. What one frame cannot carry stays in the backlog.

use dyn_can::{PdStep, StepLimit};

/// Target and sent position of one axis, in command counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(crate) struct SetPoint {
    target_counts: i32,
    sent_counts: i32,
    /// The step of the latest frame, which is the velocity in counts per cycle.
    last_step: i16,
}

impl SetPoint {
    /// Target and sent position agree with a position that was read back: nothing is owed, nothing moves.
    pub(crate) fn anchor(&mut self, position_counts: i32) {
        *self = Self {
            target_counts: position_counts,
            sent_counts: position_counts,
            last_step: 0,
        };
    }

    /// Forgets what is owed: the axis stays where the frames sent so far take it.
    pub(crate) fn drop_backlog(&mut self) {
        self.target_counts = self.sent_counts;
        self.last_step = 0;
    }

    pub(crate) fn set_target(&mut self, counts: i32) {
        self.target_counts = counts;
    }

    pub(crate) const fn target_counts(&self) -> i32 {
        self.target_counts
    }

    pub(crate) const fn sent_counts(&self) -> i32 {
        self.sent_counts
    }

    pub(crate) const fn backlog_counts(&self) -> i32 {
        self.target_counts.wrapping_sub(self.sent_counts)
    }

    pub(crate) const fn velocity_counts(&self) -> i16 {
        self.last_step
    }

    /// The step that the next frame carries; asking changes nothing.
    pub(crate) const fn next_step(&self, limit: StepLimit) -> PdStep {
        PdStep::toward(self.backlog_counts(), limit)
    }

    /// The controller accepted a frame with this step.
    pub(crate) fn sent(&mut self, step: PdStep) {
        self.sent_counts = self.sent_counts.wrapping_add(i32::from(step.get()));
        self.last_step = step.get();
    }

    /// The controller returned a frame with this step unsent.
    pub(crate) fn returned(&mut self, step: PdStep) {
        self.sent_counts = self.sent_counts.wrapping_sub(i32::from(step.get()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn what_one_frame_cannot_carry_is_owed() {
        let limit = StepLimit::new(100).unwrap();
        let mut books = SetPoint::default();
        books.anchor(1_000);
        books.set_target(1_250);
        books.sent(books.next_step(limit));
        assert_eq!((books.sent_counts(), books.backlog_counts()), (1_100, 150));
        books.sent(books.next_step(limit));
        books.sent(books.next_step(limit));
        assert_eq!((books.sent_counts(), books.backlog_counts()), (1_250, 0));
        assert_eq!(books.next_step(limit), PdStep::ZERO);
    }

    #[test]
    fn a_returned_frame_is_owed_again() {
        let mut books = SetPoint::default();
        books.set_target(40);
        let step = books.next_step(StepLimit::MAX);
        books.sent(step);
        books.returned(step);
        assert_eq!(books.backlog_counts(), 40);
    }

    proptest! {
        /// Whatever the targets and the fate of each frame, delivered plus owed is the target.
        #[test]
        fn delivered_plus_owed_is_the_target(
            limit in 1..=16_384_i32,
            cycles in proptest::collection::vec((-100_000..100_000_i32, 0..3_u8), 1..200),
        ) {
            let limit = StepLimit::new(limit).unwrap();
            let mut books = SetPoint::default();
            let mut delivered = 0_i32;
            for (target, fate) in cycles {
                books.set_target(target);
                let step = books.next_step(limit);
                match fate {
                    0 => {}
                    1 => { books.sent(step); books.returned(step); }
                    _ => { books.sent(step); delivered += i32::from(step.get()); }
                }
                prop_assert!(step.get().unsigned_abs() <= limit.get());
                prop_assert_eq!(books.sent_counts(), delivered);
                prop_assert_eq!(delivered + books.backlog_counts(), target);
            }
        }
    }
}
