//! Command counts of every axis at every cycle, worked out when they are needed: a motion takes the memory of its points, not of
//! its duration.

use board_link::segment::{OfAxes, Segment};
use dyn_can::{Counts28, StepLimit};
use trajectory::{Position, Time};

use super::curve::{Curve, Times, counts, position, time};
use super::error::{Place, TrajectoryError};
use super::unit::AxisScale;
use super::{Interpolation, Table};
use crate::program::{Checked, ProgramFileError};
use crate::set_points::MotionInTime;

/// A motion that has been checked: counts from the start of the motion, cycle by cycle.
#[derive(Debug)]
pub(crate) struct Plan {
    source: Source,
    last_cycle: usize,
    peaks: Vec<Peaks>,
    /// The first position of the table, in command counts.
    first_counts: Vec<f64>,
}

/// Where the positions come from.
#[derive(Debug)]
enum Source {
    Curves(Vec<Curve>),
    Program(Box<Checked>),
}

/// The largest values of one axis, in command counts and seconds.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Peaks {
    /// Largest step from one cycle to the next.
    pub(super) step: u16,
    pub(super) counts_per_s: f64,
    pub(super) counts_per_s2: f64,
    /// Furthest positions from the start.
    pub(super) lowest: f64,
    pub(super) highest: f64,
}

impl Plan {
    /// Checks a motion at every cycle.
    pub(crate) fn new(
        table: &Table,
        scales: &[AxisScale],
        interpolation: Interpolation,
        cycle_us: u32,
        limits: &[StepLimit],
    ) -> Result<Self, TrajectoryError> {
        // The duration is limited by whoever read the table.
        let times = Times::new(&table.times_s, cycle_us);
        let last_cycle = times.end().whole_cycles() as usize;
        let mut curves = Vec::with_capacity(scales.len());
        let mut peaks = Vec::with_capacity(scales.len());
        let mut first_counts = Vec::with_capacity(scales.len());
        for (axis, scale) in scales.iter().enumerate() {
            let start = table.row(0)[axis];
            let counts = |value: f64| (value - start) * scale.counts_per_unit();
            for (row, value) in table.axis(axis).enumerate() {
                let place = || Place::cell(table.lines[row], &table.columns.positions[axis].label);
                within_travel(counts(value), &place)?;
            }
            let curve = Curve::new(
                &times,
                table.axis(axis).map(counts).collect(),
                interpolation,
            );
            let of_axis = check(&curve, table, axis, limits[axis], cycle_us, last_cycle)?;
            curves.push(curve);
            peaks.push(of_axis);
            first_counts.push(start * scale.counts_per_unit());
        }
        Ok(Self {
            source: Source::Curves(curves),
            last_cycle,
            peaks,
            first_counts,
        })
    }

    /// A program that was played to its end.
    pub(crate) fn of_program(checked: Checked) -> Self {
        Self {
            last_cycle: checked.cycles - 1,
            first_counts: vec![0.0; checked.axes()],
            source: Source::Program(Box::new(checked)),
            peaks: Vec::new(),
        }
    }

    /// The program, if it is one.
    pub(crate) fn program(&self) -> Option<&Checked> {
        match &self.source {
            Source::Program(checked) => Some(checked),
            Source::Curves(_) => None,
        }
    }

    /// Number of cycles, the one at the start included.
    pub(crate) fn cycles(&self) -> usize {
        self.last_cycle + 1
    }

    /// Positions relative to the first at one cycle, in command counts, axis by axis; behind the last cycle those of the last. Of a program,
    /// ask for cycles in ascending order: an earlier one plays it from its start.
    pub(crate) fn row(&self, cycle: usize) -> Vec<i32> {
        match &self.source {
            Source::Curves(curves) => {
                let time = at_cycle(cycle.min(self.last_cycle));
                // It fits: the plan was checked at this cycle.
                let position = |curve: &Curve| curve.at(time).1.counts();
                curves.iter().map(position).collect()
            }
            Source::Program(checked) => checked.row(cycle),
        }
    }

