//! The points of a motion file: the times and positions that were chosen, each with the line that it came from.
//!
//! The file is read once, line by line; only what was chosen is kept.

use std::io::BufRead;

use super::columns::{ColumnChoice, Columns};
use super::error::TrajectoryError;
use super::lines::Lines;
use super::reader::Reader;
use super::unit::TimeUnit;

/// How to read a file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reading {
    pub(crate) choice: ColumnChoice,
    /// Unit of the time column, when it was given.
    pub(crate) time_unit: Option<TimeUnit>,
    pub(crate) decimal_comma: bool,
    /// A longer motion is not meant.
    pub(crate) most_duration_s: f64,
    /// More times and positions are no motion.
    pub(crate) most_numbers: usize,
}

/// What was read.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Table {
    pub(super) columns: Columns,
    pub(super) time_unit: TimeUnit,
    /// Seconds since the first point.
    pub(super) times_s: Vec<f64>,
    /// Line of each point.
    pub(super) lines: Vec<u64>,
    /// Positions of each point, axis by axis.
    pub(super) positions: Vec<f64>,
}

impl Table {
    /// Reads comma, semicolon, tab or blank separated numbers. `#` and `%` begin comment lines; a first line of words is the
    /// header, and so is the last comment in front of the numbers when it names a time and as many columns as there are.
    pub(crate) fn read(input: impl BufRead, reading: &Reading) -> Result<Self, TrajectoryError> {
        let mut lines = Lines::new(input);
        let mut reader = Reader::new(reading);
        while let Some((number, line)) = lines.next()? {
            let text = line.trim();
            if text.starts_with(['#', '%']) {
                reader.comment(number, &line)?;
            } else if !text.is_empty() {
                reader.take(number, &line)?;
            }
        }
        reader.finish()
    }

    /// Number of points, at least two.
    pub(super) fn points(&self) -> usize {
        self.times_s.len()
    }

    /// The positions of one point.
    pub(super) fn row(&self, point: usize) -> &[f64] {
        let axes = self.columns.positions.len();
        &self.positions[point * axes..(point + 1) * axes]
    }

    /// Numbers for which memory is held.
    #[cfg(test)]
    pub(super) fn held(&self) -> usize {
        self.positions.capacity()
    }

    /// The positions of one axis, point by point.
    pub(super) fn axis(&self, axis: usize) -> impl Iterator<Item = f64> + '_ {
        let axes = self.columns.positions.len();
        self.positions.iter().skip(axis).step_by(axes).copied()
    }
}

#[cfg(test)]
mod tests;
