//! Why the options make no motion.

use core::fmt;
use std::path::PathBuf;

use dyn_can::DriveId;

use super::TrajectoryError;
use crate::counted::counted;
use crate::program::ProgramFileError;

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
    /// The program is not usable.
    Program(ProgramFileError),
    /// The number of drive ids, of which there are 63, is not the number of axes.
    DriveCount { expected: usize, actual: usize },
    /// The machine file of a program names other drives.
    DrivesOfMachine {
        named: Vec<DriveId>,
        drives: Vec<DriveId>,
    },
    /// No gear number makes so many counts of a turn.
    CountsPerTurn { actual: f64 },
    /// A stream without drives.
    DrivesOfStream,
    /// Hub motors were asked for where servo drives are moved.
    HubMotors,
    /// Wheels do not stand in the first or the last line.
    NotAtRest { path: String, line: u64, rpm: f64 },
    /// An option for positions where wheels are driven.
    NotForWheels { option: &'static str },
}

impl fmt::Display for MotionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, source } => write!(f, "cannot read {}: {source}", path.display()),
            Self::Program(source) => source.fmt(f),
            Self::Trajectory { path, source } => write!(f, "{path}: {source}"),
            Self::DrivesOfMachine { named, drives } => {
                let list = |drives: &[DriveId]| {
                    let ids: Vec<String> = drives.iter().map(ToString::to_string).collect();
                    ids.join(", ")
                };
                write!(
                    f,
                    "--machine: its motors have the drives {}, and not {}: all of them are on one bus, say it without ids",
                    list(named),
                    list(drives)
                )
            }
            Self::CountsPerTurn { actual } => write!(
                f,
                "--counts-per-turn must be 4 times the gear number of the drive, 2000..=65536, got {actual}"
            ),
            Self::DrivesOfStream => f.write_str(
                "--stream: nothing says which drives it moves: expected --drives with their ids in the order of the axes",
            ),
            Self::HubMotors => f.write_str(
                "hub motors follow speeds on a bus of their own: use `motionctl sim --drives zlac`",
            ),
            Self::NotForWheels { option } => write!(
                f,
                "{option} is for positions, and the columns of hub motors are speeds in r/min: leave it out"
            ),
            Self::NotAtRest { path, line, rpm } => write!(
                f,
                "{path}: line {line}: wheels start and end at rest, the speed is {rpm} r/min and must be 0"
            ),
            Self::DriveCount { expected, actual } => write!(
                f,
                "--drives: expected {} for {}, got {actual}",
                counted(*expected, "id", "ids"),
                counted(*expected, "axis", "axes")
            ),
        }
    }
}

impl std::error::Error for MotionError {}

impl From<ProgramFileError> for MotionError {
    fn from(source: ProgramFileError) -> Self {
        Self::Program(source)
    }
}
