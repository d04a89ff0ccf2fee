//! What the inputs mean: when the drives may be enabled, when they must not, when the motion runs.
//!
//! - Power-on alone enables nothing. The enable input must be seen inactive first and then become active, so that a machine does not
//!   start when the supply comes back or when a wire is plugged in.
//! - Power-on alone disables nothing either: a load may hang on a drive that comes up with its servo on. Such a drive is left
//!   alone until enable becomes active, which takes it over without switching it, or until one of the inputs says that its power
//!   must go.
//! - Releasing enable slows the axes down and disables the drives; making it active again is the operator's word that faults
//!   may be cleared.
//! - An open stop circuit ends every set-point in the same cycle and disables the drives when they have had time to stop. As long
//!   as it is open, a drive that comes up with its servo on is disabled too.
//! - After a failure of the firmware itself nothing is enabled until the board is switched off and on.
//!
//! Both ways to stop count in every state of every axis; the master repeats a disable command until the drive confirms it.

use crate::config::CYCLE_US;
use crate::debounce::SETTLE_US;

/// From the start until the inputs count: an input that is active needs a while to be believed, and until then it must not be
/// taken for one that was released.
const START_US: u32 = 2 * SETTLE_US;
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
    /// Every axis can be enabled.
    pub(crate) ready: bool,
    /// Every axis can be enabled or adopted, and one must be adopted first.
    pub(crate) adoptable: bool,
    /// A drive has power that this board did not switch on.
    pub(crate) found_on: bool,
    /// An axis has a fault.
    pub(crate) faulted: bool,
    /// The faults can be cleared.
    pub(crate) clearable: bool,
    /// Every axis streams.
    pub(crate) streaming: bool,
    /// A drive has not confirmed its disable command for longer than it should take.
    pub(crate) unconfirmed: bool,
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
    /// Take over the drives that were found on.
    Adopt,
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
    /// The inputs do not count yet.
    Starting,
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
    /// What the state does once was done: the faults were cleared, or every drive was told to disable.
    has_acted: bool,
}

impl Supervisor {
    /// After a start; `locked` when it is one that the firmware's own failure caused.
    pub(crate) const fn new(locked: bool) -> Self {
        Self {
            state: if locked {
                State::Locked
            } else {
                State::Starting
            },
            cycles_left: START_US / CYCLE_US,
            run_armed: false,
            has_acted: false,
        }
    }

    /// Where the machine is.
    pub(crate) const fn state(&self) -> State {
        self.state
    }

    /// One cycle.
    pub(crate) fn update(&mut self, inputs: Inputs, axes: Axes) -> Action {
        let is_over = self.cycles_left == 0;
        self.cycles_left = self.cycles_left.saturating_sub(1);
        match self.state {
            State::Locked => self.locked(axes),
            State::Starting if !is_over => Action::None,
            State::Stopped => self.stopped(inputs, axes),
            _ if !inputs.stop_closed => {
                self.enter(State::Stopped, STOP_US);
                Action::Halt
            }
            State::Starting => {
                let next = if inputs.enable {
                    State::Released
                } else {
                    State::Off
                };
                self.enter(next, 0);
                Action::None
            }
            State::Released | State::GettingReady | State::On | State::Running
                if !inputs.enable =>
            {
                self.enter(State::Off, 0);
                Action::Disable
            }
            State::Off if inputs.enable => {
                self.enter(State::GettingReady, READY_US);
                Action::None
            }
            State::Off | State::Released => Action::None,
            State::GettingReady => self.getting_ready(axes, is_over),
            State::On | State::Running if axes.faulted => {
                // The master has stopped the axes already.
                self.enter(State::Released, 0);
                Action::None
            }
            State::On => self.on(inputs, axes),
            State::Running => self.running(inputs),
        }
    }

    /// The master refused the action: enable must be released before it counts again.
    pub(crate) fn refused(&mut self) {
        self.enter(State::Released, 0);
    }

    /// What ended is enabled again by name: enable need not be released before.
    #[cfg(any(test, feature = "link"))]
    pub(crate) fn rearm(&mut self) {
        if self.state == State::Released {
            self.enter(State::Off, 0);
        }
    }

    fn enter(&mut self, state: State, us: u32) {
        self.state = state;
        self.cycles_left = us / CYCLE_US;
        self.run_armed = false;
        self.has_acted = false;
    }

