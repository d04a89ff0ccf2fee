//! What the inputs and the state of the machine let a command do. The inputs rule: a command only ever asks for what they permit, and what
//! they end must be commanded again.
//!
//! To the supervisor the host is a second contact behind the enable input: its `enable` is active while both are.

use board_link::board::Command;
use board_link::message::BoardState;
use board_link::{Reason, Refused};

use crate::supervisor::{Axes, Inputs, State, Supervisor};

/// Whether the image has a homing.
const HOMES: bool = cfg!(any(test, feature = "link-homing"));

/// What a command has the cycle do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// Nothing at once.
    Nothing,
    /// Slow down what moves without a stream.
    Stop,
    /// Find the origins: the result comes when that ends.
    Home,
    /// End all set-points.
    Halt,
    /// Slow down and disable.
    Disable,
    /// Forget faults.
    Clear,
    /// Let the thread store the settings.
    Store,
}

/// What the host has commanded.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rules {
    /// The host wants the drives to be enabled.
    is_wanted: bool,
    /// The ticket of the command to enable, which is under way.
    enabling: Option<u16>,
    /// In the cycle before the drives were enabled and followed.
    has_followed: bool,
}

/// What counts when a command comes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Situation {
    /// The inputs; enable is active where none is fitted.
    pub(crate) inputs: Inputs,
    /// The axes.
    pub(crate) axes: Axes,
    /// This board has switched a drive on that has not confirmed since that it is off, or moves it.
    pub(crate) is_powered: bool,
    /// The thread stores settings.
    pub(crate) is_storing: bool,
}

impl Rules {
    /// A command; `None` when its result comes later, from [`Self::outcome`].
    pub(crate) fn take(
        &mut self,
        ticket: u16,
        command: Command,
        supervisor: &mut Supervisor,
        situation: Situation,
    ) -> Option<Result<Order, Refused>> {
        if supervisor.state() == State::Locked {
            return Some(Err(Reason::Locked.plain()));
        }
        let result = match command {
            Command::Enable => match self.enable(ticket, supervisor, situation) {
                Ok(true) => return None,
                Ok(false) => Ok(Order::Nothing),
                Err(refused) => Err(refused),
            },
            Command::Disable => {
                self.is_wanted = false;
                Ok(Order::Disable)
            }
            // A stream slows down by its player; without one a homing moves, or nothing that would not stop by itself.
            Command::Stop => Ok(Order::Stop),
            Command::Halt => {
                if matches!(supervisor.state(), State::GettingReady | State::On) {
                    supervisor.refused();
                }
                Ok(Order::Halt)
            }
            Command::Clear => clear(situation),
            Command::Home if !HOMES => Err(Reason::Unsupported.plain()),
            Command::Home => match self.ends_homing(supervisor.state(), situation) {
                Some(refused) => Err(refused),
                None => Ok(Order::Home),
            },
            Command::SaveSettings { .. }
                if situation.is_powered || situation.axes.found_on || self.enabling.is_some() =>
            {
                Err(Reason::Enabled.plain())
            }
            Command::SaveSettings { .. } => Ok(Order::Store),
        };
        Some(result)
    }

    /// Whether it goes on: its result comes later.
    fn enable(
        &mut self,
        ticket: u16,
        supervisor: &mut Supervisor,
        situation: Situation,
    ) -> Result<bool, Refused> {
        let state = supervisor.state();
        if let Some(refused) = forbidden(state, situation) {
            return Err(refused);
        }
        match state {
            State::On if situation.axes.streaming => return Ok(false),
            // Faults are stored unasked, for up to a second.
            State::Off | State::Released if situation.is_storing => {
                return Err(Reason::Busy.because(0, 1));
            }
            State::Off | State::Released => {}
            _ => return Err(not_ready(board_state(state, situation))),
        }
        supervisor.rearm();
        self.is_wanted = true;
        self.enabling = Some(ticket);
        Ok(true)
    }

    /// Why the axes cannot be homed, or not any more.
    pub(crate) fn ends_homing(&self, state: State, situation: Situation) -> Option<Refused> {
        forbidden(state, situation).or_else(|| {
            let actual = board_state(state, situation);
            let (enabled, is) = (BoardState::Enabled as i64, actual as i64);
            (actual != BoardState::Enabled).then(|| Reason::NotEnabled.because(enabled, is))
        })
    }

    /// How a command ended whose result comes later; to be asked in the cycles after the one that took it.
    pub(crate) fn outcome(
        &mut self,
        state: State,
        situation: Situation,
    ) -> Option<(u16, Result<(), Refused>)> {
        let ticket = self.enabling?;
        let result = match state {
            State::On if situation.axes.streaming => Ok(()),
            State::GettingReady | State::On if forbidden(state, situation).is_none() => {
                return None;
            }
            _ => Err(forbidden(state, situation)
                .unwrap_or_else(|| not_ready(board_state(state, situation)))),
        };
        self.enabling = None;
        Some((ticket, result))
    }

