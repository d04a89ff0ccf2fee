//! The options that say what to move: a motion file, its columns and units, and the drive of each axis.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use dyn_can::{DriveId, GearNumber, StepLimit};
use zlac8030l::NodeId;

use crate::drive_ids::{DriveSet, drive_set};
use crate::recording::AxisAbout;

use super::motion_error::MotionError;
use super::resolve;
use super::table::Reading;
use super::unit::{AxisScale, TimeUnit, Unit};
use super::{ColumnChoice, Interpolation, MotionReport, Plan, Table, TrajectoryError};

/// The motion that runs when no file is given.
const EXAMPLE: &str = include_str!("../../../../examples/pick-and-place.csv");
const EXAMPLE_NAME: &str = "examples/pick-and-place.csv";

/// The speeds that wheels follow when no file is given.
const WHEEL_EXAMPLE: &str = include_str!("../../../../examples/differential-drive.csv");
const WHEEL_EXAMPLE_NAME: &str = "examples/differential-drive.csv";

/// Command counts of one motor turn with the gear number that the drives come with.
const FACTORY_COUNTS_PER_TURN: f64 = 16_384.0;

/// Most times and positions of a motion: an hour of three axes at 1 kHz, 134 MB.
const MOST_NUMBERS: usize = 1 << 24;

/// What to move.
#[derive(Debug, clap::Args)]
pub(crate) struct MotionOptions {
    /// Motion file: time and one position an axis in each line, separated by commas, semicolons, tabs or blanks, with a header
    /// line of names. The motion starts where the drives stand. Without it the built-in pick-and-place runs.
    #[arg(long, value_name = "FILE")]
    trajectory: Option<PathBuf>,
    /// Position columns: names from the header line, numbers from 1, or ranges as in 2-7. Default: the columns whose names say
    /// so; speeds, torques, counters and the like are left out and shown.
    #[arg(long, value_name = "COLUMN", value_delimiter = ',')]
    columns: Vec<String>,
    /// Number of axes, taken from the left.
    #[arg(long, value_name = "N", value_parser = axis_count)]
    axes: Option<usize>,
    /// Time column: a name or a number from 1. Default: the one that is named t, time, stamp ...
    #[arg(long, value_name = "COLUMN")]
    time_column: Option<String>,
    /// Unit of the time column. Default: the one in its name, as in time_ms, or seconds.
    #[arg(long, value_enum)]
    time_unit: Option<TimeUnit>,
    /// Unit of the positions, one for all axes or one each. Default: the one in the name of the column, as in x_mm, or degrees.
    #[arg(long, value_enum, value_delimiter = ',')]
    unit: Vec<Unit>,
    /// Millimetres for one turn of the output, one for all axes or one each, - for those that are not in millimetres: the pitch
    /// (the lead, with several starts) of a screw, the circumference of a pinion or a pulley.
    #[arg(
        long,
        visible_alias = "pitch-mm",
        value_name = "MM",
        value_delimiter = ',',
        value_parser = factor_or_dash,
        allow_hyphen_values = true
    )]
    mm_per_turn: Vec<Option<f64>>,
    /// The numbers have decimal commas.
    #[arg(long)]
    decimal_comma: bool,
    /// Seconds that a motion may last; a longer one is refused.
    #[arg(long, value_name = "S", default_value = "3600", value_parser = seconds)]
    max_duration: f64,
    /// Motor turns for one turn of the output, one for all axes or one each; negative reverses. Default: 1.
    #[arg(
        long,
        value_name = "RATIO",
        value_delimiter = ',',
        value_parser = scale_factor,
        allow_hyphen_values = true
    )]
    gear_ratio: Vec<f64>,
    /// Command counts of one motor turn, one for all axes or one each: 4 times the drive's gear number. Default: 16384.
    #[arg(
        long,
        value_name = "COUNTS",
        value_delimiter = ',',
        value_parser = scale_factor
    )]
    counts_per_turn: Vec<f64>,
    /// How to go from point to point.
    #[arg(long, value_enum, default_value_t)]
    interpolation: Interpolation,
    /// Drive ids in the order of the axes: numbers and ranges, as in 9,1-3. Default: 1, 2, 3 ... Or hub motors, whose columns
    /// are speeds in r/min: zlac for nodes 4, 5 ..., zlac:7,9 for others.
    #[arg(long, value_name = "IDS", value_parser = drive_set)]
    drives: Option<DriveSet>,
}

