//! The dry run: the whole program, before anything moves.

use std::cell::RefCell;

use dyn_can::{Counts28, StepLimit};

use super::error::ProgramFileError;
use super::player::{Machine, Player};
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
    axes: usize,
    letters: [char; 3],
    pub(crate) cycles: usize,
    pub(crate) lines: u32,
    pub(crate) moves: usize,
    pub(crate) peaks: Vec<Peaks>,
    last: [i32; 3],
    cursor: RefCell<Option<Cursor>>,
}

/// A reading of the program, and its latest row.
#[derive(Debug)]
struct Cursor {
    player: Player,
    cycle: usize,
    /// Of this cycle and of the one before.
    row: [i32; 3],
    before: [i32; 3],
}

impl Checked {
    /// Plays a program and refuses it when an axis goes too far or too fast in a cycle, or when it does not end in time.
    pub(crate) fn new(
        file: ProgramFile,
        machine: Machine,
        axes: usize,
        max_step: StepLimit,
        most_s: f64,
    ) -> Result<Self, ProgramFileError> {
        let mut player = Player::new(file.lines(), &machine)?;
        let most_cycles = (most_s * 1e6 / f64::from(machine.cycle_us)).floor() as usize;
        let mut checked = Self {
            file,
            machine,
            axes,
            letters: ['X', 'Y', 'Z'],
            // The start is the first row.
            cycles: 1,
            lines: 0,
            moves: 0,
            peaks: vec![Peaks::default(); axes],
            last: [0; 3],
            cursor: RefCell::new(None),
        };
        while let Some(row) = player.next()? {
            if checked.cycles > most_cycles {
                return Err(ProgramFileError::Long {
                    path: checked.file.path.clone(),
                    line: player.line(),
                    most_s,
                });
            }
            checked.note(row, player.line(), max_step)?;
            checked.cycles += 1;
        }
        (checked.lines, checked.moves) = (player.line(), player.moves);
        Ok(checked)
    }

    fn note(
        &mut self,
        row: [i64; 3],
        line: u32,
        max_step: StepLimit,
    ) -> Result<(), ProgramFileError> {
        let path = || self.file.path.clone();
        let axes = row.iter().zip(&mut self.last).zip(self.letters);
        for (((&counts, last), axis), peaks) in axes.zip(&mut self.peaks) {
            let most = Counts28::MAX.get();
            let position = i32::try_from(counts).ok();
            let Some(position) =
                position.filter(|counts| counts.unsigned_abs() <= most.unsigned_abs())
            else {
                return Err(ProgramFileError::Travel {
                    path: path(),
                    line,
                    axis,
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
                        axis,
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

    pub(crate) const fn axes(&self) -> usize {
        self.axes
    }

    pub(super) const fn machine(&self) -> &Machine {
        &self.machine
    }

    /// The counts at a cycle. The program is played on from the cycle that was asked for last; the one before that is remembered, an earlier one starts it anew. A file that
    /// cannot be read any more, or has been changed in its place, ends where the tool is then, and its end is not that of the check.
    pub(crate) fn row(&self, cycle: usize) -> Vec<i32> {
        let mut slot = self.cursor.borrow_mut();
        if slot.as_ref().is_none_or(|cursor| cursor.cycle > cycle + 1) {
            *slot = self.player().ok().map(|player| Cursor {
                player,
                cycle: 0,
                row: [0; 3],
                before: [0; 3],
            });
        }
        let Some(cursor) = slot.as_mut() else {
            return vec![0; self.axes];
        };
        while cursor.cycle < cycle.min(self.cycles - 1) {
            cursor.cycle += 1;
            cursor.before = cursor.row;
            // After an error, the way to rest.
            let next = cursor.player.next().or_else(|_| cursor.player.next());
            if let Ok(Some(row)) = next
                && let [Ok(x), Ok(y), Ok(z)] = row.map(i32::try_from)
                && self.is_checked([x, y, z], cursor.before)
            {
                cursor.row = [x, y, z];
            }
        }
        let row = if cycle < cursor.cycle {
            cursor.before
        } else {
            cursor.row
        };
        row.into_iter().take(self.axes).collect()
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
    fn is_checked(&self, row: [i32; 3], before: [i32; 3]) -> bool {
        let axes = row.iter().zip(before).zip(&self.peaks);
        axes.into_iter().all(|((&counts, before), peaks)| {
            (peaks.lowest..=peaks.highest).contains(&counts)
                && counts.abs_diff(before) <= u32::from(peaks.step)
        })
    }

    /// Where the check ended.
    pub(crate) fn last(&self) -> Vec<i32> {
        self.last.iter().copied().take(self.axes).collect()
    }
}
