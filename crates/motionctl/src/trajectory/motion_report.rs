//! What a motion is about to do, before anything moves: which columns, how far, how fast, and what of it is near a limit.

use crate::counted::counted;
use crate::output::tell;
use crate::program::ProgramReport;
use core::fmt;

use comfy_table::Table as TextTable;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use dyn_can::{Counts28, StepLimit};
use schemars::JsonSchema;
use serde::Serialize;

use super::columns::Column;
use super::error::duration;
use super::plan::Peaks;
use super::unit::{AxisScale, TimeUnit, Unit};
use super::{Plan, Table};

/// Share of a limit above which a value is near it.
const NEAR: f64 = 0.8;
/// Rated speed of the motors in the drive's manual (DYN2, section on gear numbers).
const RATED_RPM: f64 = 3_000.0;

/// A motion in figures.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum MotionReport {
    File(FileReport),
    Program(ProgramReport),
}

/// A motion file in figures.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct FileReport {
    file: String,
    points: usize,
    duration_s: f64,
    time: TimeColumn,
    axes: Vec<AxisReport>,
    /// Columns that are not read.
    left_out: Vec<LeftOut>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct TimeColumn {
    /// From 1.
    column: usize,
    name: String,
    unit: TimeUnit,
}

#[derive(Debug, Serialize, JsonSchema)]
struct LeftOut {
    column: usize,
    name: String,
    reason: &'static str,
}

/// One axis.
#[derive(Debug, Serialize, JsonSchema)]
struct AxisReport {
    axis: usize,
    /// Drive or node.
    drive: u8,
    column: usize,
    name: String,
    unit: Unit,
    /// Furthest values from the start, in the unit.
    lowest: f64,
    highest: f64,
    /// Of the motor; of the wheel for hub motors.
    peak_rpm: f64,
    peak_rpm_per_s: f64,
    /// What is near a limit or beyond what is usual.
    near: Vec<String>,
}

impl FileReport {
    pub(super) fn new(
        file: String,
        table: &Table,
        plan: &Plan,
        scales: &[AxisScale],
        drives: &[u8],
        limit: StepLimit,
    ) -> Self {
        let columns = &table.columns;
        let axes = columns.positions.iter().zip(scales).zip(plan.peaks());
        Self {
            file,
            points: table.points(),
            duration_s: table.times_s[table.points() - 1],
            time: TimeColumn {
                column: columns.time.label.number,
                name: columns.time.label.name.clone(),
                unit: table.time_unit,
            },
            axes: axes
                .zip(drives)
                .enumerate()
                .map(|(axis, (((column, scale), peaks), &drive))| {
                    AxisReport::new(axis, drive, column, scale, peaks, limit)
                })
                .collect(),
            left_out: columns
                .left_out
                .iter()
                .map(|(label, reason)| LeftOut {
                    column: label.number,
                    name: label.name.clone(),
                    reason,
                })
                .collect(),
        }
    }
}

impl MotionReport {
    /// Shows the motion where progress is shown; a terminal that is gone is no reason to stop.
    pub(crate) fn show(&self) {
        tell(self);
    }
}

impl AxisReport {
    fn new(
        axis: usize,
        drive: u8,
        column: &Column,
        scale: &AxisScale,
        peaks: &Peaks,
        limit: StepLimit,
    ) -> Self {
        let per_unit = scale.counts_per_unit();
        let ends = [peaks.lowest / per_unit, peaks.highest / per_unit];
        let is_wheel = scale.unit == Unit::Rpm;
        // The "position" of a wheel is its speed: its first difference is the acceleration.
        let (peak_rpm, peak_rpm_per_s) = if is_wheel {
            let fastest = ends[0].abs().max(ends[1].abs());
            (fastest, peaks.counts_per_s / per_unit.abs())
        } else {
            let rpm = |counts_per_s: f64| counts_per_s * 60.0 / scale.counts_per_turn.abs();
            (rpm(peaks.counts_per_s), rpm(peaks.counts_per_s2))
        };
        let mut near = Vec::new();
        if !is_wheel {
            near_limits(&mut near, peaks, limit, peak_rpm);
        }
        Self {
            axis,
            drive,
            column: column.label.number,
            name: column.label.name.clone(),
            unit: scale.unit,
            lowest: ends[0].min(ends[1]),
            highest: ends[0].max(ends[1]),
            peak_rpm,
            peak_rpm_per_s,
            near,
        }
    }
}

fn near_limits(near: &mut Vec<String>, peaks: &Peaks, limit: StepLimit, rpm: f64) {
    let step = f64::from(peaks.step) / f64::from(limit.get());
    if step >= NEAR {
        near.push(format!(
            "{:.0} % of the largest step, {} counts in a cycle",
            100.0 * step,
            limit.get()
        ));
    }
    let travel = peaks.highest.max(-peaks.lowest) / f64::from(Counts28::MAX.get());
    if travel >= NEAR {
        near.push(format!("{:.0} % of the 28-bit travel", 100.0 * travel));
    }
    if rpm > RATED_RPM {
        near.push(format!(
            "above {RATED_RPM:.0} r/min, the rated speed of most motors"
        ));
    } else if rpm >= NEAR * RATED_RPM {
        near.push(format!(
            "{:.0} % of {RATED_RPM:.0} r/min",
            100.0 * rpm / RATED_RPM
        ));
    }
}

impl fmt::Display for MotionReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(report) => report.fmt(f),
            Self::Program(report) => report.fmt(f),
        }
    }
}

impl fmt::Display for FileReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = |number: usize, name: &str| {
            if name.is_empty() {
                format!("column {number}")
            } else {
                name.to_owned()
            }
        };
        writeln!(
            f,
            "{}: {}, {}; time is {} in {}",
            self.file,
            counted(self.points, "point", "points"),
            duration(self.duration_s),
            name(self.time.column, &self.time.name),
            self.time.unit
        )?;
        let mut table = TextTable::new();
        table.load_style(UTF8_BORDERS_ONLY).set_header([
            "axis",
            "drive",
            "column",
            "travel from the start",
            "peak speed\nr/min",
            "peak acceleration\nr/min/s",
            "near a limit",
        ]);
        for axis in &self.axes {
            table.add_row([
                axis.axis.to_string(),
                axis.drive.to_string(),
                name(axis.column, &axis.name),
                travel(axis),
                format!("{:.1}", axis.peak_rpm),
                format!("{:.0}", axis.peak_rpm_per_s),
                axis.near.join("; "),
            ]);
        }
        write!(f, "{table}")?;
        for left in &self.left_out {
            let what = name(left.column, &left.name);
            write!(f, "\nnot driven: {what} ({})", left.reason)?;
        }
        Ok(())
    }
}

fn travel(axis: &AxisReport) -> String {
    let short = |value: f64| {
        // Without a minus in front of zero.
        let rounded = (value * 1e3).round() / 1e3 + 0.0;
        rounded.to_string()
    };
    format!(
        "{} to {} {}",
        short(axis.lowest),
        short(axis.highest),
        axis.unit
    )
}

/// A result together with the motion that led to it, for JSON.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct WithMotion<'a, T> {
    pub(crate) motion: &'a MotionReport,
    #[serde(flatten)]
    pub(crate) result: &'a T,
}