/// A motion file that was read, with the columns that it moves.
#[derive(Debug)]
pub(crate) struct MotionFile<'a> {
    options: &'a MotionOptions,
    table: Table,
    /// One an axis; empty for wheels, whose scale their drives set.
    scales: Vec<AxisScale>,
}

impl MotionOptions {
    /// The nodes of hub motors, when they are to be driven.
    pub(crate) fn hub_motors(&self) -> Option<&[NodeId]> {
        match &self.drives {
            Some(DriveSet::Zlac(nodes)) => Some(nodes),
            Some(DriveSet::Dyn(_)) | None => None,
        }
    }

    /// The motion file, when one is given.
    pub(crate) fn file(&self) -> Option<&Path> {
        self.trajectory.as_deref()
    }

    /// The built-in example and its name.
    fn example(&self) -> (&'static str, &'static str) {
        match self.hub_motors() {
            Some(_) => (WHEEL_EXAMPLE, WHEEL_EXAMPLE_NAME),
            None => (EXAMPLE, EXAMPLE_NAME),
        }
    }

    /// Reads the file, finds its columns and their units.
    pub(crate) fn read(&self) -> Result<MotionFile<'_>, MotionError> {
        let table = self.table()?;
        let columns = &table.columns.positions;
        let scales = if self.hub_motors().is_some() {
            self.check_options_of_wheels()?;
            resolve::check_speeds(columns).map(|()| Vec::new())
        } else {
            resolve::position_units(&self.unit, columns).and_then(|units| {
                let or_default = |given: &[f64], default| match given {
                    [] => vec![default],
                    given => given.to_vec(),
                };
                resolve::scales(
                    &units,
                    columns,
                    &or_default(&self.gear_ratio, 1.0),
                    &or_default(&self.counts_per_turn, FACTORY_COUNTS_PER_TURN),
                    &self.mm_per_turn,
                )
            })
        };
        let scales = scales.map_err(|source| self.in_file(source))?;
        Ok(MotionFile {
            options: self,
            table,
            scales,
        })
    }

    fn table(&self) -> Result<Table, MotionError> {
        let reading = Reading {
            choice: ColumnChoice {
                time: self.time_column.clone(),
                positions: self.columns.clone(),
                axes: self.axes,
                speeds: self.hub_motors().is_some(),
            },
            time_unit: self.time_unit,
            decimal_comma: self.decimal_comma,
            most_duration_s: self.max_duration,
            most_numbers: MOST_NUMBERS,
        };
        let table = match &self.trajectory {
            Some(path) => {
                let file = File::open(path).map_err(|source| MotionError::Read {
                    path: path.clone(),
                    source,
                })?;
                Table::read(BufReader::new(file), &reading)
            }
            None => Table::read(self.example().0.as_bytes(), &reading),
        };
        table.map_err(|source| self.in_file(source))
    }

    /// Options that a speed of a wheel does not have.
    fn check_options_of_wheels(&self) -> Result<(), MotionError> {
        let given = [
            (!self.unit.is_empty(), "--unit"),
            (!self.mm_per_turn.is_empty(), "--mm-per-turn"),
            (!self.gear_ratio.is_empty(), "--gear-ratio"),
            (!self.counts_per_turn.is_empty(), "--counts-per-turn"),
        ];
        match given.iter().find(|(is_given, _)| *is_given) {
            Some((_, option)) => Err(MotionError::NotForWheels { option }),
            None => Ok(()),
        }
    }

    fn file_name(&self) -> String {
        self.trajectory.as_ref().map_or_else(
            || self.example().1.to_owned(),
            |path| path.display().to_string(),
        )
    }

    fn in_file(&self, source: TrajectoryError) -> MotionError {
        let path = self.file_name();
        MotionError::Trajectory { path, source }
    }
}

