//! What a wheel is told: its target, the value of the latest frame, and the way down to a stop.

use crate::ramp::{Ramp, cycles_to_stop};

use super::config::{WheelConfig, WheelMode};

/// Target and value sent, in the unit of the mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Books {
    target: i32,
    sent: i32,
    /// Change of the value from the frame before to the latest.
    last_step: i32,
}

impl Books {
    /// Nothing is owed and nothing changes.
    pub(super) fn anchor(&mut self, value: i32) {
        *self = Self {
            target: value,
            sent: value,
            last_step: 0,
        };
    }

    pub(super) fn set_target(&mut self, target: i32) {
        self.target = target;
    }

    pub(super) const fn target(&self) -> i32 {
        self.target
    }

    pub(super) const fn sent(&self) -> i32 {
        self.sent
    }

    /// The value of the next frame: towards the target by one step at most.
    pub(super) fn next(&self, max_step: u32) -> i32 {
        let most = i64::from(max_step);
        let step = (i64::from(self.target) - i64::from(self.sent)).clamp(-most, most);
        // Between two values of 32 bits.
        (i64::from(self.sent) + step) as i32
    }

    /// The controller accepted a frame with this value.
    pub(super) fn accepted(&mut self, value: i32) {
        self.last_step = value.wrapping_sub(self.sent);
        self.sent = value;
    }
}

/// A wheel on its way to a stop, in step with its group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum WheelRamp {
    /// A speed that falls to 0.
    Speed {
        start: i32,
        cycles: u16,
        elapsed: u16,
    },
    /// A position whose velocity falls to 0.
    Position(Ramp),
}

impl WheelRamp {
    pub(super) fn new(books: &Books, mode: WheelMode, cycles: u16) -> Self {
        match mode {
            WheelMode::Velocity => Self::Speed {
                start: books.sent,
                cycles,
                elapsed: 0,
            },
            WheelMode::Position { .. } => {
                Self::Position(Ramp::new(books.sent, books.last_step, cycles))
            }
        }
    }

    /// Cycles that a wheel needs to stop within its limits.
    pub(super) fn cycles(books: &Books, config: &WheelConfig) -> u16 {
        match config.mode {
            WheelMode::Velocity => cycles_to_stop(books.sent, config.limits.max_step),
            WheelMode::Position { .. } => {
                cycles_to_stop(books.last_step, config.limits.ramp_change)
            }
        }
    }

    pub(super) fn next_target(&mut self) -> i32 {
        match self {
            Self::Position(ramp) => ramp.next_target(),
            Self::Speed {
                start,
                cycles,
                elapsed,
            } => {
                *elapsed = elapsed.saturating_add(1).min(*cycles);
                let left = i64::from(*cycles - *elapsed);
                // At most the start in size; no cycles are no speed.
                (i64::from(*start) * left)
                    .checked_div(i64::from(*cycles))
                    .unwrap_or(0) as i32
            }
        }
    }

    pub(super) const fn is_done(&self) -> bool {
        match self {
            Self::Position(ramp) => ramp.is_done(),
            Self::Speed {
                cycles, elapsed, ..
            } => *elapsed >= *cycles,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn speeds_fall_in_proportion() {
        let ramp = |start| {
            let mut books = Books::default();
            books.anchor(start);
            let mut ramp = WheelRamp::new(&books, WheelMode::Velocity, 4);
            [(); 5].map(|()| ramp.next_target())
        };
        assert_eq!(ramp(100), [75, 50, 25, 0, 0]);
        assert_eq!(ramp(-40), [-30, -20, -10, 0, 0]);
    }

    proptest! {
        #[test]
        fn no_frame_changes_more_than_a_step(from in any::<i32>(), target in any::<i32>(), step in 1..=u32::MAX) {
            let mut books = Books::default();
            books.anchor(from);
            books.set_target(target);
            let next = books.next(step);
            prop_assert!(next.abs_diff(from) <= step);
            prop_assert!(next.abs_diff(target) <= from.abs_diff(target));
            prop_assert!(next == target || next.abs_diff(from) == step);
        }
    }
}
