//! Is the drive where the set-points should have taken it?
//!
//! A drive lags behind its set-points while it moves (following error) and catches up when they stop. A set-point that
//! the wire lost or doubled leaves an error that stays. So the position is compared twice: while moving against the
//! generous following-error limit, and at standstill against the tight drift tolerance. Nothing is ever corrected:
//! the axis faults, and the application decides.

use dyn_can::PdStep;

use crate::config::Limits;
use crate::fault::{DriftCause, Fault};
use crate::time::Instant;

/// Cycles of history: the longest time from request to reply that can be compensated.
const HISTORY: usize = 16;

/// What was sent lately, to compare a position with the moment at which it was read.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DriftWatch {
    /// Sent position at the start of each of the latest cycles, in command counts.
    sent_counts: [i32; HISTORY],
    newest: usize,
    moved_at: Instant,
    /// Largest steps in each direction since the position was last confirmed at standstill.
    forward: i16,
    backward: i16,
}

impl DriftWatch {
    pub(crate) const fn new() -> Self {
        Self {
            sent_counts: [0; HISTORY],
            newest: 0,
            moved_at: Instant::from_us(0),
            forward: 0,
            backward: 0,
        }
    }

    /// The position is known to be `counts`.
    pub(crate) fn anchor(&mut self, counts: i32, now: Instant) {
        *self = Self {
            sent_counts: [counts; HISTORY],
            moved_at: now,
            ..Self::new()
        };
    }

    /// A cycle begins with this sent position.
    pub(crate) fn cycle(&mut self, sent_counts: i32) {
        self.newest = (self.newest + 1) % HISTORY;
        if let Some(entry) = self.sent_counts.get_mut(self.newest) {
            *entry = sent_counts;
        }
    }

    /// A set-point went out.
    pub(crate) fn stepped(&mut self, step: PdStep, now: Instant) {
        if step != PdStep::ZERO {
            self.moved_at = now;
            self.forward = self.forward.max(step.get());
            self.backward = self.backward.min(step.get());
        }
    }

    /// Judges a position that was asked for `asked_cycles` cycles ago.
    ///
    /// The drive may have sampled it at any moment since, so it is compared with the range of what was sent then and up
    /// to `sent_counts` now.
    pub(crate) fn judge(
        &mut self,
        position_counts: i32,
        sent_counts: i32,
        asked_cycles: u64,
        now: Instant,
        limits: &Limits,
        standstill_us: u32,
    ) -> Option<Fault> {
        let (low, high) = self.sent_range(sent_counts, asked_cycles)?;
        let error = if position_counts < low {
            i64::from(position_counts) - i64::from(low)
        } else {
            (i64::from(position_counts) - i64::from(high)).max(0)
        };
        let counts = i32::try_from(error).unwrap_or(i32::MAX);
        if counts.unsigned_abs() > limits.following_error {
            return Some(Fault::FollowingError { counts });
        }
        if now.us_since(self.moved_at) < u64::from(standstill_us) {
            return None;
        }
        if counts.unsigned_abs() > limits.drift_tolerance {
            return Some(Fault::Drift {
                counts,
                cause: self.cause(counts, limits.drift_tolerance),
            });
        }
        (self.forward, self.backward) = (0, 0);
        None
    }

    /// Smallest and largest sent position since the request; `None` when it was too long ago.
    fn sent_range(&self, sent_counts: i32, asked_cycles: u64) -> Option<(i32, i32)> {
        let cycles = usize::try_from(asked_cycles)
            .ok()
            .filter(|&cycles| cycles < HISTORY)?;
        let past = (0..=cycles).filter_map(|age| {
            self.sent_counts
                .get((self.newest + HISTORY - age) % HISTORY)
                .copied()
        });
        Some(past.fold((sent_counts, sent_counts), |(low, high), sent| {
            (low.min(sent), high.max(sent))
        }))
    }

    /// Whether one of the steps sent since the last good position explains the error.
    fn cause(&self, counts: i32, tolerance: u32) -> DriftCause {
        let magnitude = counts.unsigned_abs();
        let reaches =
            |step: i16| step != 0 && magnitude <= u32::from(step.unsigned_abs()) + tolerance;
        let (ahead, behind) = if counts > 0 {
            (reaches(self.forward), reaches(self.backward))
        } else {
            (reaches(self.backward), reaches(self.forward))
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

    const STANDSTILL_US: u32 = 100_000;

    /// An axis that moved 10 steps of 30 counts, one a millisecond, and has stood still since.
    fn after_motion() -> DriftWatch {
        let mut watch = DriftWatch::new();
        watch.anchor(0, Instant::from_us(0));
        for cycle in 0..10 {
            watch.cycle(cycle * 30);
            watch.stepped(
                PdStep::new(30).unwrap(),
                Instant::from_us(cycle as u64 * 1_000),
            );
        }
        watch.cycle(300);
        watch
    }

    /// The same axis, a while later.
    fn at_rest() -> DriftWatch {
        let mut watch = after_motion();
        (0..HISTORY).for_each(|_| watch.cycle(300));
        watch
    }

    fn judge(
        watch: &mut DriftWatch,
        position: i32,
        at_us: u64,
        asked_cycles: u64,
    ) -> Option<Fault> {
        let now = Instant::from_us(at_us);
        watch.judge(
            position,
            300,
            asked_cycles,
            now,
            &Limits::WIDEST,
            STANDSTILL_US,
        )
    }

    #[test]
    fn a_lagging_drive_is_no_drift() {
        let mut watch = after_motion();
        assert_eq!(judge(&mut watch, 200, 11_000, 1), None);
        assert_eq!(judge(&mut watch, 300, 200_000, 1), None);
    }

    #[test]
    fn the_delay_of_the_reply_is_no_error() {
        let mut watch = after_motion();
        // Sampled four cycles ago, when 180 counts had been sent.
        let limits = Limits {
            following_error: 0,
            ..Limits::WIDEST
        };
        let now = Instant::from_us(11_000);
        assert_eq!(watch.judge(180, 300, 4, now, &limits, STANDSTILL_US), None);
        assert_eq!(
            watch.judge(170, 300, 4, now, &limits, STANDSTILL_US),
            Some(Fault::FollowingError { counts: -10 })
        );
    }

    #[test]
    fn an_error_that_stays_is_drift_and_names_its_cause() {
        let drift = |counts, cause| Some(Fault::Drift { counts, cause });
        for (position, expected) in [
            (330, drift(30, DriftCause::OneStepRepeated)),
            (270, drift(-30, DriftCause::OneStepLost)),
            (400, drift(100, DriftCause::MoreThanOneStep)),
            (305, None),
        ] {
            assert_eq!(
                judge(&mut at_rest(), position, 200_000, 1),
                expected,
                "{position}"
            );
        }
    }

    #[test]
    fn a_reply_that_took_too_long_is_not_judged() {
        assert_eq!(judge(&mut after_motion(), 9_999_999, 200_000, 16), None);
    }
}
