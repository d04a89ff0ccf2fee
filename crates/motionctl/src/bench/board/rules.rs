//! What the inputs and the host let happen: the inputs rule.

use board_link::message::{Reason, Refused};
use can_motion::Instant;

use super::inputs::Levels;

/// From the stop to the disable command: a drive that is still enabled holds against its last set-point and stops the motor.
const STOP_US: u64 = 500_000;
/// The drives must be enabled this soon after the host asked for it.
const ENABLE_US: u64 = 8_000_000;

/// The axes, as far as it matters here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Axes {
    /// Every axis can be enabled, holds, or streams.
    pub(super) ready: bool,
    /// One has power that this board did not switch on, and the others can be enabled.
    pub(super) adoptable: bool,
    /// Every axis streams.
    pub(super) streaming: bool,
    /// This board has switched a drive on, or moves it.
    pub(super) powered: bool,
    /// Place and number of a fault.
    pub(super) fault: Option<(usize, u16)>,
}

/// What is to be done in this cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Act {
    Nothing,
    /// End all set-points at once.
    Halt,
    /// Slow down and switch off.
    Disable,
    Adopt,
    Enable,
}

/// What the host wants of the power of the drives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Wish {
    Off,
    /// On their way since then; told is that the command was given.
    Getting {
        since: Instant,
        told: bool,
    },
    On,
}

/// The rules.
#[derive(Debug)]
pub(super) struct Rules {
    enable_fitted: bool,
    wish: Wish,
    /// When the drives must be off, after the stop circuit has opened.
    off_at: Option<Instant>,
    was_stopped: bool,
    was_released: bool,
}

impl Rules {
    pub(super) const fn new(enable_fitted: bool) -> Self {
        Self {
            enable_fitted,
            wish: Wish::Off,
            off_at: None,
            was_stopped: false,
            was_released: false,
        }
    }

    pub(super) const fn wants_power(&self) -> bool {
        !matches!(self.wish, Wish::Off)
    }

    pub(super) const fn is_released(&self, inputs: Levels) -> bool {
        self.enable_fitted && !inputs.enable
    }

    /// The stop circuit is open, or has been: once it has opened the drives are switched off, also when it closes before that.
    pub(super) const fn is_stopped(&self, inputs: Levels) -> bool {
        !inputs.stop_closed || self.off_at.is_some()
    }

    /// The host wants the drives on. That they are is a state.
    ///
    /// # Errors
    /// The input or the fault that forbids it.
    pub(super) fn enable(
        &mut self,
        now: Instant,
        inputs: Levels,
        axes: &Axes,
    ) -> Result<(), Refused> {
        if self.is_stopped(inputs) {
            return Err(Reason::StopInput.plain());
        }
        if self.is_released(inputs) {
            return Err(Reason::EnableInput.plain());
        }
        if let Some((axis, number)) = axes.fault {
            return Err(Reason::Faulted.at(axis, 0, number.into()));
        }
        if !self.wants_power() {
            self.wish = Wish::Getting {
                since: now,
                told: false,
            };
        }
        Ok(())
    }

    /// The host wants them off.
    pub(super) const fn disable(&mut self) -> Act {
        self.wish = Wish::Off;
        Act::Disable
    }

    /// The host ends all set-points. The drives keep their power, and nothing is followed before they are enabled again.
    pub(super) const fn halt(&mut self) -> Act {
        self.wish = Wish::Off;
        Act::Halt
    }

    /// One cycle.
    pub(super) fn update(&mut self, now: Instant, inputs: Levels, axes: &Axes) -> Act {
        if self.is_stopped(inputs) {
            return self.stopped(now);
        }
        self.was_stopped = false;
        if self.is_released(inputs) {
            self.wish = Wish::Off;
            let is_new = !core::mem::replace(&mut self.was_released, true);
            return if is_new { Act::Disable } else { Act::Nothing };
        }
        self.was_released = false;
        self.follow_wish(now, axes)
    }

    fn stopped(&mut self, now: Instant) -> Act {
        self.wish = Wish::Off;
        if !core::mem::replace(&mut self.was_stopped, true) {
            self.off_at = Some(Instant::from_us(now.as_us() + STOP_US));
            return Act::Halt;
        }
        if self.off_at.is_some_and(|at| now.as_us() >= at.as_us()) {
            self.off_at = None;
            return Act::Disable;
        }
        Act::Nothing
    }

    fn follow_wish(&mut self, now: Instant, axes: &Axes) -> Act {
        match self.wish {
            Wish::Off => Act::Nothing,
            Wish::On if axes.fault.is_some() => {
                // The master has stopped the axes. Power comes back on the host's word alone.
                self.wish = Wish::Off;
                Act::Nothing
            }
            Wish::On if !axes.streaming => {
                // They hold, whatever has stopped them: the host enables them again.
                self.wish = Wish::Off;
                Act::Nothing
            }
            Wish::On => Act::Nothing,
            Wish::Getting { since, told } => self.get_ready(now, axes, since, told),
        }
    }

    fn get_ready(&mut self, now: Instant, axes: &Axes, since: Instant, told: bool) -> Act {
        if axes.fault.is_some() || now.us_since(since) >= ENABLE_US {
            self.wish = Wish::Off;
            return Act::Disable;
        }
        if axes.streaming {
            self.wish = Wish::On;
            return Act::Nothing;
        }
        if axes.adoptable {
            return Act::Adopt;
        }
        if axes.ready && !told {
            self.wish = Wish::Getting { since, told: true };
            return Act::Enable;
        }
        Act::Nothing
    }

