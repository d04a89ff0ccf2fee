//! The options that say what to move: a motion file, its columns and units, and the drive of each axis.

use core::fmt;
use std::path::PathBuf;

use clap::ValueEnum;
use dyn_can::{DriveId, GearNumber, StepLimit};
use zlac8030l::NodeId;

use crate::drive_ids::{DriveSet, drive_set};

use super::{AxisScale, ColumnChoice, Columns, Interpolation, Plan, Table, TrajectoryError, Unit};

/// The motion that runs when no file is given.
const EXAMPLE: &str = include_str!("../../../../examples/pick-and-place.csv");
const EXAMPLE_NAME: &str = "examples/pick-and-place.csv";

/// The speeds that wheels follow when no file is given.
const WHEEL_EXAMPLE: &str = include_str!("../../../../examples/differential-drive.csv");
const WHEEL_EXAMPLE_NAME: &str = "examples/differential-drive.csv";

/// What to move.
#[derive(Debug, clap::Args)]
pub(crate) struct MotionOptions {
    /// Motion file: time and one position an axis in each line, separated by commas, semicolons, tabs or spaces. The
    /// motion starts where the drives stand. Without it the built-in pick-and-place runs.
    #[arg(long, value_name = "FILE")]
    trajectory: Option<PathBuf>,
    /// Position columns: names from the header line, numbers from 1, or ranges as in 2-7.
    #[arg(long, value_name = "COLUMN", value_delimiter = ',')]
    columns: Vec<String>,
    /// Number of axes, taken from the left. Default: every column but time, less columns that are velocities.
    #[arg(long, value_name = "N")]
    axes: Option<usize>,
    /// Time column: a name or a number from 1. Default: the first.
    #[arg(long, value_name = "COLUMN")]
    time_column: Option<String>,
    /// Unit of the time column.
    #[arg(long, value_enum, default_value_t)]
    time_unit: TimeUnit,
    /// Unit of the positions.
    #[arg(long, value_enum, default_value_t)]
    unit: Unit,
    /// Motor turns for one turn of the output, one for all axes or one each; negative reverses.
    #[arg(
        long,
        value_name = "RATIO",
        value_delimiter = ',',
        default_value = "1",
        value_parser = scale_factor,
        allow_hyphen_values = true
    )]
    gear_ratio: Vec<f64>,
    /// Command counts of one motor turn, one for all axes or one each: 4 times the drive's gear number.
    #[arg(
        long,
        value_name = "COUNTS",
        value_delimiter = ',',
        default_value = "16384",
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

/// Unit of the time column.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
enum TimeUnit {
    /// Seconds.
    #[default]
    S,
    /// Milliseconds.
    Ms,
    /// Microseconds.
    Us,
}

impl TimeUnit {
    /// One unit in seconds.
    const fn seconds(self) -> f64 {
        match self {
            Self::S => 1.0,
            Self::Ms => 1e-3,
            Self::Us => 1e-6,
        }
    }
}

/// A motion file that was read, with the columns that it moves.
#[derive(Debug)]
pub(crate) struct MotionFile<'a> {
    options: &'a MotionOptions,
    table: Table,
    columns: Columns,
}

impl MotionOptions {
    /// The nodes of hub motors, when they are to be driven.
    pub(crate) fn hub_motors(&self) -> Option<&[NodeId]> {
        match &self.drives {
            Some(DriveSet::Zlac(nodes)) => Some(nodes),
            Some(DriveSet::Dyn(_)) | None => None,
        }
    }

    /// The built-in example and its name.
    fn example(&self) -> (&'static str, &'static str) {
        match self.hub_motors() {
            Some(_) => (WHEEL_EXAMPLE, WHEEL_EXAMPLE_NAME),
            None => (EXAMPLE, EXAMPLE_NAME),
        }
    }

    /// Reads the file and finds its columns.
    pub(crate) fn read(&self) -> Result<MotionFile<'_>, MotionError> {
        let text = match &self.trajectory {
            Some(path) => std::fs::read_to_string(path).map_err(|source| MotionError::Read {
                path: path.clone(),
                source,
            })?,
            None => self.example().0.to_owned(),
        };
        let choice = ColumnChoice {
            time: self.time_column.clone(),
            positions: self.columns.clone(),
            axes: self.axes,
        };
        let table = Table::parse(&text).map_err(|source| self.in_file(source))?;
        let columns = Columns::choose(&choice, &table).map_err(|source| self.in_file(source))?;
        Ok(MotionFile {
            options: self,
            table,
            columns,
        })
    }

    fn in_file(&self, source: TrajectoryError) -> MotionError {
        let path = self.trajectory.as_ref().map_or_else(
            || self.example().1.to_owned(),
            |path| path.display().to_string(),
        );
        MotionError::Trajectory { path, source }
    }

    fn scales(&self, axes: usize) -> Result<Vec<AxisScale>, TrajectoryError> {
        let gear_ratios = for_each_axis("--gear-ratio", &self.gear_ratio, axes)?;
        let counts = for_each_axis("--counts-per-turn", &self.counts_per_turn, axes)?;
        let scale = |(&gear_ratio, &counts_per_turn): (&f64, &f64)| AxisScale {
            unit: self.unit,
            gear_ratio,
            counts_per_turn,
        };
        Ok(gear_ratios.iter().zip(&counts).map(scale).collect())
    }
}

