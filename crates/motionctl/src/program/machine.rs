//! The machine of a program: from its coordinates to its motors, and what each of them can do.

use dyn_can::DriveId;
use path::machine::{Backlash, DifferentialDrive, Gantry, Motor, Scale};
use program::Settings;
use trajectory::{Limits, Position};

use super::error::ProgramFileError;

/// Coordinates of a program.
pub(crate) const COORDINATES: usize = 3;
pub(crate) const LETTERS: [char; COORDINATES] = ['X', 'Y', 'Z'];

/// Motors of a machine at most: two of each coordinate.
pub(crate) const MOST_MOTORS: usize = 6;

/// The share of the limits of a motor with backlash that is kept for taking it up.
const TAKING_UP: f64 = 0.2;

/// How coordinates become motors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Each motor belongs to one coordinate; two of a gantry share one.
    Axes,
    /// Left and right wheel: X is the way of the middle, Y that of a wheel at the track width around the middle.
    DifferentialDrive,
}

/// What is known of a motor before its limits are computed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MotorSetup {
    /// As it is shown.
    pub(crate) name: String,
    /// Counted from 0; of a wheel 0 is the left and 1 the right one.
    pub(crate) coordinate: usize,
    pub(crate) drive: Option<DriveId>,
    /// Negative reverses.
    pub(crate) counts_per_mm: f64,
    pub(crate) counts_per_turn: f64,
    pub(crate) rpm: f64,
    pub(crate) acceleration: f64,
    pub(crate) jerk: f64,
    pub(crate) backlash_mm: Option<f64>,
    /// What to correct when one of these numbers cannot be used: an option, or a place in a file.
    pub(crate) source: String,
}

/// A machine as the options or a file say it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MachineSetup {
    pub(crate) kind: Kind,
    /// In the order of their drives; of a differential drive the left one first.
    pub(crate) motors: Vec<MotorSetup>,
}

/// What does not depend on the motors.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Manner {
    pub(crate) cycle_us: u32,
    pub(crate) tolerance_um: f32,
    pub(crate) skips_pauses: bool,
    /// Highest override, in percent.
    pub(crate) most_percent: u16,
}

/// The play of a motor, and the limits within which it is taken up.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Play {
    play: Position,
    limits: Limits,
}

/// What the player needs to know of the machine.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Machine {
    pub(crate) mapping: Mapping,
    /// Of a path: those of the motors, less what taking up a play needs.
    pub(crate) limits: [Limits; MOST_MOTORS],
    plays: [Option<Play>; MOST_MOTORS],
    pub(crate) settings: Settings,
    pub(crate) manner: Manner,
}

/// Motors that are not there stand still.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Mapping {
    Axes(Gantry<MOST_MOTORS>),
    Wheels(DifferentialDrive),
}

impl path::Machine<COORDINATES, MOST_MOTORS> for Mapping {
    fn axes(&self, place: [Position; COORDINATES]) -> [Position; MOST_MOTORS] {
        match self {
            Self::Axes(motors) => motors.axes(place),
            Self::Wheels(wheels) => {
                let [ahead, turned, _] = place;
                padded(wheels.axes([ahead, turned]), Position::ZERO)
            }
        }
    }

    fn rates(&self, vector: &[f32; COORDINATES]) -> [f32; MOST_MOTORS] {
        match self {
            Self::Axes(motors) => motors.rates(vector),
            Self::Wheels(wheels) => {
                let [ahead, turned, _] = *vector;
                padded(wheels.rates(&[ahead, turned]), 0.0)
            }
        }
    }
}

fn padded<T: Copy>([left, right]: [T; 2], nothing: T) -> [T; MOST_MOTORS] {
    let mut all = [nothing; MOST_MOTORS];
    [all[0], all[1]] = [left, right];
    all
}

impl MotorSetup {
    fn scale(&self) -> Result<Scale, ProgramFileError> {
        let fixed = self.counts_per_mm / 1e3 * f64::from(2_u32.pow(31)) * 2.0;
        Scale::from_fixed(fixed.round() as i64).map_err(|_| {
            ProgramFileError::Option(format!(
                "{}: a millimetre must be 0.02 to 1e9 counts, got {}",
                self.source, self.counts_per_mm
            ))
        })
    }

