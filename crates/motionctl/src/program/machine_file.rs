//! A machine in a file: how its motors move the coordinates of a program. Everything is said once; what contradicts itself is refused with
//! its line and column.

use core::ops::Range;
use std::path::Path;

use board_settings::file::{FileError, Place};
use dyn_can::{DriveId, GearNumber};
use serde::Deserialize;
use toml::Spanned;

use super::error::ProgramFileError;
use super::machine::{Kind, LETTERS, MachineSetup, MotorSetup};
use super::options::{ACCELERATION_RPM_PER_S, JERK_RPM_PER_S2, RPM};

/// With the gear number that the drives come with.
const COUNTS_PER_TURN: f64 = 16_384.0;

const KINDS: &str = "\"cartesian\", \"gantry\" or \"differential-drive\"";

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileText {
    machine: Spanned<String>,
    motor: Vec<Spanned<MotorText>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename_all = "kebab-case")]
struct MotorText {
    drive: Spanned<i64>,
    axis: Option<Spanned<String>>,
    side: Option<Spanned<String>>,
    mm_per_turn: Option<Spanned<f64>>,
    counts_per_mm: Option<Spanned<f64>>,
    gear_ratio: Option<Spanned<f64>>,
    counts_per_turn: Option<Spanned<f64>>,
    rpm: Option<Spanned<f64>>,
    acceleration: Option<Spanned<f64>>,
    jerk: Option<Spanned<f64>>,
    backlash_mm: Option<Spanned<f64>>,
}

/// What the file calls its machine.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sort {
    Cartesian,
    Gantry,
    DifferentialDrive,
}

/// Reads a machine.
pub(super) fn read(path: &Path) -> Result<MachineSetup, ProgramFileError> {
    let text = std::fs::read_to_string(path).map_err(|source| ProgramFileError::Read {
        path: path.to_owned(),
        source,
    })?;
    let reader = Reader {
        text: &text,
        name: &path.display().to_string(),
    };
    reader.file().map_err(|source| ProgramFileError::Machine {
        path: path.to_owned(),
        source,
    })
}

struct Reader<'a> {
    text: &'a str,
    name: &'a str,
}