impl MotionFile<'_> {
    /// Number of axes that move.
    pub(crate) fn axes(&self) -> usize {
        self.columns.positions.len()
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

    /// The gear number of the drive of each axis: a quarter of the counts of a turn.
    pub(crate) fn gear_numbers(&self) -> Result<Vec<GearNumber>, MotionError> {
        let counts = for_each_axis(
            "--counts-per-turn",
            &self.options.counts_per_turn,
            self.axes(),
        )
        .map_err(|source| self.options.in_file(source))?;
        let gear = |counts: f64| {
            let number = counts / 4.0;
            let is_whole = number.fract() == 0.0 && (0.0..=65_535.0).contains(&number);
            let gear = is_whole
                .then(|| GearNumber::new(number as i32).ok())
                .flatten();
            gear.ok_or(MotionError::CountsPerTurn { actual: counts })
        };
        counts.into_iter().map(gear).collect()
    }

    /// The positions at every cycle, checked against the step that each axis can follow.
    pub(crate) fn plan(&self, cycle_us: u32, max_step: StepLimit) -> Result<Plan, MotionError> {
        let (options, axes) = (self.options, self.axes());
        let in_file = |source| options.in_file(source);
        Plan::new(
            &self.table,
            &self.columns,
            &options.scales(axes).map_err(in_file)?,
            options.time_unit.seconds(),
            options.interpolation,
            cycle_us,
            &vec![max_step; axes],
        )
        .map_err(in_file)
    }

    /// Speeds of wheels at every cycle, in 1/n r/min; the columns are r/min, at rest in the beginning and in the end.
    pub(crate) fn speeds(&self, cycle_us: u32, speed_resolution: u16) -> Result<Plan, MotionError> {
        let ends = [self.table.rows.first(), self.table.rows.last()];
        for row in ends.into_iter().flatten() {
            let speeds = self
                .columns
                .positions
                .iter()
                .map(|&column| row.values[column]);
            if let Some(rpm) = speeds.into_iter().find(|rpm| *rpm != 0.0) {
                return Err(MotionError::NotAtRest {
                    line: row.line,
                    rpm,
                });
            }
        }
        let scale = AxisScale {
            unit: Unit::Turns,
            gear_ratio: 1.0,
            counts_per_turn: speed_resolution.into(),
        };
        Plan::new(
            &self.table,
            &self.columns,
            &vec![scale; self.axes()],
            self.options.time_unit.seconds(),
            Interpolation::Linear,
            cycle_us,
            &vec![StepLimit::MAX; self.axes()],
        )
        .map_err(|source| self.options.in_file(source))
    }

    /// What the user may not expect of the choice of columns.
    pub(crate) fn note(&self) -> Option<String> {
        let velocities = &self.columns.velocities;
        let first = velocities.first()? + 1;
        let last = first + velocities.len() - 1;
        Some(format!(
            "note: columns {first} to {last} are the velocities of the others and are not driven"
        ))
    }
}

/// A factor that neither loses nor invents a motion.
fn scale_factor(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(factor) if factor.is_finite() && factor != 0.0 => Ok(factor),
        _ => Err("expected a finite number other than 0".to_owned()),
    }
}

/// One value for all axes, or one each.
fn for_each_axis(
    what: &'static str,
    values: &[f64],
    axes: usize,
) -> Result<Vec<f64>, TrajectoryError> {
    match values {
        [all] => Ok(vec![*all; axes]),
        each if each.len() == axes => Ok(each.to_vec()),
        _ => Err(TrajectoryError::ListLength {
            what,
            expected: axes,
            actual: values.len(),
        }),
    }
}

/// Options that make no motion.
#[derive(Debug)]
pub(crate) enum MotionError {
    /// The file cannot be read.
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The motion is not usable.
    Trajectory {
        path: String,
        source: TrajectoryError,
    },
    /// The number of drive ids, of which there are 63, is not the number of axes.
    DriveCount { expected: usize, actual: usize },
    /// No gear number makes so many counts of a turn.
    CountsPerTurn { actual: f64 },
    /// Hub motors were asked for where servo drives are moved.
    HubMotors,
    /// Wheels do not stand in the first or the last line.
    NotAtRest { line: u64, rpm: f64 },
}

impl fmt::Display for MotionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, source } => write!(f, "cannot read {}: {source}", path.display()),
            Self::Trajectory { path, source } => write!(f, "{path}: {source}"),
            Self::CountsPerTurn { actual } => write!(
                f,
                "--counts-per-turn must be 4 times the gear number of the drive, 2000..=65536, got {actual}"
            ),
            Self::HubMotors => f.write_str(
                "hub motors follow speeds on a bus of their own: use `motionctl sim --drives zlac`",
            ),
            Self::NotAtRest { line, rpm } => write!(
                f,
                "line {line}: wheels start and end at rest, the speed is {rpm} r/min and must be 0"
            ),
            Self::DriveCount { expected, actual } => write!(
                f,
                "--drives: expected {expected} ids for {expected} axes, got {actual}"
            ),
        }
    }
}

impl std::error::Error for MotionError {}
