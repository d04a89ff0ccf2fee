//! Plays a program: command counts, cycle by cycle.

use std::collections::VecDeque;

use path::machine::{Cartesian, Scale};
use path::{Path, PathError};
use program::{Action, Interpreter, Move, Settings};
use trajectory::{Limits, Position};

use super::error::ProgramFileError;
use super::source::Lines;

/// Pieces that are planned ahead: many more than on a board, for programs of very short lines.
const QUEUE: usize = 1_024;
const US_PER_MINUTE: f32 = 60e6;
const US_PER_MS: u64 = 1_000;

/// The path in micrometres and three axes; those that the machine does not have stay where they are.
type Tool = Path<Cartesian<3>, 3, 3, QUEUE>;

/// What the player needs to know of the machine.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Machine {
    pub(crate) scales: [Scale; 3],
    pub(crate) limits: [Limits; 3],
    pub(crate) settings: Settings,
    pub(crate) cycle_us: u32,
    pub(crate) skips_pauses: bool,
    /// Highest override, in percent.
    pub(crate) most_percent: u16,
}

/// A program under way.
#[derive(Debug)]
pub(crate) struct Player {
    machine: Machine,
    lines: Lines,
    interpreter: Interpreter,
    /// Actions of the line that was read last.
    actions: VecDeque<Action>,
    tool: Box<Tool>,
    /// Cycles that it still stands once it does.
    dwell: u64,
    waits: bool,
    has_ended: bool,
    pub(crate) moves: usize,
}

impl Player {
    pub(crate) fn new(lines: Lines, machine: &Machine) -> Result<Self, ProgramFileError> {
        let start = machine.settings.start;
        let tool = Tool::new(
            Cartesian {
                scales: machine.scales,
            },
            machine.limits,
            start,
        );
        let mut tool = tool.map_err(|source| ProgramFileError::Path {
            path: lines.path.clone(),
            line: 0,
            source,
        })?;
        tool.set_most_override(machine.most_percent);
        Ok(Self {
            machine: *machine,
            lines,
            interpreter: Interpreter::new(machine.settings),
            actions: VecDeque::new(),
            tool: Box::new(tool),
            dwell: 0,
            waits: false,
            has_ended: false,
            moves: 0,
        })
    }

    /// The latest line that was read.
    pub(crate) fn line(&self) -> u32 {
        self.interpreter.line_number()
    }

    /// Where the tool is, in micrometres.
    pub(crate) fn place(&self) -> [Position; 3] {
        self.tool.place()
    }

    pub(crate) fn pause(&mut self) {
        self.tool.pause();
    }

    pub(crate) fn resume(&mut self) {
        self.tool.resume();
    }

    /// Percent of the feeds.
    pub(crate) fn set_override(&mut self, percent: u16) {
        self.tool.set_override(percent);
    }

    /// Brakes along the path, and gives up the rest of the program.
    pub(crate) fn stop(&mut self) {
        self.tool.stop();
        self.actions.clear();
        self.has_ended = true;
    }

    pub(crate) fn is_at_rest(&self) -> bool {
        self.tool.is_at_rest()
    }

    /// The command counts of the next cycle, relative to the start; `None` once the program has ended and the tool stands.
    ///
    /// After an error the path is what was known of it before: it goes on to its end, at rest.
    pub(crate) fn next(&mut self) -> Result<Option<[i64; 3]>, ProgramFileError> {
        let next = self.cycle();
        if next.is_err() {
            self.has_ended = true;
            self.actions.clear();
        }
        next
    }

    fn cycle(&mut self) -> Result<Option<[i64; 3]>, ProgramFileError> {
        self.feed()?;
        if self.waits && self.tool.is_done() {
            if self.dwell > 0 {
                self.dwell -= 1;
            } else {
                self.waits = false;
                self.feed()?;
            }
        }
        if self.has_ended && !self.waits && self.tool.is_done() {
            return Ok(None);
        }
        Ok(Some(self.tool.advance().map(Position::wide_counts)))
    }

    /// Moves for as long as there is room for them.
    fn feed(&mut self) -> Result<(), ProgramFileError> {
        while !self.waits && self.tool.has_room() {
            match self.actions.pop_front() {
                Some(action) => self.take(action)?,
                None if self.has_ended => return Ok(()),
                None => self.read()?,
            }
        }
        Ok(())
    }

    fn read(&mut self) -> Result<(), ProgramFileError> {
        let path = self.lines.path.clone();
        let Some(text) = self.lines.next()? else {
            self.has_ended = true;
            return Ok(());
        };
        let actions = self
            .interpreter
            .line(text)
            .map_err(|source| ProgramFileError::Program { path, source })?;
        self.actions.extend(actions);
        self.has_ended = self.interpreter.has_ended();
        Ok(())
    }

    fn take(&mut self, action: Action) -> Result<(), ProgramFileError> {
        let cycle_us = self.machine.cycle_us;
        match action {
            Action::Move {
                path,
                feed_um_per_min,
                join,
            } => {
                let feed = feed_um_per_min * cycle_us as f32 / US_PER_MINUTE;
                self.moves += 1;
                let moved = match path {
                    Move::Line(end) => self.tool.line(end, feed, join),
                    Move::Arc(arc) => self.tool.arc(&arc, feed, join),
                };
                moved.map_err(|source| self.unusable(source))
            }
            Action::Dwell { ms } => {
                self.dwell = (u64::from(ms) * US_PER_MS).div_ceil(u64::from(cycle_us));
                self.waits = true;
                Ok(())
            }
            Action::Pause if self.machine.skips_pauses => {
                (self.dwell, self.waits) = (0, true);
                Ok(())
            }
            Action::Pause => Err(ProgramFileError::Pause {
                path: self.lines.path.clone(),
                line: self.line(),
            }),
            Action::End => Ok(()),
        }
    }

    fn unusable(&self, source: PathError) -> ProgramFileError {
        ProgramFileError::Path {
            path: self.lines.path.clone(),
            line: self.line(),
            source,
        }
    }
}
