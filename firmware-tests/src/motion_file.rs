//! A motion file as a host sends it: its rows as segments, and the counts of every cycle, worked out apart from the board.

use std::fs;
use std::path::Path;

use board_link::segment::{AxisSegment, Segment, Shape};
use trajectory::curve::{Chord, Piece, Share};
use trajectory::{Position, Time};

/// Command counts of a turn of the motors, gear number 4096.
const COUNTS_PER_TURN: f64 = 16_384.0;
const UNITS: f64 = Position::UNITS as f64;

/// The rows of a file: milliseconds, and degrees of each motor.
#[derive(Debug, Clone, PartialEq)]
pub struct MotionFile {
    times_ms: Vec<u32>,
    /// Of each axis, in counts from its first row.
    counts: Vec<Vec<f64>>,
}

impl MotionFile {
    /// Reads a file with a column of seconds and columns of degrees, and comments behind `#`.
    ///
    /// # Panics
    /// When it is none.
    #[must_use]
    pub fn read(path: &Path) -> Self {
        let text = fs::read_to_string(path).expect("a motion file");
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let axes = lines.next().expect("a header").split(',').count() - 1;
        let (mut times_ms, mut counts) = (Vec::new(), vec![Vec::new(); axes]);
        for line in lines {
            let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
            times_ms.push((cells[0] * 1_000.0).round() as u32);
            for (axis, degrees) in counts.iter_mut().zip(&cells[1..]) {
                axis.push(degrees * COUNTS_PER_TURN / 360.0);
            }
        }
        for axis in &mut counts {
            let first = axis[0];
            axis.iter_mut().for_each(|value| *value -= first);
        }
        Self { times_ms, counts }
    }

    /// Milliseconds of it.
    #[must_use]
    pub fn duration_ms(&self) -> u32 {
        self.times_ms[self.times_ms.len() - 1] - self.times_ms[0]
    }

    /// As segments, from where the axes stand.
    #[must_use]
    pub fn segments(&self, stand: &[i32]) -> Vec<Segment> {
        let slopes: Vec<Vec<f32>> = self.counts.iter().map(|axis| self.slopes(axis)).collect();
        let rows = 0..self.times_ms.len() - 1;
        let segment = |row: usize| {
            let ms = self.times_ms[row + 1] - self.times_ms[row];
            let axis = |axis: usize| {
                let [leaving, arriving] = [row, row + 1]
                    .map(|row| units(f64::from(slopes[axis][row]) * f64::from(ms) * 1e-3));
                AxisSegment {
                    end: (i64::from(stand[axis]) << 24) + units(self.counts[axis][row + 1]),
                    shape: Shape::Cubic { leaving, arriving },
                }
            };
            Segment {
                duration: Time::from_cycles(ms).ticks(),
                axes: (0..self.counts.len()).map(axis).collect(),
            }
        };
        rows.map(segment).collect()
    }

    /// Counts of each axis from the first row on, in each cycle of a millisecond: as `motionctl run` sends them.
    #[must_use]
    pub fn rows(&self) -> Vec<Vec<i32>> {
        let of_axis = |counts: &Vec<f64>| self.of_every_ms(counts);
        let axes: Vec<Vec<i32>> = self.counts.iter().map(of_axis).collect();
        let row = |ms: usize| axes.iter().map(|axis| axis[ms]).collect();
        (0..axes[0].len()).map(row).collect()
    }

    fn of_every_ms(&self, counts: &[f64]) -> Vec<i32> {
        let slopes = self.slopes(counts);
        let mut all = Vec::new();
        for row in 0..counts.len() - 1 {
            let ms = self.times_ms[row + 1] - self.times_ms[row];
            let [leaving, arriving] = [slopes[row], slopes[row + 1]]
                .map(|slope| Position::from_units(units(f64::from(slope) * f64::from(ms) * 1e-3)));
            let [from, to] =
                [counts[row], counts[row + 1]].map(|at| Position::from_units(units(at)));
            let piece = Piece::cubic(from, to, leaving, arriving);
            let at = |at: u32| piece.at(Share::of(at.into(), ms.into())).units() as f64 / UNITS;
            all.extend((0..ms).map(|ms| at(ms).round() as i32));
        }
        all.push(counts[counts.len() - 1].round() as i32);
        all
    }

    /// Counts per second in each row.
    fn slopes(&self, counts: &[f64]) -> Vec<f32> {
        let chord = |row: usize| {
            let width_s = f64::from(self.times_ms[row + 1] - self.times_ms[row]) * 1e-3;
            Chord {
                duration: width_s as f32,
                velocity: ((counts[row + 1] - counts[row]) / width_s) as f32,
            }
        };
        let chords: Vec<Chord> = (0..counts.len() - 1).map(chord).collect();
        let inner = chords
            .windows(2)
            .map(|pair| pair[0].velocity_before(pair[1]));
        let ends = std::iter::once(0.0);
        ends.clone().chain(inner).chain(ends).collect()
    }
}

fn units(counts: f64) -> i64 {
    (counts * UNITS).round() as i64
}
