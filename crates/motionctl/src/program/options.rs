//! The options of a program.

use std::path::PathBuf;

use dyn_can::StepLimit;

use super::check::Checked;
use super::error::ProgramFileError;
use super::machine::{COORDINATES, Kind, LETTERS, MachineSetup, Manner, MotorSetup};
use super::machine_file;
use super::source::ProgramFile;

/// What a motor can do where nothing says it.
pub(super) const RPM: f64 = 500.0;
pub(super) const ACCELERATION_RPM_PER_S: f64 = 5_000.0;
pub(super) const JERK_RPM_PER_S2: f64 = 100_000.0;

/// What to run, and within which limits.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct ProgramOptions {
    /// Program of G-code (docs/paths.md): X, Y and Z are the axes in their order, in millimetres from where the drives stand.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["trajectory", "columns", "time_column", "time_unit", "unit", "decimal_comma", "interpolation"])]
    pub(crate) program: Option<PathBuf>,
    /// Of a program: machine file (docs/paths.md) with the drive, the scale and the limits of each motor, in the place of these options: for
    /// two motors on one axis, a differential drive, or backlash.
    #[arg(long, value_name = "FILE.toml", requires = "program", conflicts_with_all = ["axes", "drives", "mm_per_turn", "gear_ratio", "counts_per_turn", "counts_per_mm", "axis_rpm", "axis_acceleration", "axis_jerk"])]
    machine: Option<PathBuf>,
    /// Of a program: command counts of one millimetre, one for all axes or one each; negative reverses. Instead of --mm-per-turn.
    #[arg(long, value_name = "COUNTS", value_delimiter = ',', value_parser = number, allow_hyphen_values = true, requires = "program", conflicts_with_all = ["mm_per_turn", "gear_ratio"])]
    counts_per_mm: Vec<f64>,
    /// Of a program: fastest speed of a motor in r/min, one for all axes or one each.
    #[arg(long, value_name = "RPM", default_values_t = [RPM], value_delimiter = ',', value_parser = positive)]
    axis_rpm: Vec<f64>,
    /// Of a program: largest acceleration of a motor in r/min per second.
    #[arg(long, value_name = "RPM_PER_S", default_values_t = [ACCELERATION_RPM_PER_S], value_delimiter = ',', value_parser = positive)]
    axis_acceleration: Vec<f64>,
    /// Of a program: largest jerk of a motor in r/min per second²; the acceleration is built up in twice the time that follows from it.
    #[arg(long, value_name = "RPM_PER_S2", default_values_t = [JERK_RPM_PER_S2], value_delimiter = ',', value_parser = positive)]
    axis_jerk: Vec<f64>,
    /// Of a program: how far a corner may be missed with G64 without P, in millimetres.
    #[arg(long, value_name = "MM", default_value = "0.01", value_parser = positive)]
    tolerance_mm: f64,
    /// Of a program: highest speed that an override can reach while it runs, in percent of its feeds, 100 to 200. The tool then begins to
    /// brake earlier, and what the program needs of the motors is compared with their limits at that speed.
    #[arg(long, value_name = "PERCENT", default_value_t = 100, value_parser = clap::value_parser!(u16).range(100..=200), requires = "program")]
    max_override: u16,
    /// Of a program: pass over programmed stops, which wait for somebody to let the program go on.
    #[arg(long)]
    skip_pauses: bool,
    /// Of a program: write its path as a picture, seen from above.
    #[arg(long, value_name = "FILE", requires = "program")]
    pub(crate) path_svg: Option<PathBuf>,
}

/// What the other options say of the axes.
pub(crate) struct Axes<'a> {
    pub(crate) count: Option<usize>,
    pub(crate) mm_per_turn: &'a [Option<f64>],
    pub(crate) gear_ratio: Vec<f64>,
    pub(crate) counts_per_turn: Vec<f64>,
}

