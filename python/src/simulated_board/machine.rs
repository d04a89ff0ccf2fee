//! The application of the board: axes that are where their set-points are.

use std::collections::VecDeque;

use board_link::board::{Application, Command, Machine};
use board_link::message::{AxisSnapshot, BoardState, Event, FaultEntry, Info};
use board_link::segment::Player;
use board_link::{Reason, Refused};

use super::{MOST_AXES, Made};

const SETTINGS_ROOM: usize = 2_048;
const FAULTS_KEPT: usize = 32;
const COMMANDS: usize = 4;

pub(super) struct Axes {
    pub(super) state: BoardState,
    pub(super) targets: Vec<i32>,
    faults: Vec<u16>,
    pub(super) is_stop_open: bool,
    pub(super) is_enable_inactive: bool,
    boot: u32,
    cycle_us: u32,
    commands: VecDeque<(u16, Command)>,
    results: VecDeque<(u16, Result<(), Refused>)>,
    events: VecDeque<Event>,
    settings: Vec<u8>,
    staging: Vec<u8>,
    pub(super) fault_log: Vec<FaultEntry>,
}

impl Axes {
    pub(super) fn new(made: &Made, boot: u32, targets: Vec<i32>, log: Vec<FaultEntry>) -> Self {
        Self {
            state: BoardState::Off,
            faults: vec![0; targets.len()],
            targets,
            is_stop_open: false,
            is_enable_inactive: false,
            boot,
            cycle_us: made.cycle_us,
            commands: VecDeque::new(),
            results: VecDeque::new(),
            events: VecDeque::new(),
            settings: made.settings.clone(),
            staging: vec![0; SETTINGS_ROOM],
            fault_log: log,
        }
    }

    fn enter(&mut self, state: BoardState) {
        if self.state != state {
            self.state = state;
            self.events.push_back(Event::State(state));
        }
    }

    /// The inputs rule, then the commands in their order.
    pub(super) fn before_cycle(&mut self, player: &mut Player<'_, MOST_AXES>) {
        if self.is_stop_open {
            self.enter(BoardState::StopOpen);
        } else if self.is_enable_inactive {
            self.enter(BoardState::EnableInactive);
        } else if matches!(
            self.state,
            BoardState::StopOpen | BoardState::EnableInactive
        ) {
            let is_faulted = self.faults.iter().any(|fault| *fault != 0);
            self.enter(if is_faulted {
                BoardState::Faulted
            } else {
                BoardState::Off
            });
        }
        while let Some((ticket, command)) = self.commands.pop_front() {
            let result = self.carry_out(command, player);
            self.results.push_back((ticket, result));
        }
        if self.state != BoardState::Enabled {
            player.halt();
        }
    }

    fn carry_out(
        &mut self,
        command: Command,
        player: &mut Player<'_, MOST_AXES>,
    ) -> Result<(), Refused> {
        match command {
            Command::Enable => self.enable(),
            Command::Disable => {
                player.halt();
                if matches!(self.state, BoardState::Enabled | BoardState::GettingReady) {
                    self.enter(BoardState::Off);
                }
                Ok(())
            }
            Command::Stop => Ok(()),
            Command::Halt => {
                player.halt();
                Ok(())
            }
            Command::Clear => {
                self.faults.fill(0);
                if self.state == BoardState::Faulted {
                    self.enter(BoardState::Off);
                }
                Ok(())
            }
            Command::Home => match self.state {
                BoardState::Enabled => Ok(()),
                state => Err(not_enabled(state)),
            },
            Command::SaveSettings { length } => self.save(length),
        }
    }

    fn enable(&mut self) -> Result<(), Refused> {
        match self.state {
            BoardState::StopOpen => Err(Reason::StopInput.plain()),
            BoardState::EnableInactive => Err(Reason::EnableInput.plain()),
            BoardState::Faulted => {
                let axis = self.faults.iter().position(|fault| *fault != 0);
                let code = axis.and_then(|axis| self.faults.get(axis)).copied();
                Err(Reason::Faulted.at(axis.unwrap_or(0), 0, code.unwrap_or(0).into()))
            }
            _ => {
                self.enter(BoardState::Enabled);
                Ok(())
            }
        }
    }

    fn save(&mut self, length: u32) -> Result<(), Refused> {
        if self.state == BoardState::Enabled {
            return Err(Reason::Enabled.plain());
        }
        let bytes = self.staging.get(..length as usize);
        self.settings = bytes.map(<[u8]>::to_vec).unwrap_or_default();
        Ok(())
    }

    pub(super) fn fail(&mut self, (axis, code, detail): (u8, u16, i32), uptime_ms: u32) {
        if let Some(fault) = self.faults.get_mut(usize::from(axis)) {
            *fault = code;
        }
        let axis = Some(axis);
        self.events.push_back(Event::Fault { axis, code, detail });
        self.enter(BoardState::Faulted);
        let number = self.fault_log.first().map_or(0, |latest| latest.number) + 1;
        let entry = FaultEntry {
            number,
            boot: self.boot,
            uptime_ms,
            firmware: firmware(),
            axis,
            code,
            detail,
            ..FaultEntry::default()
        };
        self.fault_log.insert(0, entry);
        self.fault_log.truncate(FAULTS_KEPT);
    }
}

fn not_enabled(state: BoardState) -> Refused {
    Reason::NotEnabled.because(BoardState::Enabled as i64, state as i64)
}

fn firmware() -> board_link::message::Text {
    env!("CARGO_PKG_VERSION").try_into().unwrap_or_default()
}

impl Application for Axes {
    fn info(&self) -> Info {
        Info {
            board: "simulated".try_into().unwrap_or_default(),
            firmware: firmware(),
            boot: self.boot,
            cycle_us: self.cycle_us,
            settings: SETTINGS_ROOM as u32,
            faults: self.fault_log.len() as u32,
            ..Info::default()
        }
    }

    fn post(&mut self, ticket: u16, command: Command) -> Result<(), Refused> {
        if self.commands.len() >= COMMANDS {
            return Err(Reason::Busy.because(COMMANDS as i64, COMMANDS as i64 + 1));
        }
        self.commands.push_back((ticket, command));
        Ok(())
    }

    fn result(&mut self) -> Option<(u16, Result<(), Refused>)> {
        self.results.pop_front()
    }

    fn machine(&mut self) -> Machine {
        let axes = self.targets.iter().zip(&self.faults);
        Machine {
            state: self.state,
            axes: axes
                .map(|(&target, &fault)| AxisSnapshot {
                    target,
                    position: target,
                    error: 0,
                    fault,
                })
                .collect(),
            late_cycles: 0,
        }
    }

    fn event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    fn settings(&self) -> &[u8] {
        &self.settings
    }

    fn staging(&mut self) -> &mut [u8] {
        &mut self.staging
    }

    fn check_settings(&mut self, _length: u32) -> Result<(), Refused> {
        Ok(())
    }

    fn fault(&mut self, index: u32) -> Option<FaultEntry> {
        self.fault_log.get(index as usize).cloned()
    }
}
