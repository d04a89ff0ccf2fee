//! What a wheel is told: its target, the value of the latest frame, and the way down to a stop.

use crate::core::ramp::{Ramp, cycles_to_stop};
use crate::wheel::config::{WheelConfig, WheelMode};

/// Target and value sent, in the unit of the mode. Values are absolute: a lost frame costs a cycle and no position.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Ledger {
    target: i32,
    sent: i32,
    /// Change of the value from the frame before to the latest.
    last_step: i32,
    /// The value of the frame that is being offered.
    offered: i32,
    ramp: Option<WheelRamp>,
}

impl Ledger {
    /// Nothing is owed and nothing changes.
    pub(crate) fn anchor(&mut self, value: i32) {
        *self = Self {
            target: value,
            sent: value,
            ..Self::default()
        };
    }

    /// Set-points end: the value stays, and what is owed is forgotten.
    pub(crate) fn end_motion(&mut self) {
        self.anchor(self.sent);
    }

    pub(crate) fn set_target(&mut self, target: i32) {
        self.target = target;
    }

    pub(crate) const fn target(&self) -> i32 {
        self.target
    }

    pub(crate) const fn sent(&self) -> i32 {
        self.sent
    }

    /// The value of the next frame: towards the target by one step at most.
    pub(crate) fn offer(&mut self, max_step: u32) -> i32 {
        let most = i64::from(max_step);
        let step = i64::from(self.target) - i64::from(self.sent);
        // Between two values of 32 bits.
        self.offered = (i64::from(self.sent) + step.max(-most).min(most)) as i32;
        self.offered
    }

    /// The controller accepted the frame that was offered.
    pub(crate) fn accepted(&mut self) {
        self.last_step = self.offered.wrapping_sub(self.sent);
        self.sent = self.offered;
    }

    /// Slows down from the present value in so many cycles.
    pub(crate) fn begin_ramp(&mut self, mode: WheelMode, cycles: u32) {
        let ramp = match mode {
            WheelMode::Velocity => WheelRamp::Speed {
                start: self.sent,
                cycles,
                elapsed: 0,
            },
            WheelMode::Position { .. } => {
                WheelRamp::Position(Ramp::new(self.sent, self.last_step, cycles))
            }
        };
        self.target = self.sent;
        self.ramp = Some(ramp);
    }

    /// A cycle begins: a ramp goes on.
    pub(crate) fn begin_cycle(&mut self) {
        if let Some(ramp) = &mut self.ramp {
            self.target = ramp.next_target();
        }
    }

    /// Cycles that a wheel needs to stop within its limits.
    pub(crate) fn cycles_to_stop(&self, config: &WheelConfig) -> u32 {
        match config.mode {
            WheelMode::Velocity => cycles_to_stop(self.sent, config.limits.max_step),
            WheelMode::Position { .. } => {
                cycles_to_stop(self.last_step, config.limits.max_step_change)
            }
        }
    }

    /// Where a position stands when it stops in so many cycles; a speed always ends at 0.
    pub(crate) const fn end_of_ramp(&self, mode: WheelMode, cycles: u32) -> i32 {
        match mode {
            WheelMode::Velocity => 0,
            WheelMode::Position { .. } => Ramp::new(self.sent, self.last_step, cycles).end(),
        }
    }

    pub(crate) fn has_stopped(&self) -> bool {
        self.ramp.is_none_or(|ramp| ramp.is_done()) && self.target == self.sent
    }
}

/// A wheel on its way to a stop, in step with its group.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum WheelRamp {
    /// A speed that falls to 0.
    Speed {
        start: i32,
        cycles: u32,
        elapsed: u32,
    },
    /// A position whose velocity falls to 0.
    Position(Ramp),
}

impl WheelRamp {
    fn next_target(&mut self) -> i32 {
        match self {
            Self::Position(ramp) => ramp.next_target(),
            Self::Speed {
                start,
                cycles,
                elapsed,
            } => {
                *elapsed = elapsed.saturating_add(1).min(*cycles);
                let left = i64::from(cycles.saturating_sub(*elapsed));
                // At most the start in size; no cycles are no speed.
                (i64::from(*start) * left)
                    .checked_div(i64::from(*cycles))
                    .unwrap_or(0) as i32
            }
        }
    }

    const fn is_done(&self) -> bool {
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
            let mut ledger = Ledger::default();
            ledger.anchor(start);
            ledger.begin_ramp(WheelMode::Velocity, 4);
            [(); 5].map(|()| {
                ledger.begin_cycle();
                ledger.target()
            })
        };
        assert_eq!(ramp(100), [75, 50, 25, 0, 0]);
        assert_eq!(ramp(-40), [-30, -20, -10, 0, 0]);
    }

    proptest! {
        #[test]
        fn no_frame_changes_more_than_a_step(from in any::<i32>(), target in any::<i32>(), step in 1..=u32::MAX) {
            let mut ledger = Ledger::default();
            ledger.anchor(from);
            ledger.set_target(target);
            let next = ledger.offer(step);
            prop_assert!(next.abs_diff(from) <= step);
            prop_assert!(next.abs_diff(target) <= from.abs_diff(target));
            prop_assert!(next == target || next.abs_diff(from) == step);
        }
    }
}
