//! Command counts of every axis at every cycle.

use clap::ValueEnum;
use dyn_can::{Counts28, StepLimit};

use super::curve::Curve;
use super::table::Row;
use super::{Columns, Interpolation, Table, TrajectoryError};

/// Unit of the positions in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum Unit {
    /// Command counts of the drive.
    Counts,
    /// Degrees at the output.
    #[default]
    Degrees,
    /// Turns at the output.
    Turns,
}

/// From the unit of the file to command counts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AxisScale {
    /// Unit of the file.
    pub(crate) unit: Unit,
    /// Motor turns for one turn of the output; negative reverses the direction. Not used with counts.
    pub(crate) gear_ratio: f64,
    /// Command counts of one motor turn. Not used with counts.
    pub(crate) counts_per_turn: f64,
}

impl AxisScale {
    /// Command counts of one unit.
    pub(crate) fn counts_per_unit(&self) -> f64 {
        match self.unit {
            Unit::Counts => 1.0,
            Unit::Degrees => self.gear_ratio * self.counts_per_turn / 360.0,
            Unit::Turns => self.gear_ratio * self.counts_per_turn,
        }
    }
}

/// A motion that has been checked: counts from the start of the motion, one row a cycle.
#[derive(Debug)]
pub(crate) struct Plan {
    /// Positions relative to the first, cycle by cycle; each row has one entry an axis.
    pub(crate) cycles: Vec<Vec<i32>>,
}

impl Plan {
    /// Resamples a table to the cycle.
    ///
    /// `time_scale_s` is one unit of the time column in seconds.
    pub(crate) fn new(
        table: &Table,
        columns: &Columns,
        scales: &[AxisScale],
        time_scale_s: f64,
        interpolation: Interpolation,
        cycle_us: u32,
        limits: &[StepLimit],
    ) -> Result<Self, TrajectoryError> {
        let times_s = times_s(&table.rows, columns.time, time_scale_s)?;
        let duration_s = times_s[times_s.len() - 1];
        let cycle_s = f64::from(cycle_us) * 1e-6;
        let last_cycle = (duration_s / cycle_s).ceil() as usize;
        let mut cycles = vec![Vec::with_capacity(scales.len()); last_cycle + 1];
        for (axis, (&column, scale)) in columns.positions.iter().zip(scales).enumerate() {
            let start = table.rows[0].values[column];
            let counts = |row: &Row| (row.values[column] - start) * scale.counts_per_unit();
            let curve = Curve::new(
                times_s.clone(),
                table.rows.iter().map(counts).collect(),
                interpolation,
            );
            let mut before = 0;
            for (cycle, row) in cycles.iter_mut().enumerate() {
                let (point, value) = curve.at(cycle as f64 * cycle_s);
                let line = table.rows[(point + 1).min(table.rows.len() - 1)].line;
                let position = within_travel(value, line, axis)?;
                check_step(
                    i64::from(position) - before,
                    limits[axis],
                    line,
                    axis,
                    cycle_us,
                )?;
                before = i64::from(position);
                row.push(position);
            }
        }
        Ok(Self { cycles })
    }

    /// Positions relative to the first at the end.
    pub(crate) fn last(&self) -> &[i32] {
        self.cycles.last().map_or(&[], Vec::as_slice)
    }
}

/// Times from the first point on.
fn times_s(rows: &[Row], column: usize, scale_s: f64) -> Result<Vec<f64>, TrajectoryError> {
    if let [only] = rows {
        return Err(TrajectoryError::SinglePoint { line: only.line });
    }
    let start = rows[0].values[column];
    for pair in rows.windows(2) {
        let (before, actual) = (pair[0].values[column], pair[1].values[column]);
        if actual <= before {
            return Err(TrajectoryError::TimeOrder {
                line: pair[1].line,
                before_s: before * scale_s,
                actual_s: actual * scale_s,
            });
        }
    }
    Ok(rows
        .iter()
        .map(|row| (row.values[column] - start) * scale_s)
        .collect())
}

fn within_travel(counts: f64, line: u64, axis: usize) -> Result<i32, TrajectoryError> {
    let rounded = counts.round();
    let limit = f64::from(Counts28::MAX.get());
    if rounded.abs() > limit {
        return Err(TrajectoryError::Travel {
            line,
            axis,
            actual_counts: counts,
        });
    }
    Ok(rounded as i32)
}

fn check_step(
    step: i64,
    limit: StepLimit,
    line: u64,
    axis: usize,
    cycle_us: u32,
) -> Result<(), TrajectoryError> {
    if step.unsigned_abs() > u64::from(limit.get()) {
        return Err(TrajectoryError::Step {
            line,
            axis,
            limit_counts: limit.get(),
            actual_counts: step,
            cycle_us,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::ColumnChoice;
    use super::*;

    const ONE_TURN: AxisScale = AxisScale {
        unit: Unit::Degrees,
        gear_ratio: 1.0,
        counts_per_turn: 16_384.0,
    };

    fn plan(text: &str, limit: i32) -> Result<Plan, TrajectoryError> {
        let table = Table::parse(text)?;
        let columns = Columns::choose(&ColumnChoice::default(), &table)?;
        let scales = vec![ONE_TURN; columns.positions.len()];
        let limits = vec![StepLimit::new(limit).unwrap(); scales.len()];
        Plan::new(
            &table,
            &columns,
            &scales,
            1.0,
            Interpolation::Linear,
            1_000,
            &limits,
        )
    }

    #[test]
    fn starts_at_zero_and_ends_exactly_at_the_last_point() {
        let plan = plan("5.0 90\n5.1 180\n", 16_384).unwrap();
        assert_eq!(plan.cycles.len(), 101);
        assert_eq!(plan.cycles[0], [0]);
        assert_eq!(plan.last(), [4_096]);
    }

    #[test]
    fn a_time_that_is_no_whole_cycle_still_ends_at_the_last_point() {
        let plan = plan("0 0\n0.0105 36\n", 16_384).unwrap();
        assert_eq!((plan.cycles.len(), plan.last()), (12, &[1638][..]));
    }

    #[test]
    fn what_the_axis_cannot_follow_names_the_line_that_asks_for_it() {
        assert_eq!(
            plan("0 0\n1 1\n2 1001\n", 40).unwrap_err(),
            TrajectoryError::Step {
                line: 3,
                axis: 0,
                limit_counts: 40,
                actual_counts: 45,
                cycle_us: 1_000
            }
        );
        assert!(matches!(
            plan("0 0\n1000 1e9\n", 16_384),
            Err(TrajectoryError::Travel {
                line: 2,
                axis: 0,
                ..
            } | TrajectoryError::Step { .. })
        ));
    }

    #[test]
    fn time_must_go_on() {
        assert_eq!(
            plan("0 0\n1 1\n1 2\n", 100).unwrap_err(),
            TrajectoryError::TimeOrder {
                line: 3,
                before_s: 1.0,
                actual_s: 1.0
            }
        );
        assert_eq!(
            plan("0 0\n", 100).unwrap_err(),
            TrajectoryError::SinglePoint { line: 1 }
        );
    }
}