    /// The master refused what was to be done.
    pub(super) const fn refused(&mut self) {
        if let Wish::Getting { told, .. } = &mut self.wish {
            *told = false;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOSED: Levels = Levels {
        stop_closed: true,
        enable: true,
    };
    const OPEN: Levels = Levels {
        stop_closed: false,
        ..CLOSED
    };
    const RELEASED: Levels = Levels {
        enable: false,
        ..CLOSED
    };
    const READY: Axes = Axes {
        ready: true,
        adoptable: false,
        streaming: false,
        powered: false,
        fault: None,
    };
    const STREAMING: Axes = Axes {
        ready: false,
        streaming: true,
        powered: true,
        ..READY
    };

    fn at(ms: u64) -> Instant {
        Instant::from_us(ms * 1_000)
    }

    fn enabled() -> Rules {
        let mut rules = Rules::new(true);
        assert_eq!(rules.update(at(0), CLOSED, &READY), Act::Nothing);
        rules.enable(at(0), CLOSED, &READY).unwrap();
        assert_eq!(rules.update(at(0), CLOSED, &READY), Act::Enable);
        assert_eq!(rules.update(at(1), CLOSED, &READY), Act::Nothing);
        assert_eq!(rules.update(at(2), CLOSED, &STREAMING), Act::Nothing);
        rules
    }

    #[test]
    fn an_open_stop_circuit_halts_at_once_and_disables_later() {
        let mut rules = enabled();
        assert_eq!(rules.update(at(10), OPEN, &STREAMING), Act::Halt);
        assert_eq!(rules.update(at(509), OPEN, &STREAMING), Act::Nothing);
        assert_eq!(rules.update(at(510), OPEN, &STREAMING), Act::Disable);
        assert_eq!(rules.update(at(900), OPEN, &READY), Act::Nothing);
        // Closed again, nothing is enabled before somebody says so.
        assert_eq!(rules.update(at(901), CLOSED, &READY), Act::Nothing);
        let refused = rules.enable(at(902), OPEN, &READY).unwrap_err();
        assert_eq!(refused.reason(), Some(Reason::StopInput));
    }

    #[test]
    fn a_stop_circuit_that_was_open_for_a_moment_disables_too() {
        let mut rules = enabled();
        assert_eq!(rules.update(at(10), OPEN, &STREAMING), Act::Halt);
        assert_eq!(rules.update(at(11), CLOSED, &READY), Act::Nothing);
        let refused = rules.enable(at(12), CLOSED, &READY).unwrap_err();
        assert_eq!(refused.reason(), Some(Reason::StopInput));
        assert_eq!(rules.update(at(510), CLOSED, &READY), Act::Disable);
        assert_eq!(rules.update(at(511), CLOSED, &READY), Act::Nothing);
        rules.enable(at(512), CLOSED, &READY).unwrap();
        assert_eq!(rules.update(at(512), CLOSED, &READY), Act::Enable);
    }

    #[test]
    fn axes_that_do_not_follow_any_more_are_enabled_by_name() {
        let mut rules = enabled();
        let holding = Axes {
            ready: true,
            streaming: false,
            ..STREAMING
        };
        assert_eq!(rules.update(at(10), CLOSED, &holding), Act::Nothing);
        assert!(!rules.wants_power());
        rules.enable(at(11), CLOSED, &holding).unwrap();
        assert_eq!(rules.update(at(11), CLOSED, &holding), Act::Enable);
    }

    #[test]
    fn an_enable_input_that_is_released_slows_down_and_disables() {
        let mut rules = enabled();
        assert_eq!(rules.update(at(10), RELEASED, &STREAMING), Act::Disable);
        assert_eq!(rules.update(at(11), RELEASED, &STREAMING), Act::Nothing);
        let refused = rules.enable(at(12), RELEASED, &READY).unwrap_err();
        assert_eq!(refused.reason(), Some(Reason::EnableInput));
        assert_eq!(rules.update(at(13), CLOSED, &READY), Act::Nothing);
        // Where none is fitted it says nothing.
        let mut rules = Rules::new(false);
        assert_eq!(rules.enable(at(0), RELEASED, &READY), Ok(()));
        assert_eq!(rules.update(at(0), RELEASED, &READY), Act::Enable);
    }

    #[test]
    fn a_fault_and_a_halt_take_the_wish_back() {
        let faulted = Axes {
            fault: Some((1, 10)),
            ..READY
        };
        let mut rules = enabled();
        rules.update(at(10), CLOSED, &faulted);
        assert!(!rules.wants_power());
        let refused = rules.enable(at(11), CLOSED, &faulted).unwrap_err();
        assert_eq!(
            (refused.reason(), refused.axis),
            (Some(Reason::Faulted), Some(1))
        );
        let mut rules = enabled();
        let holding = Axes {
            ready: true,
            streaming: false,
            ..STREAMING
        };
        assert_eq!(rules.halt(), Act::Halt);
        assert_eq!(rules.update(at(10), CLOSED, &holding), Act::Nothing);
        rules.enable(at(11), CLOSED, &holding).unwrap();
        assert_eq!(rules.update(at(11), CLOSED, &holding), Act::Enable);
    }
}
