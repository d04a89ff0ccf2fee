//! What the inputs mean: when the drives may be enabled, when they must not, when the motion runs.
//!
//! - Power-on alone enables nothing. The enable input must be seen inactive first and then become active, so that a machine does not
//!   start when the supply comes back or when a wire is plugged in.
//! - Releasing enable slows the axes down and disables the drives; making it active again is the operator's word that faults
//!   may be cleared.
//! - An open stop circuit ends every set-point in the same cycle and disables the drives when they have had time to stop.
//! - After a failure of the firmware itself nothing is enabled until the board is switched off and on.

use crate::config::CYCLE_US;

/// From the stop to the disable command: a drive that is still enabled holds against its last set-point and stops the motor,
/// a disabled one lets it coast.
const STOP_US: u32 = 500_000;
/// The axes must be ready this soon after enable became active, or it does not count any more.
const READY_US: u32 = 5_000_000;

/// The inputs, debounced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Inputs {
    /// The stop circuit is closed.
    pub(crate) stop_closed: bool,
    /// The drives may be enabled.
    pub(crate) enable: bool,
    /// The motion shall run.
    pub(crate) run: bool,
}

/// The axes, as far as it matters here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Axes {
    /// Every axis is known and at rest, without a fault.
    pub(crate) ready: bool,
    /// An axis has a fault.
    pub(crate) faulted: bool,
    /// Every axis streams.
    pub(crate) streaming: bool,
    /// A drive that is at rest says that its servo is on.
    pub(crate) servo_on: bool,
}

/// What is to be done in this cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub(crate) enum Action {
    /// Nothing.
    None,
    /// End all set-points.
    Halt,
    /// Slow down and disable.
    Disable,
    /// Forget faults.
    Clear,
    /// Enable the drives.
    Enable,
    /// Begin the motion.
    Start,
    /// End the motion when it is back at its start.
    Finish,
}

/// Where the machine is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub(crate) enum State {
    /// The firmware failed before this start.
    Locked,
    /// The stop circuit is open.
    Stopped,
    /// Enable must be released before it counts.
    Released,
    /// Waiting for enable.
    Off,
    /// Enable is active, the axes are not ready yet.
    GettingReady,
    /// The drives are enabled, or on their way.
    On,
    /// The motion runs.
    Running,
}

/// Decides once a cycle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Supervisor {
    state: State,
    /// Cycles left of the state.
    cycles_left: u32,
    /// The run input was inactive since the drives were enabled.
    run_armed: bool,
}

impl Supervisor {
    /// After a start; `locked` when it is one that the firmware's own failure caused.
    pub(crate) const fn new(locked: bool) -> Self {
        Self {
            state: if locked {
                State::Locked
            } else {
                State::Released
            },
            cycles_left: 0,
            run_armed: false,
        }
    }

    /// Where the machine is.
    pub(crate) const fn state(&self) -> State {
        self.state
    }

    /// One cycle.
    pub(crate) fn update(&mut self, inputs: Inputs, axes: Axes) -> Action {
        self.cycles_left = self.cycles_left.saturating_sub(1);
        match self.state {
            State::Locked => disable_if(axes.servo_on),
            State::Stopped => self.stopped(inputs, axes),
            State::Released | State::Off if !inputs.stop_closed => {
                self.enter(State::Stopped, 0);
                Action::None
            }
            _ if !inputs.stop_closed => {
                self.enter(State::Stopped, STOP_US);
                Action::Halt
            }
            State::GettingReady | State::On | State::Running if !inputs.enable => {
                self.enter(State::Off, 0);
                Action::Disable
            }
            State::Released => {
                if !inputs.enable {
                    self.enter(State::Off, 0);
                }
                disable_if(axes.servo_on)
            }
            State::Off => self.off(inputs, axes),
            State::GettingReady => self.getting_ready(axes),
            State::On | State::Running if axes.faulted => {
                // The master has stopped the axes already.
                self.enter(State::Released, 0);
                Action::None
            }
            State::On => self.on(inputs, axes),
            State::Running => self.running(inputs),
        }
    }

    fn enter(&mut self, state: State, us: u32) {
        self.state = state;
        self.cycles_left = us / CYCLE_US;
        self.run_armed = false;
    }

    fn stopped(&mut self, inputs: Inputs, axes: Axes) -> Action {
        if self.cycles_left > 0 {
            return if self.cycles_left == 1 {
                Action::Disable
            } else {
                Action::None
            };
        }
        if inputs.stop_closed {
            self.enter(State::Released, 0);
        }
        disable_if(axes.servo_on)
    }

    fn off(&mut self, inputs: Inputs, axes: Axes) -> Action {
        if !inputs.enable {
            return disable_if(axes.servo_on);
        }
        self.enter(State::GettingReady, READY_US);
        if axes.faulted {
            Action::Clear
        } else {
            Action::None
        }
    }

    fn getting_ready(&mut self, axes: Axes) -> Action {
        if axes.ready {
            self.enter(State::On, 0);
            Action::Enable
        } else if self.cycles_left == 0 {
            self.enter(State::Released, 0);
            Action::None
        } else {
            Action::None
        }
    }