    /// What the supervisor sees of the inputs, once a cycle.
    pub(crate) fn contacts(&mut self, supervisor: &mut Supervisor, situation: Situation) -> Inputs {
        let Situation { inputs, axes, .. } = situation;
        if !inputs.stop_closed || !inputs.enable {
            self.is_wanted = false;
        }
        if axes.faulted && supervisor.state() == State::GettingReady {
            // Faults are cleared by name, and not on the way.
            supervisor.refused();
        }
        let follows = supervisor.state() == State::On && axes.streaming;
        if core::mem::replace(&mut self.has_followed, follows)
            && supervisor.state() == State::On
            && !follows
        {
            // The master has stopped them, and no command: the host enables them again.
            supervisor.refused();
        }
        Inputs {
            enable: self.is_wanted,
            run: false,
            ..inputs
        }
    }
}

fn clear(situation: Situation) -> Result<Order, Refused> {
    match situation.axes {
        Axes { faulted: false, .. } => Ok(Order::Nothing),
        Axes {
            clearable: true, ..
        } => Ok(Order::Clear),
        _ => Err(not_ready(BoardState::Faulted)),
    }
}

/// Why nothing may be enabled.
fn forbidden(state: State, situation: Situation) -> Option<Refused> {
    let Situation { inputs, axes, .. } = situation;
    if !inputs.stop_closed || state == State::Stopped {
        Some(Reason::StopInput.plain())
    } else if !inputs.enable {
        Some(Reason::EnableInput.plain())
    } else if axes.faulted {
        let faulted = BoardState::Faulted as i64;
        Some(Reason::Faulted.because(BoardState::Off as i64, faulted))
    } else {
        None
    }
}

fn not_ready(actual: BoardState) -> Refused {
    Reason::NotReady.because(BoardState::Off as i64, actual as i64)
}

