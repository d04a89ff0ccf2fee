//! The application of the board: axes that are where their set-points are.

use std::collections::VecDeque;

use board_link::board::{Application, Command, Machine};
use board_link::message::{AxisSnapshot, BoardState, Event, FaultEntry, Info, Origin};
use board_link::segment::Player;
use board_link::{Reason, Refused};

use super::{MOST_AXES, Made};

const SETTINGS_ROOM: usize = 2_048;
const FAULTS_KEPT: usize = 32;
const COMMANDS: usize = 4;
/// A homing takes so long.
const HOMING_US: u32 = 200_000;

/// What a start leaves to the next one.
#[derive(Clone)]
pub(super) struct Kept {
    pub(super) targets: Vec<i32>,
    pub(super) fault_log: Vec<FaultEntry>,
    /// The settings that count from the next start on.
    pub(super) settings: Vec<u8>,
}

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
    /// Those in force, and those of the next start.
    settings: Vec<u8>,
    stored: Vec<u8>,
    staging: Vec<u8>,
    fault_log: Vec<FaultEntry>,
    /// Where the axes that are to be homed find their origins, and whether they have.
    origins: Vec<Option<i32>>,
    is_homed: bool,
    /// The command to home, and the cycles that are left of it.
    homing: Option<(u16, u32)>,
}

impl Axes {
    pub(super) fn new(made: &Made, boot: u32, kept: Kept) -> Self {
        Self {
            state: BoardState::Off,
            faults: vec![0; kept.targets.len()],
            targets: kept.targets,
            is_stop_open: false,
            is_enable_inactive: false,
            boot,
            cycle_us: made.cycle_us,
            commands: VecDeque::new(),
            results: VecDeque::new(),
            events: VecDeque::new(),
            settings: kept.settings.clone(),
            stored: kept.settings,
            staging: vec![0; SETTINGS_ROOM],
            fault_log: kept.fault_log,
            origins: made.origins.clone(),
            is_homed: false,
            homing: None,
        }
    }

    pub(super) fn kept(&self) -> Kept {
        Kept {
            targets: self.targets.clone(),
            fault_log: self.fault_log.clone(),
            settings: self.stored.clone(),
        }
    }

    /// Ends a homing early.
    fn end_homing(&mut self, why: Refused) {
        if let Some((ticket, _)) = self.homing.take() {
            let axis = self.origins.iter().position(Option::is_some);
            let axis = why.axis.or(axis.map(|axis| axis as u8));
            self.results
                .push_back((ticket, Err(Refused { axis, ..why })));
            if self.state == BoardState::Homing {
                self.enter(BoardState::Enabled);
            }
        }
    }

    /// One cycle of a homing; axes that are found are there.
    fn home(&mut self) {
        let Some((ticket, cycles)) = self.homing else {
            return;
        };
        if cycles > 0 {
            self.homing = Some((ticket, cycles - 1));
            return;
        }
        self.homing = None;
        self.is_homed = true;
        for (axis, (target, origin)) in self.targets.iter_mut().zip(&self.origins).enumerate() {
            if let Some(counts) = *origin {
                *target = counts;
                self.events.push_back(Event::Homed {
                    axis: axis as u8,
                    counts,
                    uncertainty: 0,
                });
            }
        }
        self.results.push_back((ticket, Ok(())));
        self.enter(BoardState::Enabled);
    }

    fn begin_homing(&mut self, ticket: u16) -> Result<(), Refused> {
        match self.state {
            BoardState::StopOpen => return Err(Reason::StopInput.plain()),
            BoardState::EnableInactive => return Err(Reason::EnableInput.plain()),
            BoardState::Enabled => {}
            state => return Err(not_enabled(state)),
        }
        if self.origins.iter().all(Option::is_none) {
            return Err(Reason::NoHoming.plain());
        }
        self.is_homed = false;
        self.homing = Some((ticket, HOMING_US / self.cycle_us));
        self.enter(BoardState::Homing);
        Ok(())
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
            self.end_homing(Reason::StopInput.plain());
            self.enter(BoardState::StopOpen);
        } else if self.is_enable_inactive {
            self.end_homing(Reason::EnableInput.plain());
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
            match self.carry_out(ticket, command, player) {
                // Its result comes when it ends.
                Ok(()) if command == Command::Home => {}
                result => self.results.push_back((ticket, result)),
            }
        }
        self.home();
        if self.state != BoardState::Enabled {
            player.halt();
        }
        if !matches!(self.state, BoardState::Enabled | BoardState::Homing) {
            self.is_homed = false;
        }
    }

    fn carry_out(
        &mut self,
        ticket: u16,
        command: Command,
        player: &mut Player<'_, MOST_AXES>,
    ) -> Result<(), Refused> {
        match command {
            Command::Enable => self.enable(),
            Command::Disable => {
                self.end_homing(Reason::HomeStopped.plain());
                player.halt();
                if matches!(self.state, BoardState::Enabled | BoardState::Halted) {
                    self.enter(BoardState::Off);
                }
                Ok(())
            }
            Command::Stop => {
                self.end_homing(Reason::HomeStopped.plain());
                Ok(())
            }
            Command::Halt => {
                self.end_homing(Reason::HomeStopped.plain());
                player.halt();
                // The axes follow nothing any more until they are enabled again.
                if self.state == BoardState::Enabled {
                    self.enter(BoardState::Halted);
                }
                Ok(())
            }
            Command::Clear => {
                self.faults.fill(0);
                if self.state == BoardState::Faulted {
                    self.enter(BoardState::Off);
                }
                Ok(())
            }
            Command::Home => self.begin_homing(ticket),
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
        if matches!(self.state, BoardState::Enabled | BoardState::Halted) {
            return Err(Reason::Enabled.plain());
        }
        let bytes = self.staging.get(..length as usize);
        self.stored = bytes.map(<[u8]>::to_vec).unwrap_or_default();
        Ok(())
    }

    pub(super) fn fail(&mut self, (axis, code, detail): (u8, u16, i32), uptime_ms: u32) {
        if let Some(fault) = self.faults.get_mut(usize::from(axis)) {
            *fault = code;
        }
        self.end_homing(Reason::Faulted.at(axis.into(), 0, code.into()));
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
    const HOMES: bool = true;

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

    fn origin(&mut self, axis: usize) -> Origin {
        match self.origins.get(axis).copied().flatten() {
            None => Origin::OfDrive,
            Some(_) if !self.is_homed => Origin::Unknown,
            Some(counts) => Origin::Found {
                counts,
                uncertainty: 0,
            },
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