    /// The rows of all cycles.
    pub(crate) fn rows(&self) -> impl Iterator<Item = Vec<i32>> + '_ {
        (0..self.cycles()).map(|cycle| self.row(cycle))
    }

    /// Positions relative to the first at the end.
    pub(crate) fn last(&self) -> Vec<i32> {
        match &self.source {
            Source::Curves(_) => self.row(self.last_cycle),
            Source::Program(checked) => checked.last(),
        }
    }

    /// The first position of an axis as the file has it, in command counts.
    pub(crate) fn first_counts(&self, axis: usize) -> f64 {
        self.first_counts.get(axis).copied().unwrap_or_default()
    }

    /// The largest step of each axis from one cycle to the next, in command counts.
    pub(crate) fn largest_steps(&self) -> Vec<u16> {
        match &self.source {
            Source::Curves(_) => self.peaks.iter().map(|peaks| peaks.step).collect(),
            Source::Program(checked) => checked.peaks.iter().map(|peaks| peaks.step).collect(),
        }
    }

    /// The pieces of the motion, all axes in the time of each, from the position 0 on; a program has none.
    pub(crate) fn pieces(&self) -> Option<Vec<Segment>> {
        let Source::Curves(curves) = &self.source else {
            return None;
        };
        let durations = curves.first().into_iter().flat_map(Curve::durations);
        let piece = |(place, duration): (usize, Time)| {
            let axes = curves
                .iter()
                .map(|curve| curve.pieces().get(place).copied());
            Some(Segment {
                duration: duration.ticks(),
                // A board has no more axes.
                axes: axes
                    .take(OfAxes::<i64>::new().capacity())
                    .collect::<Option<_>>()?,
            })
        };
        durations.enumerate().map(piece).collect()
    }

    /// Exact positions at every cycle, from the position 0 on.
    pub(crate) fn exact_rows(&self) -> Result<Vec<Vec<Position>>, ProgramFileError> {
        match &self.source {
            Source::Curves(curves) => Ok((0..self.cycles())
                .map(|cycle| {
                    curves
                        .iter()
                        .map(|curve| curve.at(at_cycle(cycle)).1)
                        .collect()
                })
                .collect()),
            Source::Program(checked) => {
                let rows = checked.exact_rows()?.into_iter();
                Ok(rows
                    .map(|row| row.into_iter().map(position).collect())
                    .collect())
            }
        }
    }

    pub(super) fn peaks(&self) -> &[Peaks] {
        &self.peaks
    }
}

impl MotionInTime for Plan {
    fn axes(&self) -> usize {
        match &self.source {
            Source::Curves(curves) => curves.len(),
            Source::Program(checked) => checked.axes(),
        }
    }

    fn duration_cycles(&self) -> f64 {
        self.last_cycle as f64
    }

    fn at(&self, cycles: f64, at: &mut [f64]) {
        let cycles = cycles.clamp(0.0, self.last_cycle as f64);
        match &self.source {
            Source::Curves(curves) => {
                let time = time(cycles);
                for (at, curve) in at.iter_mut().zip(curves) {
                    *at = counts(curve.at(time).1);
                }
            }
            Source::Program(checked) => checked.between(cycles, at),
        }
    }
}

/// Goes through every cycle of one axis.
fn check(
    curve: &Curve,
    table: &Table,
    axis: usize,
    limit: StepLimit,
    cycle_us: u32,
    last_cycle: usize,
) -> Result<Peaks, TrajectoryError> {
    let cycle_s = f64::from(cycle_us) * 1e-6;
    let mut peaks = Peaks::default();
    let (mut before, mut exact_before, mut speed_before) = (0, 0.0, 0.0);
    for cycle in 0..=last_cycle {
        let (point, exact) = curve.at(at_cycle(cycle));
        let value = counts(exact);
        let line = table.lines[(point + 1).min(table.points() - 1)];
        let place = || Place::cell(line, &table.columns.positions[axis].label);
        within_travel(value, &place)?;
        let position = exact.counts();
        let step = i64::from(position) - i64::from(before);
        if step.unsigned_abs() > u64::from(limit.get()) {
            return Err(TrajectoryError::Step {
                place: place(),
                limit_counts: limit.get(),
                actual_counts: step,
                cycle_us,
            });
        }
        let speed = (value - exact_before) / cycle_s;
        let acceleration = (speed - speed_before) / cycle_s;
        peaks.step = peaks
            .step
            .max(u16::try_from(step.unsigned_abs()).unwrap_or(u16::MAX));
        peaks.counts_per_s = peaks.counts_per_s.max(speed.abs());
        peaks.counts_per_s2 = peaks.counts_per_s2.max(acceleration.abs());
        peaks.lowest = peaks.lowest.min(value);
        peaks.highest = peaks.highest.max(value);
        (before, exact_before, speed_before) = (position, value, speed);
    }
    Ok(peaks)
}

