//! Is the drive where the set-points should have taken it?
//!
//! A drive lags behind its set-points while it moves (following error) and catches up when they stop. A set-point that the wire lost or
//! doubled leaves an error that stays. So a position is compared three times: while moving against the generous limit of the following
//! error, with the reading before for a jump, and at standstill against the tight tolerance of drift. Nothing is ever corrected: the
//! axis faults, and the application decides.

use bus_user::Instant;

use crate::core::stamp::Stamp;
use crate::servo::config::Limits;
use crate::servo::fault::{DriftCause, Fault};

/// Cycles of its fastest step by which the lag of a drive may change from one reading to the next: a drive that needs 64 ms at 1 kHz to
/// follow is slower than any that was tried.
const LAG_CYCLES: u32 = 64;

/// What was sent lately, to compare a position with the time in which it was read.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct DriftWatch {
    /// Smallest and largest sent position since a position was asked for.
    window: (i32, i32),
    /// Error of the reading before, in command counts.
    error_before: i32,
    moved_at: Stamp,
    /// Largest steps forward and backward lately: they go into the others when these are needed.
    lately: [i16; 2],
    /// Largest step in either direction before the reading before, which fades from one reading to the next, and since. A lag counts
    /// as the step from which it comes.
    peak: [i16; 2],
    /// Largest steps forward and backward since the position was last confirmed at standstill.
    moved: [i16; 2],
    /// A position was asked for: the window counts.
    is_asked: bool,
    /// There was a reading before.
    has_error: bool,
}

impl DriftWatch {
    /// The position is known to be `counts`.
    pub(crate) fn anchor(&mut self, now: Instant) {
        *self = Self {
            moved_at: Stamp::of(now),
            ..Self::default()
        };
    }

    /// A position is asked for, when the set-points have taken the axis to `sent_counts`, the latest of them from `before`. The drive may
    /// look at its shaft at any moment from now on until its reply comes; the latest set-point may still be on its way.
    pub(crate) fn asked(&mut self, sent_counts: i32, before: i32) {
        self.window = (sent_counts.min(before), sent_counts.max(before));
        self.is_asked = true;
    }

    /// The set-points have taken the axis here.
    #[inline]
    pub(crate) fn widen(&mut self, sent_counts: i32) {
        let (low, high) = self.window;
        self.window = (sent_counts.min(low), sent_counts.max(high));
    }

    /// A set-point went out.
    #[inline(always)]
    pub(crate) fn stepped(&mut self, step_counts: i16, sent_counts: i32, now: Instant) {
        if step_counts != 0 {
            if self.is_asked {
                self.widen(sent_counts);
            }
            self.moved_at = Stamp::of(now);
            let [forward, backward] = &mut self.lately;
            if step_counts > 0 {
                *forward = step_counts.max(*forward);
            } else {
                *backward = step_counts.min(*backward);
            }
        }
    }

    /// What happened lately, where it is needed.
    fn note_lately(&mut self) {
        let [forward, backward] = core::mem::take(&mut self.lately);
        let [most_forward, most_backward] = self.moved;
        self.moved = [forward.max(most_forward), backward.min(most_backward)];
        let [_, latest] = &mut self.peak;
        *latest = forward.max(backward.saturating_abs()).max(*latest);
    }

    /// Judges a position that came in reply to the latest request.
    pub(crate) fn judge(
        &mut self,
        position_counts: i32,
        now: Instant,
        limits: &Limits,
        arrival_us: u32,
    ) -> Option<Fault> {
        if !core::mem::take(&mut self.is_asked) {
            return None;
        }
        self.note_lately();
        let (low, high) = self.window;
        // One of the two is 0. No travel reaches where this saturates.
        let (below, above) = (
            position_counts.saturating_sub(low).min(0),
            position_counts.saturating_sub(high).max(0),
        );
        let counts = below.saturating_add(above);
        if counts.unsigned_abs() > limits.following_error_counts {
            return Some(Fault::FollowingError { counts });
        }
        if let Some(fault) = self.jump(counts, high.wrapping_sub(low).cast_unsigned(), limits) {
            return Some(fault);
        }
        if !self.moved_at.has_lasted(now, arrival_us) {
            return None;
        }
        if counts.unsigned_abs() > limits.drift_tolerance_counts {
            return Some(Fault::Drift {
                counts,
                cause: self.cause(counts, limits.drift_tolerance_counts),
            });
        }
        self.moved = [0; 2];
        None
    }

