//! The dry run: the whole program, before anything moves.

use std::cell::RefCell;
use std::collections::VecDeque;

use dyn_can::{Counts28, StepLimit};
use trajectory::Position;

use super::error::ProgramFileError;
use super::machine::{MOST_MOTORS, Machine};
use super::player::{Player, Row};
use super::source::ProgramFile;

/// The largest values of one axis, in command counts and cycles.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Peaks {
    pub(crate) step: u16,
    pub(crate) lowest: i32,
    pub(crate) highest: i32,
}

/// A program that was played to its end.
#[derive(Debug)]
pub(crate) struct Checked {
    file: ProgramFile,
    machine: Machine,
    /// Of the motors.
    names: Vec<String>,
    pub(crate) cycles: usize,
    pub(crate) lines: u32,
    pub(crate) moves: usize,
    pub(crate) peaks: Vec<Peaks>,
    last: [i32; MOST_MOTORS],
    cursor: RefCell<Option<Cursor>>,
}

/// Rows that are at hand behind the latest: who plays a motion looks some of them ahead, and then at the present one.
const REMEMBERED: usize = 16_384;

/// A reading of the program, and its latest rows.
#[derive(Debug)]
struct Cursor {
    player: Player,
    /// The cycle of the first of the rows.
    first: usize,
    rows: VecDeque<[i32; MOST_MOTORS]>,
}

impl Cursor {
    fn new(player: Player) -> Self {
        Self {
            player,
            first: 0,
            rows: VecDeque::from([[0; MOST_MOTORS]]),
        }
    }

    /// Adds the next row, or the same again where the program has none that `is_checked`.
    fn play_on(&mut self, is_checked: impl Fn([i32; MOST_MOTORS], [i32; MOST_MOTORS]) -> bool) {
        let before = self.rows.back().copied().unwrap_or_default();
        // After an error, the way to rest.
        let next = self.player.next().or_else(|_| self.player.next());
        let row = next.ok().flatten().and_then(in_32_bits);
        let row = row.filter(|row| is_checked(*row, before)).unwrap_or(before);
        if self.rows.len() > REMEMBERED {
            self.rows.pop_front();
            self.first += 1;
        }
        self.rows.push_back(row);
    }
}

impl Checked {
    /// Plays a program and refuses it when an axis goes too far or too fast in a cycle, or when it does not end in time.
    pub(crate) fn new(
        file: ProgramFile,
        machine: Machine,
        names: Vec<String>,
        max_step: StepLimit,
        most_s: f64,
    ) -> Result<Self, ProgramFileError> {
        let mut player = Player::new(file.lines(), &machine)?;
        let most_cycles = (most_s * 1e6 / f64::from(machine.manner.cycle_us)).floor() as usize;
        let mut checked = Self {
            file,
            machine,
            peaks: vec![Peaks::default(); names.len()],
            names,
            // The start is the first row.
            cycles: 1,
            lines: 0,
            moves: 0,
            last: [0; MOST_MOTORS],
            cursor: RefCell::new(None),
        };
        checked.play(&mut player, max_step, most_cycles)?;
        (checked.lines, checked.moves) = (player.line(), player.moves);
        if machine.manner.most_percent > 100 {
            checked.play_fastest(max_step, most_cycles)?;
        }
        Ok(checked)
    }

    /// To its end, with the speed that the player has.
    fn play(
        &mut self,
        player: &mut Player,
        max_step: StepLimit,
        most_cycles: usize,
    ) -> Result<(), ProgramFileError> {
        while let Some(row) = player.next()? {
            if self.cycles > most_cycles {
                let cycle_s = f64::from(self.machine.manner.cycle_us) * 1e-6;
                return Err(ProgramFileError::Long {
                    path: self.file.path.clone(),
                    line: player.line(),
                    most_s: most_cycles as f64 * cycle_s,
                });
            }
            self.note(row, player.line(), max_step)?;
            self.cycles += 1;
        }
        Ok(())
    }

    /// Once more at the highest override, for its peaks alone.
    fn play_fastest(
        &mut self,
        max_step: StepLimit,
        most_cycles: usize,
    ) -> Result<(), ProgramFileError> {
        let (cycles, last) = (self.cycles, self.last);
        (self.cycles, self.last) = (1, [0; MOST_MOTORS]);
        let mut player = self.fastest()?;
        self.play(&mut player, max_step, most_cycles)?;
        (self.cycles, self.last) = (cycles, last);
        Ok(())
    }

    fn fastest(&self) -> Result<Player, ProgramFileError> {
        let mut player = self.player()?;
        player.set_override(self.machine.manner.most_percent);
        Ok(player)
    }