/// The duration is limited by whoever read the table.
fn at_cycle(cycle: usize) -> Time {
    Time::from_cycles(u32::try_from(cycle).unwrap_or(u32::MAX))
}

fn within_travel(counts: f64, place: &impl Fn() -> Place) -> Result<i32, TrajectoryError> {
    let rounded = counts.round();
    // Not a number is beyond the travel too.
    if rounded.abs() <= f64::from(Counts28::MAX.get()) {
        return Ok(rounded as i32);
    }
    Err(TrajectoryError::Travel {
        place: place(),
        actual_counts: counts,
    })
}

#[cfg(test)]
mod tests {
    use super::super::ColumnChoice;
    use super::super::table::Reading;
    use super::super::unit::Unit;
    use super::*;

    const ONE_TURN: AxisScale = AxisScale {
        unit: Unit::Degrees,
        gear_ratio: 1.0,
        counts_per_turn: 16_384.0,
        mm_per_turn: 1.0,
    };

    fn plan(text: &str, limit: i32) -> Result<Plan, TrajectoryError> {
        let reading = Reading {
            choice: ColumnChoice::default(),
            time_unit: None,
            decimal_comma: false,
            most_duration_s: 3_600.0,
            most_numbers: 10_000,
        };
        let table = Table::read(format!("t a\n{text}").as_bytes(), &reading)?;
        let limit = StepLimit::new(limit).unwrap();
        Plan::new(&table, &[ONE_TURN], Interpolation::Linear, 1_000, &[limit])
    }

    #[test]
    fn starts_at_zero_and_ends_exactly_at_the_last_point() {
        let plan = plan("5.0 90\n5.1 180\n", 16_384).unwrap();
        assert_eq!(plan.cycles(), 101);
        assert_eq!(plan.row(0), [0]);
        assert_eq!(plan.last(), [4_096]);
        assert_eq!(plan.rows().count(), 101);
    }

    #[test]
    fn a_time_that_is_no_whole_cycle_still_ends_at_the_last_point() {
        let plan = plan("0 0\n0.0105 36\n", 16_384).unwrap();
        assert_eq!((plan.cycles(), plan.last()), (12, vec![1638]));
    }

    #[test]
    fn a_step_may_be_as_large_as_its_limit_and_no_larger() {
        // 0.88 degrees are 40.05 counts, 0.9 degrees 40.96.
        assert_eq!(plan("0 0\n0.001 0.88\n", 40).unwrap().last(), [40]);
        let error = plan("0 0\n0.001 0.9\n", 40).unwrap_err();
        assert!(
            matches!(
                error,
                TrajectoryError::Step {
                    actual_counts: 41,
                    limit_counts: 40,
                    ..
                }
            ),
            "{error}"
        );
    }

    #[test]
    fn peaks_are_those_of_the_motion() {
        let plan = plan("0 0\n1 360\n2 0\n3 -180\n", 16_384).unwrap();
        let peaks = plan.peaks()[0];
        // Speeds of a curve are exact to a few parts in ten million.
        assert!(
            (peaks.counts_per_s - 16_384.0).abs() < 1e-2,
            "{}",
            peaks.counts_per_s
        );
        // The speed changes its sign within one cycle.
        assert!((peaks.counts_per_s2 / (2.0 * 16_384.0 / 1e-3) - 1.0).abs() < 1e-6);
        assert_eq!((peaks.lowest, peaks.highest), (-8_192.0, 16_384.0));
    }

    #[test]
    fn what_the_axis_cannot_follow_names_the_line_that_asks_for_it() {
        let error = plan("0 0\n1 1\n2 1001\n", 40).unwrap_err().to_string();
        assert!(
            error.starts_with("line 4, column 2 (a): the axis would have to move 45 counts in one cycle of 1000 us, its limit is 40"),
            "{error}"
        );
        let error = plan("0 0\n1000 1e9\n", 16_384).unwrap_err();
        assert!(matches!(
            error,
            TrajectoryError::Step { .. } | TrajectoryError::Travel { .. }
        ));
        let error = plan("0 0\n1 1e300\n2 -1e308\n", 16_384).unwrap_err();
        assert!(matches!(
            error,
            TrajectoryError::Step { .. } | TrajectoryError::Travel { .. }
        ));
    }
}
