//! The floor: what an axis costs in code that is written for nothing else.
//!
//! Streaming axes only, one family, no groups, no requests, no events. The books of an axis are those of the master: target, sent and due counts
//! and the latest step; when it moved, the window of positions that it passed and its largest steps, against which a read-back position is
//! judged; the number of set-points. The checks are the same as well: travel, step limit, backlog, a missed cycle.

use core::hint::black_box;

use dyn_can::{ByteOrder, DataFrame, DriveId, PdStep, StepLimit, go_relative_pos_pd};

use crate::CALLS;

/// What does not change.
struct Settings {
    drive: DriveId,
    min_counts: i32,
    max_counts: i32,
    backlog_counts: u32,
    max_step: StepLimit,
    order: ByteOrder,
}

/// What changes, the books.
#[derive(Clone, Copy)]
struct Axis {
    is_streaming: bool,
    is_due: bool,
    target_counts: i32,
    sent_counts: i32,
    due_counts: i32,
    last_step: i16,
    forward: i16,
    backward: i16,
    peak: i16,
    low_counts: i32,
    high_counts: i32,
    moved_at_us: u32,
    set_points: u32,
}

const STANDING: Axis = Axis {
    is_streaming: true,
    is_due: false,
    target_counts: 0,
    sent_counts: 0,
    due_counts: 0,
    last_step: 0,
    forward: 0,
    backward: 0,
    peak: 0,
    low_counts: 0,
    high_counts: 0,
    moved_at_us: 0,
    set_points: 0,
};

impl Axis {
    /// False when the target is refused.
    fn set_target(&mut self, settings: &Settings, counts: i32) -> bool {
        let is_taken =
            self.is_streaming && counts >= settings.min_counts && counts <= settings.max_counts;
        if is_taken {
            self.target_counts = counts;
        }
        is_taken
    }

    /// False when the axis must stop: its frame was missed, or it is too far behind.
    fn begin_cycle(&mut self) -> bool {
        let was_sent = !self.is_due;
        self.is_due = self.is_streaming;
        was_sent
    }

    /// The frame of the cycle, handed to `sink`; false when it did not go.
    fn send(
        &mut self,
        settings: &Settings,
        now_us: u32,
        sink: &mut impl FnMut(&DataFrame) -> bool,
    ) -> bool {
        let backlog = self.target_counts.wrapping_sub(self.sent_counts);
        if !self.is_due
            || backlog.unsigned_abs() > settings.backlog_counts
            || self.due_counts != self.sent_counts
        {
            return false;
        }
        let step = PdStep::toward(backlog, settings.max_step);
        if !sink(&go_relative_pos_pd(settings.drive, step, settings.order)) {
            return false;
        }
        self.book(step.get(), now_us);
        true
    }

    fn book(&mut self, step: i16, now_us: u32) {
        self.is_due = false;
        self.sent_counts = self.sent_counts.wrapping_add(i32::from(step));
        self.due_counts = self.target_counts;
        self.last_step = step;
        self.low_counts = self.low_counts.min(self.sent_counts);
        self.high_counts = self.high_counts.max(self.sent_counts);
        if step != 0 {
            self.moved_at_us = now_us;
            self.forward = self.forward.max(step);
            self.backward = self.backward.min(step);
            self.peak = self.peak.max(step.saturating_abs());
        }
        self.set_points = self.set_points.wrapping_add(1);
    }
}

/// `N` streaming axes: targets in, frames out, as [`crate::master`] does it.
pub fn axes<const N: usize>() {
    let mut drives = DriveId::all();
    let settings = [(); N].map(|()| Settings {
        drive: drives.next().unwrap_or(DriveId::MIN),
        min_counts: i32::MIN,
        max_counts: i32::MAX,
        backlog_counts: 20_000,
        max_step: StepLimit::MAX,
        order: ByteOrder::MsbFirst,
    });
    // Nothing may be known of them while compiling.
    let settings = black_box(&settings);
    let mut axes = black_box([STANDING; N]);
    let mut now_us = 0_u32;
    for call in 0..CALLS {
        for (axis, settings) in axes.iter_mut().zip(settings) {
            let _ = black_box(axis.set_target(settings, black_box(call as i32)));
        }
        now_us = now_us.wrapping_add(1_000);
        for axis in &mut axes {
            let _ = black_box(axis.begin_cycle());
        }
        for (axis, settings) in axes.iter_mut().zip(settings) {
            let sent = axis.send(settings, now_us, &mut |frame: &DataFrame| {
                black_box(frame);
                true
            });
            let _ = black_box(sent);
        }
    }
    black_box(&axes.map(|axis| (axis.set_points, axis.last_step)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_axis_sends_a_frame_a_cycle_and_keeps_its_books() {
        let settings = Settings {
            drive: DriveId::MIN,
            min_counts: -100,
            max_counts: 100,
            backlog_counts: 60,
            max_step: StepLimit::MAX,
            order: ByteOrder::MsbFirst,
        };
        let mut axis = STANDING;
        let mut frames = 0;
        for counts in [50, 20] {
            assert!(axis.set_target(&settings, counts));
            assert!(axis.begin_cycle());
            let sent = axis.send(&settings, 7, &mut |frame| {
                frames += frame.len();
                true
            });
            assert!(sent);
        }
        assert!(!axis.set_target(&settings, 101));
        assert!(axis.set_target(&settings, -100) && axis.begin_cycle());
        assert!(!axis.send(&settings, 8, &mut |_| true));
        assert!(!axis.begin_cycle());
        assert_eq!(frames, 2);
        assert_eq!(
            (axis.sent_counts, axis.low_counts, axis.high_counts),
            (20, 0, 50)
        );
        assert_eq!((axis.forward, axis.backward, axis.peak), (50, -30, 50));
        assert_eq!((axis.moved_at_us, axis.set_points), (7, 2));
    }
}