impl Reader<'_> {
    fn file(&self) -> Result<MachineSetup, FileError> {
        let file: FileText = toml::from_str(self.text).map_err(|error| {
            let message = error.message().trim_end();
            let span = error.span().unwrap_or_default();
            self.error(
                &span,
                "a machine and its motors",
                message,
                "docs/paths.md has an example",
            )
        })?;
        let sort = self.sort(&file.machine)?;
        let mut motors: Vec<MotorSetup> = Vec::new();
        for motor in &file.motor {
            let next = self.motor(sort, motor, &motors)?;
            motors.push(next);
        }
        self.check(sort, &file.machine.span(), &mut motors)?;
        if sort == Sort::DifferentialDrive {
            // The left one first.
            motors.sort_by_key(|motor| motor.coordinate);
        }
        Ok(MachineSetup {
            kind: match sort {
                Sort::Cartesian | Sort::Gantry => Kind::Axes,
                Sort::DifferentialDrive => Kind::DifferentialDrive,
            },
            motors,
        })
    }

    fn sort(&self, word: &Spanned<String>) -> Result<Sort, FileError> {
        match word.get_ref().as_str() {
            "cartesian" => Ok(Sort::Cartesian),
            "gantry" => Ok(Sort::Gantry),
            "differential-drive" => Ok(Sort::DifferentialDrive),
            other => {
                let actual = format!("\"{other}\"");
                Err(self.error(&word.span(), KINDS, &actual, "name the machine"))
            }
        }
    }

    fn motor(
        &self,
        sort: Sort,
        motor: &Spanned<MotorText>,
        others: &[MotorSetup],
    ) -> Result<MotorSetup, FileError> {
        let (span, motor) = (motor.span(), motor.get_ref());
        let drive = self.drive(&motor.drive, others)?;
        let (coordinate, name) = self.place(sort, &span, motor, others)?;
        let counts_per_turn = self.counts_per_turn(motor)?;
        let limit = |value: &Option<Spanned<f64>>, default| match value {
            Some(value) => self.positive(value),
            None => Ok(default),
        };
        let backlash_mm = match &motor.backlash_mm {
            Some(value) => Some(self.positive(value)?),
            None => None,
        };
        let Place { line, column } = Place::of(self.text, span.start);
        let name_of_file = self.name;
        Ok(MotorSetup {
            source: format!("{name_of_file}: line {line}, column {column}: motor of drive {drive}"),
            name,
            coordinate,
            drive: Some(drive),
            counts_per_mm: self.counts_per_mm(&span, motor, counts_per_turn)?,
            counts_per_turn,
            rpm: limit(&motor.rpm, RPM)?,
            acceleration: limit(&motor.acceleration, ACCELERATION_RPM_PER_S)?,
            jerk: limit(&motor.jerk, JERK_RPM_PER_S2)?,
            backlash_mm,
        })
    }

    fn drive(&self, id: &Spanned<i64>, others: &[MotorSetup]) -> Result<DriveId, FileError> {
        let number = i32::try_from(*id.get_ref()).ok();
        let Some(drive) = number.and_then(|number| DriveId::new(number).ok()) else {
            let actual = id.get_ref().to_string();
            return Err(self.error(
                &id.span(),
                "a drive id from 1 to 63",
                &actual,
                "`motionctl scan` shows the ids",
            ));
        };
        if others.iter().any(|other| other.drive == Some(drive)) {
            let actual = format!("drive {drive} a second time");
            return Err(self.error(
                &id.span(),
                "each drive once",
                &actual,
                "give each motor its own drive",
            ));
        }
        Ok(drive)
    }

    /// The coordinate of a motor, and its name.
    fn place(
        &self,
        sort: Sort,
        span: &Range<usize>,
        motor: &MotorText,
        others: &[MotorSetup],
    ) -> Result<(usize, String), FileError> {
        let (key, wrong, words, most): (_, _, &[&str], _) = match sort {
            Sort::DifferentialDrive => ("side", &motor.axis, &["left", "right"], 1),
            Sort::Cartesian => ("axis", &motor.side, &["X", "Y", "Z"], 1),
            Sort::Gantry => ("axis", &motor.side, &["X", "Y", "Z"], 2),
        };
        let choice = format!("{key} = \"{}\"", words.join("\" or \""));
        if let Some(wrong) = wrong {
            let actual = format!("\"{}\" of another machine", wrong.get_ref());
            return Err(self.error(
                &wrong.span(),
                &choice,
                &actual,
                "correct it, or the machine",
            ));
        }
        let word = match sort {
            Sort::DifferentialDrive => &motor.side,
            Sort::Cartesian | Sort::Gantry => &motor.axis,
        };
        let Some(word) = word else {
            return Err(self.error(span, &choice, "nothing", "say what the motor moves"));
        };
        let place = words.iter().position(|known| known == word.get_ref());
        let Some(coordinate) = place else {
            let actual = format!("\"{}\"", word.get_ref());
            return Err(self.error(&word.span(), &choice, &actual, "say what the motor moves"));
        };
        let same = others.iter().filter(|other| other.coordinate == coordinate);
        if same.count() >= most {
            let of = if most == 1 {
                "one motor"
            } else {
                "at most two motors"
            };
            let advice = match sort {
                Sort::Cartesian => "for two motors on one axis write machine = \"gantry\"",
                Sort::Gantry | Sort::DifferentialDrive => "correct it",
            };
            let expected = format!("{of} of {}", word.get_ref());
            return Err(self.error(&word.span(), &expected, "another one", advice));
        }
        Ok((coordinate, word.get_ref().clone()))
    }

    fn counts_per_turn(&self, motor: &MotorText) -> Result<f64, FileError> {
        let Some(value) = &motor.counts_per_turn else {
            return Ok(COUNTS_PER_TURN);
        };
        let counts = *value.get_ref();
        let is_whole = counts.fract() == 0.0 && counts % 4.0 == 0.0;
        let gear = GearNumber::new((counts / 4.0) as i32);
        if is_whole && gear.is_ok() {
            return Ok(counts);
        }
        Err(self.error(
            &value.span(),
            "4 times the gear number of the drive, 2000 to 65536",
            &counts.to_string(),
            "`motionctl read` shows the gear number",
        ))
    }

    fn counts_per_mm(
        &self,
        span: &Range<usize>,
        motor: &MotorText,
        counts_per_turn: f64,
    ) -> Result<f64, FileError> {
        if let Some(counts) = &motor.counts_per_mm {
            let others = [
                ("mm-per-turn", &motor.mm_per_turn),
                ("gear-ratio", &motor.gear_ratio),
            ];
            for (key, other) in others {
                if let Some(other) = other {
                    let expected = format!("counts-per-mm or {key}");
                    return Err(self.error(&other.span(), &expected, "both", "remove one of them"));
                }
            }
            return self.not_zero(counts);
        }
        let Some(pitch) = &motor.mm_per_turn else {
            return Err(self.error(
                span,
                "mm-per-turn or counts-per-mm",
                "neither",
                "say what a turn or a millimetre is",
            ));
        };
        let ratio = match &motor.gear_ratio {
            Some(ratio) => self.not_zero(ratio)?,
            None => 1.0,
        };
        Ok(ratio * counts_per_turn / self.positive(pitch)?)
    }

    fn positive(&self, value: &Spanned<f64>) -> Result<f64, FileError> {
        let number = *value.get_ref();
        if number.is_finite() && number > 0.0 {
            return Ok(number);
        }
        let actual = number.to_string();
        Err(self.error(&value.span(), "a number above 0", &actual, "correct it"))
    }

    fn not_zero(&self, value: &Spanned<f64>) -> Result<f64, FileError> {
        let number = *value.get_ref();
        if number.is_finite() && number != 0.0 {
            return Ok(number);
        }
        let actual = number.to_string();
        Err(self.error(
            &value.span(),
            "a finite number other than 0",
            &actual,
            "correct it; a negative one reverses",
        ))
    }

    /// What one motor alone cannot tell; names the two of a pair.
    fn check(
        &self,
        sort: Sort,
        span: &Range<usize>,
        motors: &mut [MotorSetup],
    ) -> Result<(), FileError> {
        if motors.is_empty() {
            return Err(self.error(span, "a [[motor]]", "none", "add the motors"));
        }
        if sort == Sort::DifferentialDrive && motors.len() != 2 {
            let actual = "one";
            return Err(self.error(span, "two motors, left and right", actual, "add the other"));
        }
        let mut pairs = 0;
        for (coordinate, letter) in LETTERS.into_iter().enumerate() {
            let mut same: Vec<&mut MotorSetup> = motors
                .iter_mut()
                .filter(|motor| motor.coordinate == coordinate)
                .collect();
            if same.len() < 2 {
                continue;
            }
            pairs += 1;
            for (motor, number) in same.iter_mut().zip(1..) {
                motor.name = format!("{letter}{number}");
            }
        }
        if sort == Sort::Gantry && pairs == 0 {
            return Err(self.error(
                span,
                "two motors on one axis of a gantry",
                "one on each",
                "add the other, or write machine = \"cartesian\"",
            ));
        }
        Ok(())
    }

    fn error(&self, span: &Range<usize>, expected: &str, actual: &str, advice: &str) -> FileError {
        FileError {
            place: Place::of(self.text, span.start),
            expected: expected.to_owned(),
            actual: actual.to_owned(),
            advice: advice.to_owned(),
        }
    }
}