    fn on(&mut self, inputs: Inputs, axes: Axes) -> Action {
        if !inputs.run {
            self.run_armed = axes.streaming;
        } else if self.run_armed {
            self.enter(State::Running, 0);
            return Action::Start;
        }
        Action::None
    }

    fn running(&mut self, inputs: Inputs) -> Action {
        if inputs.run {
            return Action::None;
        }
        self.enter(State::On, 0);
        Action::Finish
    }
}

/// Drives come up with their servo on (DYN2 manual A1.8, section 3.2).
fn disable_if(servo_on: bool) -> Action {
    if servo_on {
        Action::Disable
    } else {
        Action::None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOSED: Inputs = Inputs {
        stop_closed: true,
        enable: false,
        run: false,
    };
    const ENABLE: Inputs = Inputs {
        enable: true,
        ..CLOSED
    };
    const RUN: Inputs = Inputs {
        run: true,
        ..ENABLE
    };
    const READY: Axes = Axes {
        ready: true,
        faulted: false,
        streaming: false,
        servo_on: false,
    };
    const STREAMING: Axes = Axes {
        ready: false,
        streaming: true,
        ..READY
    };
    const FAULTED: Axes = Axes {
        ready: false,
        faulted: true,
        ..READY
    };

    fn enabled() -> Supervisor {
        let mut supervisor = Supervisor::new(false);
        supervisor.update(CLOSED, READY);
        supervisor.update(ENABLE, READY);
        assert_eq!(supervisor.update(ENABLE, READY), Action::Enable);
        supervisor
    }

    fn running() -> Supervisor {
        let mut supervisor = enabled();
        supervisor.update(ENABLE, STREAMING);
        assert_eq!(supervisor.update(RUN, STREAMING), Action::Start);
        supervisor
    }

    #[test]
    fn enable_that_is_active_at_power_on_enables_nothing() {
        let mut supervisor = Supervisor::new(false);
        for _ in 0..100 {
            assert_eq!(supervisor.update(RUN, READY), Action::None);
        }
        assert_eq!(supervisor.state(), State::Released);
    }

    #[test]
    fn run_that_is_active_at_enable_starts_nothing() {
        let mut supervisor = enabled();
        for _ in 0..100 {
            assert_eq!(supervisor.update(RUN, STREAMING), Action::None);
        }
        supervisor.update(ENABLE, STREAMING);
        assert_eq!(supervisor.update(RUN, STREAMING), Action::Start);
    }

    #[test]
    fn releasing_run_finishes_and_releasing_enable_disables() {
        let mut supervisor = running();
        assert_eq!(supervisor.update(ENABLE, STREAMING), Action::Finish);
        assert_eq!(supervisor.update(CLOSED, STREAMING), Action::Disable);
        assert_eq!(supervisor.state(), State::Off);
    }

    #[test]
    fn the_stop_circuit_halts_at_once_and_disables_later() {
        let mut supervisor = running();
        let open = Inputs {
            stop_closed: false,
            ..RUN
        };
        assert_eq!(supervisor.update(open, STREAMING), Action::Halt);
        let actions: Vec<_> = (0..STOP_US / CYCLE_US)
            .map(|_| supervisor.update(open, Axes::default()))
            .collect();
        assert_eq!(
            actions
                .iter()
                .filter(|action| **action == Action::Disable)
                .count(),
            1
        );
        // Closing the circuit alone brings nothing back.
        for _ in 0..100 {
            assert_eq!(supervisor.update(RUN, READY), Action::None);
        }
    }

    #[test]
    fn a_fault_needs_enable_released_and_active_again() {
        let mut supervisor = running();
        assert_eq!(supervisor.update(RUN, FAULTED), Action::None);
        assert_eq!(supervisor.update(RUN, FAULTED), Action::None);
        assert_eq!(supervisor.update(CLOSED, FAULTED), Action::None);
        assert_eq!(supervisor.update(ENABLE, FAULTED), Action::Clear);
        assert_eq!(supervisor.update(ENABLE, READY), Action::Enable);
    }

    #[test]
    fn axes_that_become_ready_too_late_are_not_enabled() {
        let mut supervisor = Supervisor::new(false);
        supervisor.update(CLOSED, Axes::default());
        for _ in 0..=READY_US / CYCLE_US + 1 {
            assert_eq!(supervisor.update(ENABLE, Axes::default()), Action::None);
        }
        assert_eq!(supervisor.update(ENABLE, READY), Action::None);
    }

    #[test]
    fn a_locked_machine_only_disables() {
        let mut supervisor = Supervisor::new(true);
        let servo_on = Axes {
            servo_on: true,
            ..READY
        };
        assert_eq!(supervisor.update(ENABLE, servo_on), Action::Disable);
        for inputs in [CLOSED, ENABLE, RUN, CLOSED, ENABLE] {
            assert_eq!(supervisor.update(inputs, READY), Action::None);
        }
    }

    #[test]
    fn a_servo_that_came_up_on_is_disabled_while_enable_is_not_given() {
        let mut supervisor = Supervisor::new(false);
        let servo_on = Axes {
            servo_on: true,
            ..READY
        };
        supervisor.update(CLOSED, Axes::default());
        assert_eq!(supervisor.update(CLOSED, servo_on), Action::Disable);
    }
}
