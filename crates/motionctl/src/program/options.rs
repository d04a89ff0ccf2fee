//! The options of a program.

use std::path::PathBuf;

use path::machine::Scale;
use program::Settings;
use trajectory::{Limits, Position};

use super::check::Checked;
use super::error::ProgramFileError;
use super::player::Machine;
use super::source::ProgramFile;
use dyn_can::StepLimit;

/// Most coordinates of a program.
const MOST_AXES: usize = 3;
pub(crate) const LETTERS: [char; MOST_AXES] = ['X', 'Y', 'Z'];

/// What to run, and within which limits.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct ProgramOptions {
    /// Program of G-code (docs/paths.md): X, Y and Z are the axes in their order, in millimetres from where the drives stand.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["trajectory", "columns", "time_column", "time_unit", "unit", "decimal_comma", "interpolation"])]
    pub(crate) program: Option<PathBuf>,
    /// Of a program: command counts of one millimetre, one for all axes or one each; negative reverses. Instead of --mm-per-turn.
    #[arg(long, value_name = "COUNTS", value_delimiter = ',', value_parser = number, allow_hyphen_values = true, requires = "program", conflicts_with = "mm_per_turn")]
    counts_per_mm: Vec<f64>,
    /// Of a program: fastest speed of a motor in r/min, one for all axes or one each.
    #[arg(long, value_name = "RPM", default_value = "500", value_delimiter = ',', value_parser = positive)]
    axis_rpm: Vec<f64>,
    /// Of a program: largest acceleration of a motor in r/min per second.
    #[arg(long, value_name = "RPM_PER_S", default_value = "5000", value_delimiter = ',', value_parser = positive)]
    axis_acceleration: Vec<f64>,
    /// Of a program: largest jerk of a motor in r/min per second²; the acceleration is built up in twice the time that follows from it.
    #[arg(long, value_name = "RPM_PER_S2", default_value = "100000", value_delimiter = ',', value_parser = positive)]
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
    pub(crate) gear_ratio: &'a [f64],
    /// One each, once read.
    pub(crate) counts_per_turn: &'a [f64],
    pub(crate) max_duration_s: f64,
}

impl Axes<'_> {
    pub(crate) fn count(&self) -> Result<usize, ProgramFileError> {
        let count = self.count.unwrap_or(MOST_AXES);
        if count > MOST_AXES {
            return Err(ProgramFileError::Option(format!(
                "--axes: a program has 1 to {MOST_AXES} axes, got {count}"
            )));
        }
        Ok(count)
    }
}

impl ProgramOptions {
    /// Command counts of a millimetre, axis by axis.
    pub(crate) fn counts_per_mm(&self, axes: &Axes<'_>) -> Result<Vec<f64>, ProgramFileError> {
        let count = axes.count()?;
        if !self.counts_per_mm.is_empty() {
            return each(&self.counts_per_mm, count, "--counts-per-mm");
        }
        if axes.mm_per_turn.is_empty() {
            return Err(ProgramFileError::Option(
                "a program is in millimetres: say what a turn is with --mm-per-turn, or a millimetre with --counts-per-mm".to_owned(),
            ));
        }
        let pitches = each(axes.mm_per_turn, count, "--mm-per-turn")?;
        let ratios = each(axes.gear_ratio, count, "--gear-ratio")?;
        let turns = each(axes.counts_per_turn, count, "--counts-per-turn")?;
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
        axes: &Axes<'_>,
        cycle_us: u32,
        max_step: StepLimit,
    ) -> Result<Checked, ProgramFileError> {
        let count = axes.count()?;
        let machine = self.machine(axes, count, cycle_us)?;
        Checked::new(file, machine, count, max_step, axes.max_duration_s)
    }

    fn machine(
        &self,
        axes: &Axes<'_>,
        count: usize,
        cycle_us: u32,
    ) -> Result<Machine, ProgramFileError> {
        let per_mm = self.counts_per_mm(axes)?;
        let turns = each(axes.counts_per_turn, count, "--counts-per-turn")?;
        let rpm = each(&self.axis_rpm, count, "--axis-rpm")?;
        let acceleration = each(&self.axis_acceleration, count, "--axis-acceleration")?;
        let jerk = each(&self.axis_jerk, count, "--axis-jerk")?;
        let cycle_s = f64::from(cycle_us) * 1e-6;
        let mut scales = [Scale::ONE; MOST_AXES];
        let mut limits = Vec::new();
        for axis in 0..count {
            let turn = turns[axis].abs() / 60.0;
            let of = |value: f64, power: i32| (value * turn * cycle_s.powi(power)) as f32;
            let of_axis = Limits::new(
                of(rpm[axis], 1),
                of(acceleration[axis], 2),
                of(jerk[axis], 3),
            );
            limits.push(of_axis.map_err(|source| {
                ProgramFileError::Option(format!(
                    "--axis-rpm, --axis-acceleration or --axis-jerk of {}: {source}",
                    LETTERS[axis]
                ))
            })?);
            scales[axis] = scale(per_mm[axis], LETTERS[axis])?;
        }
        // Axes that are not there do not move, and do not slow anything down.
        let first = limits[0];
        limits.resize(MOST_AXES, first);
        Ok(Machine {
            scales,
            limits: [limits[0], limits[1], limits[2]],
            settings: Settings {
                axes: [0, 1, 2].map(|axis| axis < count),
                start: [Position::ZERO; 3],
                home: [Position::ZERO; 3],
                rapid_um_per_min: f32::MAX / 1e10,
                tolerance_um: (self.tolerance_mm * 1e3) as f32,
            },
            cycle_us,
            skips_pauses: self.skip_pauses,
            most_percent: self.max_override,
        })
    }
}

fn scale(counts_per_mm: f64, letter: char) -> Result<Scale, ProgramFileError> {
    let fixed = counts_per_mm / 1e3 * f64::from(2_u32.pow(31)) * 2.0;
    Scale::from_fixed(fixed.round() as i64).map_err(|_| {
        ProgramFileError::Option(format!(
            "{letter}: a millimetre must be 0.02 to 1e9 counts, got {counts_per_mm}"
        ))
    })
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
