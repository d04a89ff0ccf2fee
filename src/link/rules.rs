//! What the inputs and the state of the machine let a command do. The inputs rule: a command only ever asks for what they permit, and what
//! they end must be commanded again.
//!
//! To the supervisor the host is a second contact behind the enable input: its `enable` is active while both are.

use board_link::board::Command;
use board_link::message::BoardState;
use board_link::{Reason, Refused};

use crate::supervisor::{Axes, Inputs, State, Supervisor};

/// What a command has the cycle do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Order {
    /// Nothing at once.
    Nothing,
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
}

/// What counts when a command comes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Situation {
    /// The inputs; enable is active where none is fitted.
    pub(crate) inputs: Inputs,
    /// The axes.
    pub(crate) axes: Axes,
    /// This board has switched a drive on, or moves it.
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
            // A stream slows down by its player; without one nothing moves that would not stop by itself.
            Command::Stop => Ok(Order::Nothing),
            Command::Halt => {
                if matches!(supervisor.state(), State::GettingReady | State::On) {
                    supervisor.refused();
                }
                Ok(Order::Halt)
            }
            Command::Clear => clear(situation),
            Command::Home => Err(Reason::Unsupported.plain()),
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
            State::Off | State::Released if !situation.is_storing => {}
            _ => return Err(not_ready(board_state(state, situation))),
        }
        supervisor.rearm();
        self.is_wanted = true;
        self.enabling = Some(ticket);
        Ok(true)
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
        State::Off | State::Released if is_powered => BoardState::Stopping,
        State::Off | State::Released if !inputs.enable => BoardState::EnableInactive,
        State::Off | State::Released => BoardState::Off,
    }
}