impl MotionFile<'_> {
    /// Number of axes that move.
    pub(crate) fn axes(&self) -> usize {
        self.table.columns.positions.len()
    }

    /// The drive of each axis.
    pub(crate) fn drives(&self) -> Result<Vec<DriveId>, MotionError> {
        let axes = self.axes();
        let drives: Vec<DriveId> = match &self.options.drives {
            Some(DriveSet::Dyn(drives)) => drives.clone(),
            Some(DriveSet::Zlac(_)) => return Err(MotionError::HubMotors),
            None => DriveId::all().take(axes).collect(),
        };
        if drives.len() != axes {
            return Err(MotionError::DriveCount {
                expected: axes,
                actual: drives.len(),
            });
        }
        Ok(drives)
    }

    /// Name, unit and scale of each axis, for a recording.
    pub(crate) fn axes_about(&self, drives: &[DriveId]) -> Vec<AxisAbout> {
        let start = self.table.row(0);
        let columns = self.table.columns.positions.iter().zip(&self.scales);
        let axes = columns.zip(drives).zip(start);
        axes.map(|(((column, scale), drive), &start)| AxisAbout {
            name: match column.label.name.as_str() {
                "" => format!("column {}", column.label.number),
                name => name.to_owned(),
            },
            unit: scale.unit.to_string(),
            counts_per_unit: scale.counts_per_unit(),
            start,
            ..AxisAbout::of_drive(*drive)
        })
        .collect()
    }

    /// The gear number of the drive of each axis: a quarter of the counts of a turn.
    pub(crate) fn gear_numbers(&self) -> Result<Vec<GearNumber>, MotionError> {
        let gear = |counts: f64| {
            let number = counts / 4.0;
            let is_whole = number.fract() == 0.0 && (0.0..=65_535.0).contains(&number);
            let gear = is_whole
                .then(|| GearNumber::new(number as i32).ok())
                .flatten();
            gear.ok_or(MotionError::CountsPerTurn { actual: counts })
        };
        let counts = self.scales.iter().map(|scale| scale.counts_per_turn.abs());
        counts.map(gear).collect()
    }

    /// The positions at every cycle, checked against the step that each axis can follow.
    pub(crate) fn plan(&self, cycle_us: u32, max_step: StepLimit) -> Result<Plan, MotionError> {
        Plan::new(
            &self.table,
            &self.scales,
            self.options.interpolation,
            cycle_us,
            &vec![max_step; self.axes()],
        )
        .map_err(|source| self.options.in_file(source))
    }

    /// What the motion is about to do.
    pub(crate) fn report(
        &self,
        plan: &Plan,
        drives: &[DriveId],
        max_step: StepLimit,
    ) -> MotionReport {
        let drives: Vec<u8> = drives.iter().map(|drive| drive.get()).collect();
        let file = self.options.file_name();
        MotionReport::new(file, &self.table, plan, &self.scales, &drives, max_step)
    }

    /// Speeds of wheels at every cycle, in 1/n r/min; the columns are r/min, at rest in the beginning and in the end.
    pub(crate) fn speeds(&self, cycle_us: u32, speed_resolution: u16) -> Result<Plan, MotionError> {
        for point in [0, self.table.points() - 1] {
            if let Some(&rpm) = self.table.row(point).iter().find(|rpm| **rpm != 0.0) {
                return Err(MotionError::NotAtRest {
                    path: self.options.file_name(),
                    line: self.table.lines[point],
                    rpm,
                });
            }
        }
        Plan::new(
            &self.table,
            &self.wheel_scales(speed_resolution),
            Interpolation::Linear,
            cycle_us,
            &vec![StepLimit::MAX; self.axes()],
        )
        .map_err(|source| self.options.in_file(source))
    }

    /// What wheels are about to do.
    pub(crate) fn wheel_report(
        &self,
        plan: &Plan,
        nodes: &[NodeId],
        speed_resolution: u16,
    ) -> MotionReport {
        let nodes: Vec<u8> = nodes.iter().map(|node| node.get()).collect();
        let scales = self.wheel_scales(speed_resolution);
        let file = self.options.file_name();
        MotionReport::new(file, &self.table, plan, &scales, &nodes, StepLimit::MAX)
    }

    fn wheel_scales(&self, speed_resolution: u16) -> Vec<AxisScale> {
        let scale = AxisScale {
            unit: Unit::Rpm,
            gear_ratio: 1.0,
            counts_per_turn: speed_resolution.into(),
            mm_per_turn: 1.0,
        };
        vec![scale; self.axes()]
    }
}

/// A factor that neither loses nor invents a motion.
fn scale_factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(factor) if factor.is_finite() && factor != 0.0 => Ok(factor),
        _ => Err("expected a finite number other than 0".to_owned()),
    }
}

/// A factor of an axis, or a dash where there is none.
fn factor_or_dash(text: &str) -> Result<Option<f64>, String> {
    match text {
        "-" => Ok(None),
        text => scale_factor(text).map(Some),
    }
}

fn axis_count(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(count) if count > 0 => Ok(count),
        _ => Err("expected a number of axes from 1".to_owned()),
    }
}

/// Most seconds of a motion: a day.
const MOST_SECONDS: f64 = 86_400.0;

fn seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds <= MOST_SECONDS => Ok(seconds),
        _ => Err(format!("expected seconds above 0 and up to {MOST_SECONDS}")),
    }
}