/// The state as the host is told.
pub(crate) fn board_state(state: State, situation: Situation) -> BoardState {
    let Situation {
        inputs,
        axes,
        is_powered,
        ..
    } = situation;
    match state {
        State::Locked => BoardState::Locked,
        State::Stopped => BoardState::StopOpen,
        _ if axes.faulted => BoardState::Faulted,
        State::GettingReady => BoardState::GettingReady,
        State::On | State::Running if axes.streaming => BoardState::Enabled,
        State::On | State::Running => BoardState::GettingReady,
        State::Starting => BoardState::Off,
        State::Off | State::Released if is_powered && axes.ready => BoardState::Halted,
        State::Off | State::Released if is_powered => BoardState::Stopping,
        State::Off | State::Released if !inputs.enable => BoardState::EnableInactive,
        State::Off | State::Released => BoardState::Off,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::CYCLE_US;
    use crate::supervisor::Action;

    const CLOSED: Inputs = Inputs {
        stop_closed: true,
        enable: true,
        run: false,
    };
    const READY: Axes = Axes {
        ready: true,
        adoptable: false,
        found_on: false,
        faulted: false,
        clearable: true,
        streaming: false,
        unconfirmed: false,
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
    const SAVE: Command = Command::SaveSettings { length: 1 };

    fn situation(inputs: Inputs, axes: Axes) -> Situation {
        Situation {
            inputs,
            axes,
            is_powered: axes.streaming,
            is_storing: false,
        }
    }

    /// The rules and the supervisor behind them.
    struct Machine {
        rules: Rules,
        supervisor: Supervisor,
        /// The supervisor forgot faults by itself.
        has_cleared: bool,
    }

    impl Machine {
        fn started() -> Self {
            let mut machine = Self {
                rules: Rules::default(),
                supervisor: Supervisor::new(false),
                has_cleared: false,
            };
            machine.pass_ms(1_000, situation(CLOSED, READY));
            assert_eq!(machine.supervisor.state(), State::Off);
            machine
        }

        fn enabled() -> Self {
            let mut machine = Self::started();
            assert_eq!(
                machine.take(Command::Enable, situation(CLOSED, READY)),
                None
            );
            machine.pass_ms(2, situation(CLOSED, READY));
            assert_eq!(machine.supervisor.state(), State::On);
            machine.pass_ms(2, situation(CLOSED, STREAMING));
            machine
        }

        fn take(&mut self, command: Command, now: Situation) -> Option<Result<Order, Refused>> {
            self.rules.take(7, command, &mut self.supervisor, now)
        }

        fn reason(&mut self, command: Command, now: Situation) -> Option<Reason> {
            let refused = self.take(command, now)?.err()?;
            refused.reason()
        }

        fn ends(&self, now: Situation) -> Option<Refused> {
            self.rules.ends_homing(self.supervisor.state(), now)
        }

        fn pass_ms(&mut self, ms: u32, now: Situation) {
            for _ in 0..1_000 * ms / CYCLE_US {
                let inputs = self.rules.contacts(&mut self.supervisor, now);
                let action = self.supervisor.update(inputs, now.axes);
                self.has_cleared |= action == Action::Clear;
            }
        }

        fn outcome(&mut self, now: Situation) -> Option<Result<(), Refused>> {
            let outcome = self.rules.outcome(self.supervisor.state(), now);
            outcome.map(|(_, result)| result)
        }
    }

    #[test]
    fn enable_is_answered_when_every_axis_follows() {
        let mut machine = Machine::started();
        let ready = situation(CLOSED, READY);
        assert_eq!(machine.take(Command::Enable, ready), None);
        machine.pass_ms(2, ready);
        assert_eq!(machine.outcome(ready), None);
        assert_eq!(machine.outcome(situation(CLOSED, STREAMING)), Some(Ok(())));
        assert_eq!(machine.outcome(situation(CLOSED, STREAMING)), None);
    }

    #[test]
    fn inputs_forbid_enable_and_end_it() {
        let open = Inputs {
            stop_closed: false,
            ..CLOSED
        };
        let inactive = Inputs {
            enable: false,
            ..CLOSED
        };
        for (inputs, reason, state) in [
            (open, Reason::StopInput, State::Stopped),
            (inactive, Reason::EnableInput, State::Off),
        ] {
            let mut machine = Machine::started();
            let forbidden = situation(inputs, READY);
            assert_eq!(machine.reason(Command::Enable, forbidden), Some(reason));
            let mut machine = Machine::enabled();
            machine.pass_ms(1, situation(inputs, STREAMING));
            assert_eq!(machine.supervisor.state(), state);
            machine.pass_ms(2_000, situation(CLOSED, READY));
            assert_eq!(
                machine.supervisor.state(),
                State::Off,
                "not by the input alone"
            );
        }
    }

    #[test]
    fn an_input_that_is_opened_on_the_way_is_the_reason() {
        let mut machine = Machine::started();
        assert_eq!(
            machine.take(Command::Enable, situation(CLOSED, READY)),
            None
        );
        let inactive = Inputs {
            enable: false,
            ..CLOSED
        };
        machine.pass_ms(1, situation(inactive, READY));
        let refused = machine
            .outcome(situation(inactive, READY))
            .unwrap()
            .unwrap_err();
        assert_eq!(refused.reason(), Some(Reason::EnableInput));
    }

    #[test]
    fn faults_are_cleared_by_name_and_never_on_the_way() {
        let mut machine = Machine::enabled();
        let faulted = situation(CLOSED, FAULTED);
        machine.pass_ms(10, faulted);
        assert_eq!(machine.supervisor.state(), State::Released);
        assert_eq!(
            machine.reason(Command::Enable, faulted),
            Some(Reason::Faulted)
        );
        assert_eq!(
            machine.take(Command::Clear, faulted),
            Some(Ok(Order::Clear))
        );
        assert_eq!(
            machine.take(Command::Enable, situation(CLOSED, READY)),
            None
        );
        // One that comes on the way ends the attempt.
        machine.pass_ms(1, faulted);
        machine.pass_ms(5, faulted);
        assert!(!machine.has_cleared);
        let refused = machine.outcome(faulted).unwrap().unwrap_err();
        assert_eq!(refused.reason(), Some(Reason::Faulted));
    }

    #[test]
    fn after_halt_enable_must_be_commanded() {
        let mut machine = Machine::enabled();
        let streaming = situation(CLOSED, STREAMING);
        assert_eq!(
            machine.take(Command::Halt, streaming),
            Some(Ok(Order::Halt))
        );
        machine.pass_ms(1_000, situation(CLOSED, READY));
        assert_eq!(machine.supervisor.state(), State::Released);
        let holding = Situation {
            is_powered: true,
            ..situation(CLOSED, READY)
        };
        let state = machine.supervisor.state();
        assert_eq!(board_state(state, holding), BoardState::Halted);
        let slowing = Axes {
            ready: false,
            ..READY
        };
        let slows_down = Situation {
            axes: slowing,
            ..holding
        };
        assert_eq!(board_state(state, slows_down), BoardState::Stopping);
        assert_eq!(
            machine.take(Command::Enable, situation(CLOSED, READY)),
            None
        );
        machine.pass_ms(2, situation(CLOSED, READY));
        assert_eq!(machine.supervisor.state(), State::On);
    }

    #[test]
    fn axes_that_the_master_has_stopped_are_enabled_by_name() {
        let mut machine = Machine::enabled();
        let holding = Situation {
            is_powered: true,
            ..situation(CLOSED, READY)
        };
        machine.pass_ms(5, holding);
        assert_eq!(machine.supervisor.state(), State::Released);
        let state = machine.supervisor.state();
        assert_eq!(board_state(state, holding), BoardState::Halted);
        assert_eq!(machine.take(Command::Enable, holding), None);
        machine.pass_ms(2, holding);
        assert_eq!(machine.supervisor.state(), State::On);
    }

    #[test]
    fn a_locked_machine_refuses_everything() {
        let mut machine = Machine {
            rules: Rules::default(),
            supervisor: Supervisor::new(true),
            has_cleared: false,
        };
        for command in [
            Command::Enable,
            Command::Disable,
            Command::Stop,
            Command::Halt,
            Command::Clear,
            Command::Home,
            SAVE,
        ] {
            let reason = machine.reason(command, situation(CLOSED, READY));
            assert_eq!(reason, Some(Reason::Locked), "{command:?}");
        }
    }

    /// Only while every axis follows; with the reason of the input, the fault or the state.
    #[test]
    fn the_axes_are_homed_only_while_they_are_enabled_and_each_state_says_why_not() {
        let streaming = situation(CLOSED, STREAMING);
        let mut machine = Machine::enabled();
        assert_eq!(
            machine.take(Command::Home, streaming),
            Some(Ok(Order::Home))
        );
        assert_eq!(machine.ends(streaming), None);
        let open = Inputs {
            stop_closed: false,
            ..CLOSED
        };
        let inactive = Inputs {
            enable: false,
            ..CLOSED
        };
        let not_enabled = |state: BoardState| {
            let (enabled, is) = (BoardState::Enabled as i64, state as i64);
            Reason::NotEnabled.because(enabled, is)
        };
        let faulted = Reason::Faulted.because(BoardState::Off as i64, BoardState::Faulted as i64);
        for (inputs, axes, expected) in [
            (open, STREAMING, Reason::StopInput.plain()),
            (inactive, STREAMING, Reason::EnableInput.plain()),
            (CLOSED, FAULTED, faulted),
            // An axis that does not follow any more, for whatever reason.
            (CLOSED, READY, not_enabled(BoardState::GettingReady)),
        ] {
            let now = situation(inputs, axes);
            let mut machine = Machine::enabled();
            assert_eq!(machine.take(Command::Home, now), Some(Err(expected)));
            assert_eq!(machine.ends(now), Some(expected));
        }
        let mut machine = Machine::started();
        let off = not_enabled(BoardState::Off);
        let ready = situation(CLOSED, READY);
        assert_eq!(machine.take(Command::Home, ready), Some(Err(off)));
        machine.take(Command::Enable, ready);
        machine.pass_ms(1, situation(CLOSED, Axes::default()));
        let getting_ready = not_enabled(BoardState::GettingReady);
        let waiting = situation(CLOSED, Axes::default());
        assert_eq!(
            machine.take(Command::Home, waiting),
            Some(Err(getting_ready))
        );
        // After a halt the axes may follow for a cycle more.
        let mut machine = Machine::enabled();
        machine.take(Command::Halt, streaming);
        let stopping = not_enabled(BoardState::Stopping);
        assert_eq!(machine.take(Command::Home, streaming), Some(Err(stopping)));
        assert_eq!(machine.ends(streaming), Some(stopping));
        machine.pass_ms(1_000, ready);
        assert_eq!(machine.take(Command::Home, ready), Some(Err(off)));
    }

    #[test]
    fn a_stop_is_handed_on_in_every_state_but_that_of_a_failure() {
        for mut machine in [Machine::started(), Machine::enabled()] {
            let now = situation(CLOSED, STREAMING);
            assert_eq!(machine.take(Command::Stop, now), Some(Ok(Order::Stop)));
        }
    }

    #[test]
    fn settings_are_stored_only_while_nothing_is_enabled_and_nothing_is_enabled_meanwhile() {
        let mut machine = Machine::started();
        let ready = situation(CLOSED, READY);
        assert_eq!(machine.take(SAVE, ready), Some(Ok(Order::Store)));
        let storing = Situation {
            is_storing: true,
            ..ready
        };
        assert_eq!(machine.reason(Command::Enable, storing), Some(Reason::Busy));
        let mut machine = Machine::enabled();
        let streaming = situation(CLOSED, STREAMING);
        assert_eq!(machine.reason(SAVE, streaming), Some(Reason::Enabled));
        let found_on = Axes {
            found_on: true,
            ..READY
        };
        let mut machine = Machine::started();
        assert_eq!(
            machine.reason(SAVE, situation(CLOSED, found_on)),
            Some(Reason::Enabled)
        );
    }
}
