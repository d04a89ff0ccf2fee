//! The options that say what to move: a motion file, its columns and units, and the drive of each axis.

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use dyn_can::{DriveId, GearNumber, StepLimit};
use zlac8030l::NodeId;

use crate::drive_ids::{DriveSet, drive_set};
use crate::recording::AxisAbout;

use super::axes_about;
use super::columns::{Column, Columns};
use super::layout::{Layout, check_axes};
use super::motion_error::MotionError;
use super::name::Name;
use super::resolve;
use super::table::Reading;
use super::unit::{AxisScale, TimeUnit, Unit};
use super::{ColumnChoice, FileReport, Interpolation, MotionReport, Plan, Table, TrajectoryError};
use crate::program::{
    Axes, MachineSetup, ProgramFile, ProgramFileError, ProgramOptions, ProgramReport,
};

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
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct MotionOptions {
    /// Motion file: time and one position an axis in each line, separated by commas, semicolons, tabs or blanks, with a header
    /// line of names. The motion starts where the drives stand. Without it the built-in pick-and-place runs.
    #[arg(long, value_name = "FILE")]
    pub(crate) trajectory: Option<PathBuf>,
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
    #[command(flatten)]
    pub(crate) program: ProgramOptions,
}

/// A motion that was read, with the axes that it moves.
#[derive(Debug)]
pub(crate) struct MotionFile<'a> {
    options: &'a MotionOptions,
    content: Content,
}

#[derive(Debug)]
enum Content {
    File(FileContent),
    Program {
        file: ProgramFile,
        machine: MachineSetup,
    },
}

#[derive(Debug)]
struct FileContent {
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

    /// The motion file or the program, when one is given.
    pub(crate) fn file(&self) -> Option<&Path> {
        let program = self.program.program.as_deref();
        program.or(self.trajectory.as_deref())
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
        if let Some(path) = &self.program.program {
            if self.hub_motors().is_some() {
                return Err(MotionError::HubMotors);
            }
            let machine = self.program.machine(&self.axes_of_program())?;
            return Ok(MotionFile {
                options: self,
                content: Content::Program {
                    file: ProgramFile::open(path)?,
                    machine,
                },
            });
        }
        let table = self.table()?;
        let columns = &table.columns.positions;
        let scales = if self.hub_motors().is_some() {
            self.check_options_of_wheels()?;
            resolve::check_speeds(columns).map(|()| Vec::new())
        } else {
            self.scales(columns)
        };
        let scales = scales.map_err(|source| self.in_file(source))?;
        Ok(MotionFile {
            options: self,
            content: Content::File(FileContent { table, scales }),
        })
    }

    /// Drives that are streamed to, which must be named: nothing else says how many axes there are.
    pub(crate) fn drives_of_stream(&self) -> Result<Vec<DriveId>, MotionError> {
        match &self.drives {
            Some(DriveSet::Dyn(drives)) => Ok(drives.clone()),
            Some(DriveSet::Zlac(_)) => Err(MotionError::HubMotors),
            None => Err(MotionError::DrivesOfStream),
        }
    }

    /// The gear numbers of so many drives.
    pub(crate) fn gears_of_stream(&self, axes: usize) -> Result<Vec<GearNumber>, MotionError> {
        let all = match self.counts_per_turn[..] {
            [] => vec![FACTORY_COUNTS_PER_TURN; axes],
            [one] => vec![one; axes],
            _ => self.counts_per_turn.clone(),
        };
        if all.len() != axes {
            let source = TrajectoryError::ListLength {
                what: "--counts-per-turn",
                expected: axes,
                actual: all.len(),
            };
            let path = "--stream".to_owned();
            return Err(MotionError::Trajectory { path, source });
        }
        gear_numbers(all.iter().map(|counts| counts.abs()))
    }

    /// The columns of a line of names, for so many axes; `None` when it is no line of names.
    pub(crate) fn layout(
        &self,
        line: u64,
        text: &str,
        axes: usize,
    ) -> Result<Option<Layout>, TrajectoryError> {
        if Layout::has_numbers(text, self.decimal_comma) {
            return Ok(None);
        }
        self.layout_of(line, &Layout::names(text, self.decimal_comma), axes)
            .map(Some)
    }

    /// The same of names that are known one by one.
    pub(crate) fn named_layout(
        &self,
        line: u64,
        names: &[String],
        axes: usize,
    ) -> Result<Layout, TrajectoryError> {
        let names: Vec<Name> = names.iter().map(|name| Name::parse(name)).collect();
        self.layout_of(line, &names, axes)
    }

