//! Why a simulation did not run.

use core::fmt;
use std::path::PathBuf;

use can_motion::ConfigError;
use drive_sim::UnsupportedBitRate;
use dyn_can::RangeError;

use crate::trajectory::TrajectoryError;

/// A simulation that cannot be run, or whose result cannot be written.
#[derive(Debug)]
pub(crate) enum SimError {
    /// A file cannot be read.
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    /// A file cannot be written.
    Write {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The candump log cannot be written any further.
    Log(std::io::Error),
    /// The summary cannot be written as JSON.
    Json(serde_json::Error),
    /// The motion is not usable.
    Trajectory {
        path: String,
        source: TrajectoryError,
    },
    /// An option is out of range.
    Option {
        name: &'static str,
        source: RangeError,
    },
    /// No drive knows this bit rate.
    BitRate(UnsupportedBitRate),
    /// The shortest response delay would be negative.
    ResponseSpread { actual_percent: u32 },
    /// The number of drive ids is not the number of axes.
    DriveCount { expected: usize, actual: usize },
    /// More axes than a simulation can hold.
    AxisCount { most: usize, actual: usize },
    /// The master refuses the configuration.
    Config(ConfigError),
}

impl fmt::Display for SimError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read { path, source } => write!(f, "cannot read {}: {source}", path.display()),
            Self::Write { path, source } => write!(f, "cannot write {}: {source}", path.display()),
            Self::Log(source) => write!(f, "cannot write the candump log: {source}"),
            Self::Json(source) => write!(f, "cannot write the summary: {source}"),
            Self::Trajectory { path, source } => write!(f, "{path}: {source}"),
            Self::Option { name, source } => write!(f, "{name}: {source}"),
            Self::BitRate(source) => write!(f, "--bit-rate: {source}"),
            Self::ResponseSpread { actual_percent } => {
                write!(
                    f,
                    "--response-spread must be 0..=100 percent, got {actual_percent}"
                )
            }
            Self::DriveCount { expected, actual } => {
                write!(
                    f,
                    "--drives: expected {expected} ids for {expected} axes, got {actual}"
                )
            }
            Self::AxisCount { most, actual } => {
                write!(
                    f,
                    "a simulation holds at most {most} axes, the motion has {actual}: choose some with --axes or --columns"
                )
            }
            Self::Config(source) => source.fmt(f),
        }
    }
}

impl std::error::Error for SimError {}
