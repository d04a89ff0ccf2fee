//! Plays a program: command counts, cycle by cycle.

use std::collections::VecDeque;

use path::machine::Backlash;
use path::{Path, PathError};
use program::{Action, Interpreter, Move};
use trajectory::Position;

use super::error::ProgramFileError;
use super::machine::{COORDINATES, MOST_MOTORS, Machine, Mapping};
use super::source::Lines;

/// Pieces that are planned ahead: many more than on a board, for programs of very short lines.
const QUEUE: usize = 1_024;
const US_PER_MINUTE: f32 = 60e6;
const US_PER_MS: u64 = 1_000;

/// The path in micrometres.
type Tool = Path<Mapping, COORDINATES, MOST_MOTORS, QUEUE>;

/// Command counts of every motor.
pub(crate) type Row = [i64; MOST_MOTORS];

/// A program under way.
#[derive(Debug)]
pub(crate) struct Player {
    machine: Machine,
    lines: Lines,
    interpreter: Interpreter,
    /// Actions of the line that was read last.
    actions: VecDeque<Action>,
    tool: Box<Tool>,
    plays: [Option<Backlash>; MOST_MOTORS],
    /// Cycles that it still stands once it does.
    dwell: u64,
    waits: bool,
    has_ended: bool,
    pub(crate) moves: usize,
}

impl Player {
    pub(crate) fn new(lines: Lines, machine: &Machine) -> Result<Self, ProgramFileError> {
        let start = machine.settings.start;
        let tool = Tool::new(machine.mapping, machine.limits, start);
        let mut tool = tool.map_err(|source| ProgramFileError::Path {
            path: lines.path.clone(),
            line: 0,
            source,
        })?;
        tool.set_most_override(machine.manner.most_percent);
        Ok(Self {
            machine: *machine,
            lines,
            interpreter: Interpreter::new(machine.settings),
            actions: VecDeque::new(),
            tool: Box::new(tool),
            plays: machine.backlashes(),
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
    pub(crate) fn place(&self) -> [Position; COORDINATES] {
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
        self.waits = false;
        self.has_ended = true;
    }

    fn is_at_rest(&self) -> bool {
        self.tool.is_at_rest() && self.plays.iter().flatten().all(Backlash::is_there)
    }

    /// The command counts of the next cycle, relative to the start; `None` once the program has ended and everything stands.
    ///
    /// After an error the path is what was known of it before: it goes on to its end, at rest.
    pub(crate) fn next(&mut self) -> Result<Option<Row>, ProgramFileError> {
        Ok(self.next_exact()?.map(|row| row.map(Position::wide_counts)))
    }

    /// The same, not rounded to counts.
    pub(crate) fn next_exact(
        &mut self,
    ) -> Result<Option<[Position; MOST_MOTORS]>, ProgramFileError> {
        let next = self.cycle();
        if next.is_err() {
            self.has_ended = true;
            self.actions.clear();
        }
        next
    }

    fn cycle(&mut self) -> Result<Option<[Position; MOST_MOTORS]>, ProgramFileError> {
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
            // What runs next starts in the middle of every play, as this program did.
            self.plays.iter_mut().flatten().for_each(Backlash::release);
            if self.is_at_rest() {
                return Ok(None);
            }
        }
        let mut row = self.tool.advance();
        for (position, play) in row.iter_mut().zip(&mut self.plays) {
            if let Some(play) = play {
                let moved = play.apply(*position);
                *position = moved.map_err(|source| ProgramFileError::Backlash {
                    path: self.lines.path.clone(),
                    line: self.interpreter.line_number(),
                    source,
                })?;
            }
        }
        Ok(Some(row))
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
        let cycle_us = self.machine.manner.cycle_us;
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
            Action::Pause if self.machine.manner.skips_pauses => {
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