    fn layout_of(&self, line: u64, names: &[Name], axes: usize) -> Result<Layout, TrajectoryError> {
        let columns = Columns::named(&self.choice(), line, names)?;
        check_axes(line, axes, columns.positions().len())?;
        let time_unit = resolve::time_unit(self.time_unit, columns.time())?;
        let scales = self.scales(columns.positions())?;
        Ok(Layout::new(columns, names.len(), time_unit, scales))
    }

    /// Whether numbers have decimal commas.
    pub(crate) fn decimal_comma(&self) -> bool {
        self.decimal_comma
    }

    fn scales(&self, columns: &[Column]) -> Result<Vec<AxisScale>, TrajectoryError> {
        let units = resolve::position_units(&self.unit, columns)?;
        resolve::scales(
            &units,
            columns,
            &or_default(&self.gear_ratio, 1.0),
            &self.counts_per_turn(),
            &self.mm_per_turn,
        )
    }

    fn choice(&self) -> ColumnChoice {
        ColumnChoice {
            time: self.time_column.clone(),
            positions: self.columns.clone(),
            axes: self.axes,
            speeds: self.hub_motors().is_some(),
        }
    }

    fn table(&self) -> Result<Table, MotionError> {
        let reading = Reading {
            choice: self.choice(),
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

    /// Writes the path of a program as SVG, where a file is asked for.
    pub(crate) fn write_path(&self, plan: &Plan) -> Result<(), MotionError> {
        if let (Some(checked), Some(path)) = (plan.program(), &self.program.path_svg) {
            let written = std::fs::write(path, checked.picture()?);
            written.map_err(|source| ProgramFileError::Write {
                path: path.clone(),
                source,
            })?;
        }
        Ok(())
    }

    fn counts_per_turn(&self) -> Vec<f64> {
        or_default(&self.counts_per_turn, FACTORY_COUNTS_PER_TURN)
    }

    fn axes_of_program(&self) -> Axes<'_> {
        let or_else = |given: &'_ [f64], default: &'static [f64]| -> Vec<f64> {
            if given.is_empty() { default } else { given }.to_vec()
        };
        Axes {
            count: self.axes,
            mm_per_turn: &self.mm_per_turn,
            gear_ratio: or_else(&self.gear_ratio, &[1.0]),
            counts_per_turn: self.counts_per_turn(),
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
    pub(crate) fn axes(&self) -> Result<usize, MotionError> {
        Ok(match &self.content {
            Content::File(file) => file.table.columns.positions.len(),
            Content::Program { machine, .. } => machine.motors.len(),
        })
    }

    /// The same drives as were named elsewhere, when there is one for each axis.
    pub(crate) fn takes_drives(&self, drives: Vec<DriveId>) -> Result<Vec<DriveId>, MotionError> {
        let expected = self.axes()?;
        if let Content::Program { machine, .. } = &self.content
            && let Some(named) = machine.drives()
            && named != drives
        {
            return Err(MotionError::DrivesOfMachine { named, drives });
        }
        if drives.len() == expected {
            return Ok(drives);
        }
        Err(MotionError::DriveCount {
            expected,
            actual: drives.len(),
        })
    }

    /// Whether options or the machine of a program say which drives they are.
    pub(crate) fn names_drives(&self) -> bool {
        let of_machine = match &self.content {
            Content::Program { machine, .. } => machine.drives(),
            Content::File(_) => None,
        };
        self.options.drives.is_some() || of_machine.is_some()
    }

    /// The drive of each axis.
    pub(crate) fn drives(&self) -> Result<Vec<DriveId>, MotionError> {
        let axes = self.axes()?;
        let named = match &self.content {
            Content::Program { machine, .. } => machine.drives(),
            Content::File(_) => None,
        };
        let drives: Vec<DriveId> = match (&self.options.drives, named) {
            (_, Some(named)) => named,
            (Some(DriveSet::Dyn(drives)), None) => drives.clone(),
            (Some(DriveSet::Zlac(_)), None) => return Err(MotionError::HubMotors),
            (None, None) => DriveId::all().take(axes).collect(),
        };
        self.takes_drives(drives)
    }

    /// Name, unit and scale of each axis, for a recording.
    pub(crate) fn axes_about(&self, drives: &[DriveId]) -> Result<Vec<AxisAbout>, MotionError> {
        Ok(match &self.content {
            Content::File(file) => axes_about::of_columns(&file.table, &file.scales, drives),
            Content::Program { machine, .. } => axes_about::of_program(machine, drives),
        })
    }

    /// The gear number of the drive of each axis: a quarter of the counts of a turn.
    pub(crate) fn gear_numbers(&self) -> Result<Vec<GearNumber>, MotionError> {
        let counts: Vec<f64> = match &self.content {
            Content::File(file) => {
                let counts = file.scales.iter().map(|scale| scale.counts_per_turn.abs());
                counts.collect()
            }
            Content::Program { machine, .. } => {
                let counts = machine
                    .motors
                    .iter()
                    .map(|motor| motor.counts_per_turn.abs());
                counts.collect()
            }
        };
        gear_numbers(counts.into_iter())
    }

    /// The positions at every cycle, checked against the step that each axis can follow.
    pub(crate) fn plan(&self, cycle_us: u32, max_step: StepLimit) -> Result<Plan, MotionError> {
        let options = self.options;
        match &self.content {
            Content::File(file) => Plan::new(
                &file.table,
                &file.scales,
                options.interpolation,
                cycle_us,
                &vec![max_step; file.table.columns.positions.len()],
            )
            .map_err(|source| options.in_file(source)),
            Content::Program { file, machine } => {
                let most_s = options.max_duration;
                let program = &options.program;
                let checked = program.check(file.clone(), machine, cycle_us, max_step, most_s)?;
                Ok(Plan::of_program(checked))
            }
        }
    }

    /// What the motion is about to do.
    pub(crate) fn report(
        &self,
        plan: &Plan,
        drives: &[DriveId],
        max_step: StepLimit,
    ) -> Result<MotionReport, MotionError> {
        let drives: Vec<u8> = drives.iter().map(|drive| drive.get()).collect();
        match (&self.content, plan.program()) {
            (Content::Program { machine, .. }, Some(checked)) => {
                let report = ProgramReport::new(checked, machine, &drives);
                Ok(MotionReport::Program(report))
            }
            _ => {
                let file = self.file()?;
                let name = self.options.file_name();
                let report =
                    FileReport::new(name, &file.table, plan, &file.scales, &drives, max_step);
                Ok(MotionReport::File(report))
            }
        }
    }

    /// Speeds of wheels at every cycle, in 1/n r/min; the columns are r/min, at rest in the beginning and in the end.
    pub(crate) fn speeds(&self, cycle_us: u32, speed_resolution: u16) -> Result<Plan, MotionError> {
        let table = &self.file()?.table;
        for point in [0, table.points() - 1] {
            if let Some(&rpm) = table.row(point).iter().find(|rpm| **rpm != 0.0) {
                return Err(MotionError::NotAtRest {
                    path: self.options.file_name(),
                    line: table.lines[point],
                    rpm,
                });
            }
        }
        let axes = table.columns.positions.len();
        Plan::new(
            table,
            &vec![wheel_scale(speed_resolution); axes],
            Interpolation::Linear,
            cycle_us,
            &vec![StepLimit::MAX; axes],
        )
        .map_err(|source| self.options.in_file(source))
    }

    /// The names of wheels, for a recording.
    pub(crate) fn wheels_about(&self, nodes: &[NodeId]) -> Result<Vec<AxisAbout>, MotionError> {
        Ok(axes_about::of_wheels(&self.file()?.table, nodes))
    }

    /// What wheels are about to do.
    pub(crate) fn wheel_report(
        &self,
        plan: &Plan,
        nodes: &[NodeId],
        speed_resolution: u16,
    ) -> Result<MotionReport, MotionError> {
        let table = &self.file()?.table;
        let nodes: Vec<u8> = nodes.iter().map(|node| node.get()).collect();
        let scales = vec![wheel_scale(speed_resolution); nodes.len()];
        let name = self.options.file_name();
        let report = FileReport::new(name, table, plan, &scales, &nodes, StepLimit::MAX);
        Ok(MotionReport::File(report))
    }

    /// The motion file; a program is none.
    fn file(&self) -> Result<&FileContent, MotionError> {
        match &self.content {
            Content::File(file) => Ok(file),
            Content::Program { .. } => Err(MotionError::HubMotors),
        }
    }
}

fn wheel_scale(speed_resolution: u16) -> AxisScale {
    AxisScale {
        unit: Unit::Rpm,
        gear_ratio: 1.0,
        counts_per_turn: speed_resolution.into(),
        mm_per_turn: 1.0,
    }
}

fn or_default(given: &[f64], default: f64) -> Vec<f64> {
    match given {
        [] => vec![default],
        given => given.to_vec(),
    }
}

fn gear_numbers(counts: impl Iterator<Item = f64>) -> Result<Vec<GearNumber>, MotionError> {
    let gear = |counts: f64| {
        let number = counts / 4.0;
        let is_whole = number.fract() == 0.0 && (0.0..=65_535.0).contains(&number);
        let gear = is_whole
            .then(|| GearNumber::new(number as i32).ok())
            .flatten();
        gear.ok_or(MotionError::CountsPerTurn { actual: counts })
    };
    counts.map(gear).collect()
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