impl Axes<'_> {
    fn count(&self) -> Result<usize, ProgramFileError> {
        let count = self.count.unwrap_or(COORDINATES);
        if count > COORDINATES {
            return Err(ProgramFileError::Option(format!(
                "--axes: a program has 1 to {COORDINATES} axes, got {count}"
            )));
        }
        Ok(count)
    }
}

impl ProgramOptions {
    /// The machine of the file, or of the options.
    pub(crate) fn machine(&self, axes: &Axes<'_>) -> Result<MachineSetup, ProgramFileError> {
        if let Some(path) = &self.machine {
            return machine_file::read(path);
        }
        let count = axes.count()?;
        let per_mm = self.counts_per_mm(axes, count)?;
        let turns = each(&axes.counts_per_turn, count, "--counts-per-turn")?;
        let rpm = each(&self.axis_rpm, count, "--axis-rpm")?;
        let acceleration = each(&self.axis_acceleration, count, "--axis-acceleration")?;
        let jerk = each(&self.axis_jerk, count, "--axis-jerk")?;
        let motor = |axis: usize| MotorSetup {
            name: LETTERS[axis].to_string(),
            coordinate: axis,
            drive: None,
            counts_per_mm: per_mm[axis],
            counts_per_turn: turns[axis],
            rpm: rpm[axis],
            acceleration: acceleration[axis],
            jerk: jerk[axis],
            backlash_mm: None,
            source: format!(
                "{} (--mm-per-turn, --axis-rpm, --axis-acceleration, --axis-jerk)",
                LETTERS[axis]
            ),
        };
        Ok(MachineSetup {
            kind: Kind::Axes,
            motors: (0..count).map(motor).collect(),
        })
    }

    /// Command counts of a millimetre, axis by axis.
    fn counts_per_mm(&self, axes: &Axes<'_>, count: usize) -> Result<Vec<f64>, ProgramFileError> {
        if !self.counts_per_mm.is_empty() {
            return each(&self.counts_per_mm, count, "--counts-per-mm");
        }
        if axes.mm_per_turn.is_empty() {
            return Err(ProgramFileError::Option(
                "a program is in millimetres: say what a turn is with --mm-per-turn, or a millimetre with --counts-per-mm".to_owned(),
            ));
        }
        let pitches = each(axes.mm_per_turn, count, "--mm-per-turn")?;
        let ratios = each(&axes.gear_ratio, count, "--gear-ratio")?;
        let turns = each(&axes.counts_per_turn, count, "--counts-per-turn")?;
        let factors = pitches.into_iter().zip(ratios).zip(turns);
        let of_axis = |((pitch, ratio), turn): ((Option<f64>, f64), f64)| {
            let none = || {
                ProgramFileError::Option("--mm-per-turn: every axis of a program is in millimetres, expected a number in the place of -".to_owned())
            };
            Ok(ratio * turn / pitch.ok_or_else(none)?)
        };
        factors.map(of_axis).collect()
    }

    /// Plays the whole program.
    pub(crate) fn check(
        &self,
        file: ProgramFile,
        setup: &MachineSetup,
        cycle_us: u32,
        max_step: StepLimit,
        max_duration_s: f64,
    ) -> Result<Checked, ProgramFileError> {
        let machine = setup.machine(Manner {
            cycle_us,
            tolerance_um: (self.tolerance_mm * 1e3) as f32,
            skips_pauses: self.skip_pauses,
            most_percent: self.max_override,
        })?;
        Checked::new(file, machine, setup.names(), max_step, max_duration_s)
    }
}

/// One value for all axes, or one each.
fn each<T: Copy>(given: &[T], count: usize, option: &str) -> Result<Vec<T>, ProgramFileError> {
    match given {
        [all] => Ok(vec![*all; count]),
        given if given.len() == count => Ok(given.to_vec()),
        given => Err(ProgramFileError::Option(format!(
            "{option}: expected one value or one for each of the {count} axes, got {}",
            given.len()
        ))),
    }
}

fn number(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number != 0.0 => Ok(number),
        _ => Err("expected a finite number other than 0".to_owned()),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err(format!("must be a number above 0, got {text}")),
    }
}