    /// A share of the limits.
    fn limits(&self, share: f64, cycle_us: u32) -> Result<Limits, ProgramFileError> {
        let cycle_s = f64::from(cycle_us) * 1e-6;
        let turn = self.counts_per_turn.abs() / 60.0 * share;
        let of = |value: f64, power: i32| (value * turn * cycle_s.powi(power)) as f32;
        let limits = Limits::new(of(self.rpm, 1), of(self.acceleration, 2), of(self.jerk, 3));
        limits.map_err(|source| ProgramFileError::Option(format!("{}: {source}", self.source)))
    }

    fn play(&self, cycle_us: u32) -> Result<Option<Play>, ProgramFileError> {
        let Some(mm) = self.backlash_mm else {
            return Ok(None);
        };
        let counts = (mm * self.counts_per_mm).abs();
        let play = Play {
            play: Position::from_units((counts * Position::UNITS as f64) as i64),
            limits: self.limits(TAKING_UP, cycle_us)?,
        };
        play.backlash().map(|_| Some(play)).map_err(|source| {
            let place = &self.source;
            ProgramFileError::Option(format!("{place}: a backlash of {mm} mm: {source}"))
        })
    }
}

impl Play {
    fn backlash(&self) -> Result<Backlash, trajectory::PlanError> {
        Backlash::new(Position::ZERO, self.play, self.limits)
    }
}

impl MachineSetup {
    pub(crate) fn names(&self) -> Vec<String> {
        self.motors.iter().map(|motor| motor.name.clone()).collect()
    }

    /// The drives, where they are named with the motors.
    pub(crate) fn drives(&self) -> Option<Vec<DriveId>> {
        self.motors.iter().map(|motor| motor.drive).collect()
    }

    /// Scales and limits in counts and cycles.
    pub(crate) fn machine(&self, manner: Manner) -> Result<Machine, ProgramFileError> {
        let cycle_us = manner.cycle_us;
        let mut scales = Vec::new();
        let mut limits = Vec::new();
        let mut plays = [None; MOST_MOTORS];
        for (motor, play) in self.motors.iter().zip(&mut plays) {
            *play = motor.play(cycle_us)?;
            let share = if play.is_some() { 1.0 - TAKING_UP } else { 1.0 };
            limits.push(motor.limits(share, cycle_us)?);
            scales.push(motor.scale()?);
        }
        let has = |axis: usize| match self.kind {
            Kind::Axes => self.motors.iter().any(|motor| motor.coordinate == axis),
            Kind::DifferentialDrive => axis < 2,
        };
        Ok(Machine {
            mapping: self.mapping(&scales),
            // Motors that are not there do not move, and do not slow anything down.
            limits: core::array::from_fn(|motor| limits[motor.min(limits.len() - 1)]),
            plays,
            settings: Settings {
                axes: [0, 1, 2].map(has),
                start: [Position::ZERO; COORDINATES],
                home: [Position::ZERO; COORDINATES],
                rapid_um_per_min: f32::MAX / 1e10,
                tolerance_um: manner.tolerance_um,
            },
            manner,
        })
    }

    fn mapping(&self, scales: &[Scale]) -> Mapping {
        let scale = |motor: usize| scales.get(motor).copied().unwrap_or(Scale::ONE);
        match self.kind {
            Kind::DifferentialDrive => Mapping::Wheels(DifferentialDrive {
                left: scale(0),
                right: scale(1),
            }),
            Kind::Axes => Mapping::Axes(Gantry {
                motors: core::array::from_fn(|motor| Motor {
                    coordinate: self
                        .motors
                        .get(motor)
                        .map_or(COORDINATES, |motor| motor.coordinate),
                    scale: scale(motor),
                }),
            }),
        }
    }
}

impl Machine {
    /// The play of each motor that has one, in the middle.
    pub(super) fn backlashes(&self) -> [Option<Backlash>; MOST_MOTORS] {
        // Made before, when the machine was.
        self.plays
            .map(|play| play.and_then(|play| play.backlash().ok()))
    }
}