    /// Whether the error grew by more than a drive can lag. An error that gets smaller is a drive that catches up, and one that swings to
    /// the other side gets there by no more than it was off before.
    fn jump(&mut self, error: i32, window: u32, limits: &Limits) -> Option<Fault> {
        let before = core::mem::replace(&mut self.error_before, error);
        let off_before = before.unsigned_abs();
        let lag = self
            .lag_lately(off_before)
            .max(off_before.saturating_mul(2));
        if !core::mem::replace(&mut self.has_error, true) {
            return None;
        }
        let counts = error.saturating_sub(before);
        if error.signum() != -before.signum() && error.unsigned_abs() <= off_before {
            return None;
        }
        let allowed = window
            .saturating_add(lag)
            .saturating_add(limits.drift_tolerance_counts);
        (counts.unsigned_abs() > allowed).then_some(Fault::PositionJump { counts })
    }

    /// How far a drive may lag after the steps before the latest reading, when it lagged by so many counts before. A quarter of what was
    /// earlier is forgotten with every reading: a drive that was slow to follow a fast motion swings for longer than from one to the next.
    fn lag_lately(&mut self, before: u32) -> u32 {
        let [earlier, latest] = self.peak;
        // It is not negative, and becomes 0.
        let faded = earlier - earlier / 4 - i16::from(earlier > 0);
        let lagged = i16::try_from(before / LAG_CYCLES).unwrap_or(i16::MAX);
        self.peak = [latest.max(faded).max(lagged), 0];
        LAG_CYCLES * u32::from(earlier.max(latest).unsigned_abs())
    }

    /// As [`Stamp::keep`].
    pub(crate) const fn keep_stamps(&mut self, now: Instant, is_long_ago: bool) {
        self.moved_at.keep(now, is_long_ago);
    }