    /// The first cycle says it whatever is known of the drives; afterwards it is said to those that come up later.
    fn locked(&mut self, axes: Axes) -> Action {
        let is_first = !core::mem::replace(&mut self.has_acted, true);
        disable_if(is_first || axes.found_on)
    }

    fn stopped(&mut self, inputs: Inputs, axes: Axes) -> Action {
        if self.cycles_left > 0 {
            return disable_if(self.cycles_left == 1);
        }
        if inputs.stop_closed {
            self.enter(State::Released, 0);
        }
        disable_if(axes.found_on)
    }

    fn getting_ready(&mut self, axes: Axes, is_over: bool) -> Action {
        if is_over || (axes.faulted && self.has_acted) {
            self.enter(State::Released, 0);
            return Action::None;
        }
        if axes.faulted {
            // Until then an axis slows down, or a drive has yet to say whether it still holds.
            self.has_acted = axes.clearable;
            return if axes.clearable {
                Action::Clear
            } else {
                Action::None
            };
        }
        if axes.adoptable {
            return Action::Adopt;
        }
        if axes.ready {
            self.enter(State::On, 0);
            return Action::Enable;
        }
        Action::None
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

fn disable_if(condition: bool) -> Action {
    if condition {
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
    const NOTHING: Axes = Axes {
        ready: false,
        adoptable: false,
        found_on: false,
        faulted: false,
        clearable: true,
        streaming: false,
        unconfirmed: false,
    };
    const READY: Axes = Axes {
        ready: true,
        ..NOTHING
    };
    const FOUND_ON: Axes = Axes {
        adoptable: true,
        found_on: true,
        ..NOTHING
    };
    const STREAMING: Axes = Axes {
        streaming: true,
        ..NOTHING
    };
    const FAULTED: Axes = Axes {
        faulted: true,
        ..NOTHING
    };
    const OPEN: Inputs = Inputs {
        stop_closed: false,
        enable: false,
        run: false,
    };

    /// One that has started with these inputs.
    fn started(inputs: Inputs, axes: Axes) -> Supervisor {
        let mut supervisor = Supervisor::new(false);
        for _ in 0..START_US / CYCLE_US {
            assert_eq!(supervisor.update(OPEN, axes), Action::None);
        }
        assert_eq!(supervisor.update(inputs, axes), Action::None);
        supervisor
    }

    fn enabled() -> Supervisor {
        let mut supervisor = started(CLOSED, READY);
        assert_eq!(supervisor.update(ENABLE, READY), Action::None);
        assert_eq!(supervisor.update(ENABLE, READY), Action::Enable);
        supervisor
    }

    fn running() -> Supervisor {
        let mut supervisor = enabled();
        supervisor.update(ENABLE, STREAMING);
        assert_eq!(supervisor.update(RUN, STREAMING), Action::Start);
        supervisor
    }

    /// What it does in so many cycles.
    fn actions(
        supervisor: &mut Supervisor,
        cycles: u32,
        inputs: Inputs,
        axes: Axes,
    ) -> Vec<Action> {
        let actions = (0..cycles).map(|_| supervisor.update(inputs, axes));
        actions.filter(|action| *action != Action::None).collect()
    }

    #[test]
    fn enable_that_is_active_at_power_on_enables_nothing() {
        let mut supervisor = started(RUN, READY);
        assert_eq!(actions(&mut supervisor, 100, RUN, READY), []);
        assert_eq!(supervisor.state(), State::Released);
    }

    #[test]
    fn run_that_is_active_at_enable_starts_nothing() {
        let mut supervisor = enabled();
        assert_eq!(actions(&mut supervisor, 100, RUN, STREAMING), []);
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
    fn releasing_enable_disables_whatever_is_known_of_the_axes() {
        let mut waiting = started(CLOSED, NOTHING);
        waiting.update(ENABLE, NOTHING);
        let mut late = waiting;
        actions(&mut late, READY_US / CYCLE_US + 1, ENABLE, NOTHING);
        let mut faulted = running();
        faulted.update(RUN, FAULTED);
        for supervisor in [waiting, late, faulted, enabled(), running()] {
            for axes in [NOTHING, READY, FOUND_ON, STREAMING, FAULTED] {
                let mut supervisor = supervisor;
                assert_eq!(supervisor.update(CLOSED, axes), Action::Disable);
            }
        }
    }

    #[test]
    fn the_stop_circuit_halts_at_once_and_disables_later_whatever_is_known_of_the_axes() {
        let mut waiting = started(CLOSED, NOTHING);
        waiting.update(ENABLE, NOTHING);
        let off = started(CLOSED, NOTHING);
        for supervisor in [off, waiting, enabled(), running()] {
            for axes in [NOTHING, READY, STREAMING, FAULTED] {
                let mut supervisor = supervisor;
                let open = Inputs {
                    stop_closed: false,
                    ..RUN
                };
                assert_eq!(supervisor.update(open, axes), Action::Halt);
                let half = STOP_US / CYCLE_US - 2;
                assert_eq!(actions(&mut supervisor, half, open, axes), []);
                assert_eq!(actions(&mut supervisor, 100, open, axes), [Action::Disable]);
                // Closing the circuit alone brings nothing back.
                assert_eq!(actions(&mut supervisor, 100, RUN, READY), []);
            }
        }
    }

    #[test]
    fn a_fault_needs_enable_released_and_active_again() {
        let mut supervisor = running();
        assert_eq!(actions(&mut supervisor, 100, RUN, FAULTED), []);
        assert_eq!(supervisor.update(CLOSED, FAULTED), Action::Disable);
        assert_eq!(supervisor.update(ENABLE, FAULTED), Action::None);
        let unclear = Axes {
            clearable: false,
            ..FAULTED
        };
        assert_eq!(supervisor.update(ENABLE, unclear), Action::None);
        assert_eq!(supervisor.update(ENABLE, FAULTED), Action::Clear);
        assert_eq!(supervisor.update(ENABLE, READY), Action::Enable);
    }

    #[test]
    fn a_fault_that_comes_back_ends_the_attempt() {
        let mut supervisor = started(CLOSED, FAULTED);
        let seen = actions(&mut supervisor, 100, ENABLE, FAULTED);
        assert_eq!(seen, [Action::Clear]);
        assert_eq!(supervisor.state(), State::Released);
        assert_eq!(actions(&mut supervisor, 100, ENABLE, READY), []);
    }

    #[test]
    fn axes_that_become_ready_too_late_are_not_enabled() {
        let mut supervisor = started(CLOSED, NOTHING);
        let cycles = READY_US / CYCLE_US + 2;
        assert_eq!(actions(&mut supervisor, cycles, ENABLE, NOTHING), []);
        assert_eq!(supervisor.update(ENABLE, READY), Action::None);
    }

    #[test]
    fn what_the_master_refuses_needs_enable_again() {
        let mut supervisor = enabled();
        supervisor.refused();
        assert_eq!(actions(&mut supervisor, 100, ENABLE, READY), []);
    }

    #[test]
    fn a_locked_machine_disables_once_and_what_comes_up_later() {
        let mut supervisor = Supervisor::new(true);
        assert_eq!(supervisor.update(OPEN, NOTHING), Action::Disable);
        for inputs in [CLOSED, ENABLE, RUN, CLOSED, ENABLE] {
            assert_eq!(supervisor.update(inputs, READY), Action::None);
        }
        assert_eq!(supervisor.update(ENABLE, FOUND_ON), Action::Disable);
    }

    #[test]
    fn a_drive_that_came_up_on_is_left_alone_until_an_input_says_so() {
        let mut supervisor = started(CLOSED, FOUND_ON);
        assert_eq!(actions(&mut supervisor, 1_000, CLOSED, FOUND_ON), []);
        let mut stopped = supervisor;
        assert_eq!(stopped.update(OPEN, FOUND_ON), Action::Halt);
        let cycles = STOP_US / CYCLE_US - 1;
        assert_eq!(
            actions(&mut stopped, cycles, OPEN, FOUND_ON),
            [Action::Disable]
        );
        // One that comes up while the circuit is open.
        assert_eq!(stopped.update(OPEN, FOUND_ON), Action::Disable);
        supervisor.update(ENABLE, FOUND_ON);
        assert_eq!(supervisor.update(ENABLE, FOUND_ON), Action::Adopt);
        assert_eq!(supervisor.update(ENABLE, NOTHING), Action::None);
        assert_eq!(supervisor.update(ENABLE, READY), Action::Enable);
    }
}
