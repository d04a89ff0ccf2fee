//! Why a simulation did not run.

use core::fmt;
use std::path::PathBuf;

use can_motion::ConfigError;
use can_motion::wheel::WheelConfigError;
use dyn_can::RangeError;

use super::faults::ScriptError;
use crate::recording::RecordingError;
use crate::trajectory::MotionError;
use crate::twist::TwistError;
use diff_drive::ValueError;

/// A simulation that cannot be run, or whose result cannot be written.
#[derive(Debug)]
pub(crate) enum SimError {
    /// The options make no motion.
    Motion(MotionError),
    /// A file cannot be read.
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The fault script is not usable.
    Script { path: PathBuf, source: ScriptError },
    /// Two buses have one name.
    SameBus { name: String },
    /// A recording cannot begin.
    Recording(RecordingError),
    /// The fault script for hub motors is not usable.
    WheelScript { path: PathBuf, what: String },
    /// The live view cannot use the terminal.
    Terminal(std::io::Error),
    /// A file cannot be written.
    Write {
        path: PathBuf,
        source: std::io::Error,
    },
    /// The summary cannot be written.
    Print(std::io::Error),
    /// An option is out of range.
    Option {
        name: &'static str,
        source: RangeError,
    },
    /// More axes than a simulation can hold.
    AxisCount { most: usize, actual: usize },
    /// The master refuses the configuration.
    Config(ConfigError),
    /// The master of wheels refuses the configuration.
    Wheels(WheelConfigError),
    /// Another number of nodes than of columns, or more wheels than a simulation can hold.
    WheelCount {
        most: usize,
        columns: usize,
        nodes: usize,
    },
    /// A speed beyond what the drive can be told at this resolution.
    WheelSpeed { most_rpm: u32, actual_rpm: u32 },
    /// A file of twists cannot be used.
    Twist { path: PathBuf, source: TwistError },
    /// A measure of the vehicle is out of range.
    Vehicle(ValueError),
    /// An option that a simulation of servos does not have.
    NotForServos { option: &'static str },
}

impl fmt::Display for SimError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Motion(source) => source.fmt(f),
            Self::Read { path, source } => write!(f, "cannot read {}: {source}", path.display()),
            Self::Script { path, source } => write!(f, "{}: {source}", path.display()),
            Self::SameBus { name } => write!(
                f,
                "--bus {name}=... is given twice: each bus has a name of its own, and its drives behind one ="
            ),
            Self::Recording(source) => source.fmt(f),
            Self::WheelScript { path, what } => write!(f, "{}: {what}", path.display()),
            Self::Terminal(source) => write!(
                f,
                "the live view needs a terminal ({source}): leave out --live, or use --report"
            ),
            Self::Write { path, source } => write!(f, "cannot write {}: {source}", path.display()),
            Self::Print(source) => write!(f, "cannot write the summary: {source}"),
            Self::Option { name, source } => write!(f, "{name}: {source}"),
            Self::AxisCount { most, actual } => {
                write!(
                    f,
                    "a simulation holds at most {most} axes, the motion has {actual}: choose some with --axes or --columns"
                )
            }
            Self::Config(source) => source.fmt(f),
            Self::Wheels(source) => source.fmt(f),
            Self::WheelCount {
                most,
                columns,
                nodes,
            } => write!(
                f,
                "--drives: expected one node for each of the {columns} columns, at most {most}, got {nodes}"
            ),
            Self::WheelSpeed {
                most_rpm,
                actual_rpm,
            } => write!(
                f,
                "at this resolution a wheel can be told at most {most_rpm} r/min, the file has {actual_rpm}: lower --speed-resolution"
            ),
            Self::Twist { path, source } => write!(f, "{}: {source}", path.display()),
            Self::Vehicle(source) => source.fmt(f),
            Self::NotForServos { option } => write!(
                f,
                "{option} is for hub motors: add --drives zlac, or zlac:LEFT,RIGHT"
            ),
        }
    }
}

impl std::error::Error for SimError {}
