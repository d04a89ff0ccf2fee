//! Why a commissioning command did not succeed.

use core::fmt;

use can_motion::{ConfigError, ProcedureError};
use dyn_can::{DriveId, StoredDriveId};

use super::Parameter;
use crate::confirm::NotConfirmed;
use crate::exit::{self, Coded};
use crate::link::{LinkFault, OpenError};
use crate::station::{LINK_WARNING, warning};

/// A commissioning command that did not succeed.
#[derive(Debug)]
pub(crate) enum DrivesError {
    /// The link cannot be opened.
    Open(OpenError),
    /// The link failed on the way; nothing was enabled.
    Link(LinkFault),
    /// The link failed while a drive was enabled.
    LinkWhileEnabled(LinkFault),
    /// Ctrl-C cannot be listened to.
    Interrupt(ctrlc::Error),
    /// CANopen drives have no serial port that this tool speaks to.
    CanopenOnSerial,
    /// Nobody agreed.
    NotConfirmed(NotConfirmed),
    /// The master refuses the configuration.
    Config(ConfigError),
    /// The master refuses the procedure.
    Procedure(ProcedureError),
    /// A drive without an id has no address on CAN of its own.
    NoIdOnCan,
    /// The drive does not answer.
    NoAnswer { drive: StoredDriveId },
    /// The drive answered some requests, not all, in the time that it had.
    Incomplete { drive: StoredDriveId },
    /// The drive has a fault that forbids what was asked for.
    Fault {
        drive: StoredDriveId,
        reason: String,
    },
    /// Drives did not confirm that they are disabled, after the error that ended the motion, if there was one.
    StillEnabled {
        drives: Vec<DriveId>,
        after: Option<Box<DrivesError>>,
    },
    /// A parameter was given two values.
    Twice { parameter: Parameter },
    /// The drive refused a value with a data error.
    Refused {
        drive: StoredDriveId,
        parameter: Parameter,
    },
    /// The drive reads back another value than the one that was written.
    NotTaken {
        drive: StoredDriveId,
        parameter: Parameter,
        expected: i32,
        actual: Option<i32>,
    },
    /// The user asked to stop.
    Interrupted,
    /// The result cannot be written as JSON.
    Json(serde_json::Error),
}

impl DrivesError {
    /// The end of everything that enables: what came of it, and which drives did not confirm that they are disabled.
    pub(crate) fn after_shut_down<T>(
        moved: Result<T, Self>,
        shut_down: Result<Vec<DriveId>, LinkFault>,
    ) -> Result<T, Self> {
        let drives = shut_down.map_err(Self::LinkWhileEnabled)?;
        if drives.is_empty() {
            return moved;
        }
        let after = moved.err().map(Box::new);
        Err(Self::StillEnabled { drives, after })
    }
}

impl Coded for DrivesError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Open(_) | Self::Link(_) | Self::LinkWhileEnabled(_) => exit::LINK_FAILED,
            Self::Interrupted => exit::INTERRUPTED,
            Self::Config(_)
            | Self::Interrupt(_)
            | Self::NotConfirmed(_)
            | Self::CanopenOnSerial
            | Self::NoIdOnCan
            | Self::Twice { .. }
            | Self::Json(_) => exit::BAD_INPUT,
            _ => exit::BROKEN_PROMISE,
        }
    }
}

impl From<LinkFault> for DrivesError {
    fn from(fault: LinkFault) -> Self {
        Self::Link(fault)
    }
}

impl fmt::Display for DrivesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open(source) => source.fmt(f),
            Self::Link(source) => write!(f, "the link failed: {source}"),
            Self::Interrupt(source) => write!(f, "cannot listen to Ctrl-C: {source}"),
            Self::NotConfirmed(source) => source.fmt(f),
            Self::CanopenOnSerial => f.write_str(
                "--protocol canopen is for CAN: use --slcan or --can in place of --serial",
            ),
            Self::Config(source) => source.fmt(f),
            Self::Procedure(source) => source.fmt(f),
            Self::NoIdOnCan => f.write_str(
                "0 is every drive on CAN: give the drive an id, or use its serial port with --serial",
            ),
            Self::NoAnswer { drive } => write!(
                f,
                "drive {drive} does not answer: check its power, wiring, termination, bit rate and id, or look with `motionctl scan`"
            ),
            Self::Incomplete { drive } => {
                write!(
                    f,
                    "drive {drive} did not answer all requests in time: try again, or look for a second master"
                )
            }
            Self::Fault { drive, reason } => write!(f, "drive {drive}: {reason}"),
            Self::LinkWhileEnabled(source) => {
                write!(f, "the link failed: {source}. {LINK_WARNING}")
            }
            Self::StillEnabled { drives, after } => {
                if let Some(error) = after {
                    write!(f, "{error}; and ")?;
                }
                f.write_str(&warning(drives))
            }
            Self::Twice { parameter } => write!(f, "{parameter} is given twice"),
            Self::Refused { drive, parameter } => {
                write!(f, "drive {drive} refuses this value of {parameter}")
            }
            Self::NotTaken {
                drive,
                parameter,
                expected,
                actual,
            } => {
                write!(
                    f,
                    "drive {drive} did not take {parameter} = {expected}, it reads back "
                )?;
                match actual {
                    Some(actual) => write!(f, "{actual}"),
                    None => f.write_str("nothing"),
                }
            }
            Self::Interrupted => f.write_str("stopped by the user"),
            Self::Json(source) => write!(f, "cannot write the result: {source}"),
        }
    }
}

impl std::error::Error for DrivesError {}