    /// Whether one of the steps sent since the last good position explains the error.
    fn cause(&self, counts: i32, tolerance: u32) -> DriftCause {
        let magnitude = counts.unsigned_abs();
        let reaches = |step: i16| {
            step != 0 && magnitude <= tolerance.saturating_add(step.unsigned_abs().into())
        };
        let [forward, backward] = self.moved.map(reaches);
        let (ahead, behind) = if counts > 0 {
            (forward, backward)
        } else {
            (backward, forward)
        };
        match (ahead, behind) {
            (true, true) => DriftCause::OneStepLostOrRepeated,
            (true, false) => DriftCause::OneStepRepeated,
            (false, true) => DriftCause::OneStepLost,
            (false, false) => DriftCause::MoreThanOneStep,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::servo::config::{StepChange, Travel};
    use dyn_can::StepLimit;

    const ARRIVAL_US: u32 = 100_000;
    const LIMITS: Limits = Limits::new(StepLimit::MAX, StepChange::MAX, Travel::WHOLE);

    /// An axis that moved 10 steps of 30 counts, one a millisecond, in this direction; a position is asked for at the end.
    fn after_motion(sign: i16) -> DriftWatch {
        let mut watch = DriftWatch::default();
        watch.anchor(Instant::default());
        for cycle in 0..10 {
            let sent = i32::from(sign) * 30 * cycle;
            let at = Instant::from_us(cycle as u64 * 1_000);
            watch.stepped(30 * sign, sent + i32::from(30 * sign), at);
        }
        watch.asked(300 * i32::from(sign), 300 * i32::from(sign));
        watch
    }

    fn judge(watch: &mut DriftWatch, position: i32, at_us: u64) -> Option<Fault> {
        watch.judge(position, Instant::from_us(at_us), &LIMITS, ARRIVAL_US)
    }

    #[test]
    fn a_lagging_drive_is_no_drift() {
        let mut watch = after_motion(1);
        assert_eq!(judge(&mut watch, 200, 11_000), None);
        watch.asked(300, 300);
        assert_eq!(judge(&mut watch, 300, 200_000), None);
    }

    #[test]
    fn the_delay_of_the_reply_is_no_error_however_long_it_is() {
        let strict = Limits {
            following_error_counts: 0,
            drift_tolerance_counts: 0,
            ..LIMITS
        };
        let mut watch = DriftWatch::default();
        watch.anchor(Instant::default());
        watch.asked(0, 0);
        for cycle in 0..1_000 {
            watch.widen(cycle * 30);
        }
        let mut other = watch;
        let now = Instant::from_us(1_000_000);
        assert_eq!(watch.judge(12_345, now, &strict, u32::MAX), None);
        assert_eq!(
            other.judge(29_971, now, &strict, u32::MAX),
            Some(Fault::FollowingError { counts: 1 })
        );
    }

    #[test]
    fn an_error_that_stays_is_drift_and_names_its_cause() {
        let drift = |counts, cause| Some(Fault::Drift { counts, cause });
        for sign in [1, -1] {
            for (position, expected) in [
                (330, drift(30, DriftCause::OneStepRepeated)),
                (270, drift(-30, DriftCause::OneStepLost)),
                (400, drift(100, DriftCause::MoreThanOneStep)),
                (305, None),
            ] {
                let expected = expected.map(|fault| match fault {
                    Fault::Drift { counts, cause } => Fault::Drift {
                        counts: counts * i32::from(sign),
                        cause,
                    },
                    other => other,
                });
                let position = position * i32::from(sign);
                let mut watch = after_motion(sign);
                assert_eq!(judge(&mut watch, position, 200_000), expected, "{position}");
            }
        }
    }

    #[test]
    fn a_jump_in_motion_is_noticed_at_the_next_reading() {
        for jump in [-2_500, 2_500] {
            let mut watch = after_motion(1);
            assert_eq!(judge(&mut watch, 300, 11_000), None);
            watch.asked(300, 300);
            let fault = Fault::PositionJump { counts: jump };
            assert_eq!(judge(&mut watch, 300 + jump, 12_000), Some(fault));
        }
    }

    #[test]
    fn a_drive_that_catches_up_after_its_motion_does_not_jump() {
        for sign in [1, -1] {
            let mut watch = after_motion(sign);
            let sign = i32::from(sign);
            // 47 counts behind, with no set-point for three readings, and then there.
            for (position, at_us) in [(200, 11_000), (253, 31_000), (253, 51_000), (300, 71_000)] {
                assert_eq!(
                    judge(&mut watch, sign * position, at_us),
                    None,
                    "{position}"
                );
                watch.asked(sign * 300, sign * 300);
            }
        }
    }

    /// Readings after each 10 steps of so many counts, of a drive that lags by so many of these counts.
    fn follows(
        watch: &mut DriftWatch,
        sent: &mut i32,
        (step, behind): (i16, i32),
        at_us: &mut u64,
    ) {
        for _ in 0..10 {
            *sent += i32::from(step);
            *at_us += 1_000;
            watch.stepped(step, *sent, Instant::from_us(*at_us));
        }
        let now = Instant::from_us(*at_us);
        let fault = watch.judge(*sent - behind, now, &LIMITS, u32::MAX);
        assert_eq!(fault, None, "{behind}");
        watch.asked(*sent, *sent - i32::from(step));
    }

    #[test]
    fn a_jump_in_slow_motion_is_noticed_after_a_fast_one() {
        for sign in [1, -1] {
            for lag in [0, 20] {
                let mut watch = DriftWatch::default();
                watch.anchor(Instant::default());
                watch.asked(0, 0);
                let (mut sent, mut at_us) = (0, 0);
                for step in [100; 50].into_iter().chain([1; 10]) {
                    let behind = i32::from(sign * step) * lag;
                    follows(&mut watch, &mut sent, (sign * step, behind), &mut at_us);
                }
                let jump = i32::from(sign) * 5_000;
                let fault = judge(&mut watch, sent - i32::from(sign) * lag - jump, at_us);
                assert!(
                    matches!(fault, Some(Fault::PositionJump { .. })),
                    "{fault:?}"
                );
            }
        }
    }

    #[test]
    fn a_drive_that_swings_when_its_motion_ends_does_not_jump() {
        // It catches up slowly, and its error swings around 0 and becomes less and less.
        let swing = [
            2_000, 1_900, 1_700, 1_400, 1_000, 600, 200, -150, -350, -450, -380, -200, 0, 120, 180,
            150, 60, -20,
        ];
        for sign in [1, -1] {
            let mut watch = DriftWatch::default();
            watch.anchor(Instant::default());
            watch.asked(0, 0);
            let (mut sent, mut at_us) = (0, 0);
            for _ in 0..20 {
                follows(
                    &mut watch,
                    &mut sent,
                    (sign * 100, i32::from(sign) * 2_000),
                    &mut at_us,
                );
            }
            for behind in swing {
                follows(
                    &mut watch,
                    &mut sent,
                    (0, i32::from(sign) * behind),
                    &mut at_us,
                );
            }
        }
    }

    #[test]
    fn a_position_that_nobody_asked_for_is_not_judged() {
        let mut watch = after_motion(1);
        watch.is_asked = false;
        assert_eq!(judge(&mut watch, 9_999_999, 200_000), None);
    }
}
