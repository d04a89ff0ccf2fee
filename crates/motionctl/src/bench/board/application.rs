//! What the protocol asks of the board.

use std::collections::VecDeque;

use board_link::board::{Application, Command, Machine};
use board_link::message::{Event, FaultEntry, Info, Origin, Reason, Refused};
use board_link::segment::OfAxes;
use board_settings::{Board, LONGEST, Settings};

use super::fault_log::FaultLog;

/// What the board says of its firmware.
pub(super) const FIRMWARE: &str = concat!("bench ", env!("CARGO_PKG_VERSION"));
/// Commands that wait for the cycle, as on the boards.
const COMMANDS: usize = 4;

/// What the link and the cycle hand to each other.
pub(super) struct App {
    info: Info,
    built: Board,
    settings: Vec<u8>,
    staging: Vec<u8>,
    pub(super) commands: VecDeque<(u16, Command)>,
    pub(super) results: VecDeque<(u16, Result<(), Refused>)>,
    pub(super) events: VecDeque<Event>,
    pub(super) machine: Machine,
    pub(super) origins: OfAxes<Origin>,
    pub(super) faults: FaultLog,
}

impl App {
    /// After a start.
    pub(super) fn new(built: Board, boot: u32, settings: Vec<u8>, faults: FaultLog) -> Self {
        Self {
            info: Info {
                board: built.name.parse().unwrap_or_default(),
                firmware: FIRMWARE.parse().unwrap_or_default(),
                boot,
                cycle_us: built.cycle_us,
                settings: LONGEST as u32,
                ..Info::default()
            },
            built,
            settings,
            staging: vec![0; LONGEST],
            commands: VecDeque::new(),
            results: VecDeque::new(),
            events: VecDeque::new(),
            machine: Machine::default(),
            origins: OfAxes::new(),
            faults,
        }
    }

    /// The bytes that are to be stored.
    pub(super) fn staged(&self, length: u32) -> &[u8] {
        self.staging.get(..length as usize).unwrap_or_default()
    }
}

impl Application for App {
    const HOMES: bool = true;

    fn info(&self) -> Info {
        Info {
            faults: self.faults.count(),
            ..self.info.clone()
        }
    }

    fn post(&mut self, ticket: u16, command: Command) -> Result<(), Refused> {
        if self.commands.len() >= COMMANDS {
            let (most, count) = (COMMANDS as i64, self.commands.len() as i64 + 1);
            return Err(Reason::Busy.because(most, count));
        }
        self.commands.push_back((ticket, command));
        Ok(())
    }

    fn result(&mut self) -> Option<(u16, Result<(), Refused>)> {
        self.results.pop_front()
    }

    fn machine(&mut self) -> Machine {
        self.machine.clone()
    }

    fn origin(&mut self, axis: usize) -> Origin {
        self.origins.get(axis).copied().unwrap_or_default()
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

    fn check_settings(&mut self, length: u32) -> Result<(), Refused> {
        let settings = Settings::read(self.staged(length))?;
        settings.configs(&self.built)?;
        Ok(())
    }

    fn fault(&mut self, index: u32) -> Option<FaultEntry> {
        self.faults.get(index)
    }
}