    /// The counts of every cycle at the highest override; they end early where the file cannot be read any more.
    pub(crate) fn fastest_rows(&self) -> impl Iterator<Item = Vec<i32>> + '_ {
        let mut player = self.fastest().ok();
        core::iter::from_fn(move || {
            let row = player.as_mut()?.next().ok()??;
            // The travel has been checked.
            let row = row.map(|counts| i32::try_from(counts).unwrap_or(i32::MAX));
            Some(row.into_iter().take(self.axes()).collect())
        })
    }

    fn note(&mut self, row: Row, line: u32, max_step: StepLimit) -> Result<(), ProgramFileError> {
        let path = || self.file.path.clone();
        let axes = row.iter().zip(&mut self.last).zip(&self.names);
        for (((&counts, last), axis), peaks) in axes.zip(&mut self.peaks) {
            let most = Counts28::MAX.get();
            let position = i32::try_from(counts).ok();
            let Some(position) =
                position.filter(|counts| counts.unsigned_abs() <= most.unsigned_abs())
            else {
                return Err(ProgramFileError::Travel {
                    path: path(),
                    line,
                    axis: axis.clone(),
                    counts,
                    most,
                });
            };
            let step = i64::from(position) - i64::from(*last);
            let allowed = max_step.get();
            match u16::try_from(step.unsigned_abs()) {
                Ok(size) if size <= allowed => peaks.step = peaks.step.max(size),
                _ => {
                    return Err(ProgramFileError::Step {
                        path: path(),
                        line,
                        axis: axis.clone(),
                        counts: step,
                        most: allowed,
                    });
                }
            }
            peaks.lowest = peaks.lowest.min(position);
            peaks.highest = peaks.highest.max(position);
            *last = position;
        }
        Ok(())
    }

    pub(super) fn path(&self) -> &std::path::Path {
        &self.file.path
    }

    /// Its path as SVG.
    pub(crate) fn picture(&self) -> Result<String, ProgramFileError> {
        super::picture::draw(self)
    }

    pub(super) fn player(&self) -> Result<Player, ProgramFileError> {
        Player::new(self.file.lines(), &self.machine)
    }

    pub(crate) fn names(&self) -> &[String] {
        &self.names
    }

    /// Positions in counts at every cycle, the start included, not rounded.
    pub(crate) fn exact_rows(&self) -> Result<Vec<Vec<f64>>, ProgramFileError> {
        let mut player = self.player()?;
        let mut rows = vec![vec![0.0; self.axes()]];
        while let Some(row) = player.next_exact()? {
            let counts = row.map(|at| at.units() as f64 / Position::UNITS as f64);
            rows.push(counts.into_iter().take(self.axes()).collect());
        }
        Ok(rows)
    }

    /// Motors.
    pub(crate) const fn axes(&self) -> usize {
        self.names.len()
    }

    pub(super) const fn machine(&self) -> &Machine {
        &self.machine
    }

    /// The counts at a cycle. The program is played on from the farthest cycle that was asked for; the [`REMEMBERED`] before it are at hand, an
    /// earlier one starts it anew. A file that cannot be read any more, or has been changed in its place, ends where the tool is then, and
    /// its end is not that of the check.
    pub(crate) fn row(&self, cycle: usize) -> Vec<i32> {
        let cycle = cycle.min(self.cycles - 1);
        let mut slot = self.cursor.borrow_mut();
        if slot.as_ref().is_none_or(|cursor| cycle < cursor.first) {
            *slot = self.player().ok().map(Cursor::new);
        }
        let Some(cursor) = slot.as_mut() else {
            return vec![0; self.axes()];
        };
        while cycle >= cursor.first + cursor.rows.len() {
            cursor.play_on(|row, before| self.is_checked(row, before));
        }
        let row = cursor.rows.get(cycle - cursor.first);
        row.into_iter()
            .flatten()
            .copied()
            .take(self.axes())
            .collect()
    }

    /// The counts between two cycles, in a straight line from one to the next; in ascending order too.
    pub(crate) fn between(&self, cycles: f64, counts: &mut [f64]) {
        let (before, after) = (cycles.floor(), cycles.ceil());
        let to = self.row(after as usize);
        let ends = self.row(before as usize).into_iter().zip(to);
        for (counts, (from, to)) in counts.iter_mut().zip(ends) {
            let (from, to) = (f64::from(from), f64::from(to));
            *counts = from + (to - from) * (cycles - before);
        }
    }

    /// Whether a row is one that the check may have seen.
    fn is_checked(&self, row: [i32; MOST_MOTORS], before: [i32; MOST_MOTORS]) -> bool {
        let axes = row.iter().zip(before).zip(&self.peaks);
        axes.into_iter().all(|((&counts, before), peaks)| {
            (peaks.lowest..=peaks.highest).contains(&counts)
                && counts.abs_diff(before) <= u32::from(peaks.step)
        })
    }

    /// Where the check ended.
    pub(crate) fn last(&self) -> Vec<i32> {
        self.last.iter().copied().take(self.axes()).collect()
    }
}

fn in_32_bits(row: Row) -> Option<[i32; MOST_MOTORS]> {
    let mut counts = [0; MOST_MOTORS];
    for (counts, wide) in counts.iter_mut().zip(row) {
        *counts = i32::try_from(wide).ok()?;
    }
    Some(counts)
}
