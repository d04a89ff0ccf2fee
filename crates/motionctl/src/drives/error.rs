//! Why a commissioning command did not succeed.

use core::fmt;
use std::io;

use can_motion::{ConfigError, Fault, ProcedureError};
use dyn_can::{DecodeError, DriveId, GearNumber, StoredDriveId};
use homing::OutsideTravel;

use super::{AssignError, Parameter};
use crate::confirm::NotConfirmed;
use crate::drive_ids::about;
use crate::exit::{self, Coded};
use crate::link::{LinkFault, OpenError};
use crate::origins::OriginsError;
use crate::output::tell;
use crate::station::{
    BringUpError, End, LookError, Station, fault_text, left_on, unconfirmed_warning,
};

/// A commissioning command that did not succeed.
#[derive(Debug)]
pub(crate) enum DrivesError {
    /// The link cannot be opened.
    Open(OpenError),
    /// The link failed on the way; nothing was enabled.
    Link(LinkFault),
    /// Nothing that a scan sent got out.
    NothingGetsOut,
    /// The link failed while drives were enabled, which the warning names.
    LinkWhileEnabled { fault: LinkFault, warning: String },
    /// What the drives say of themselves is not known.
    Look(LookError),
    /// The drives do not stream set-points.
    BringUp(BringUpError),
    /// A drive has another gear number than it must have.
    Gear {
        drive: DriveId,
        expected: GearNumber,
        actual: GearNumber,
    },
    /// A drive that must not have power has it.
    Enabled { drive: StoredDriveId },
    /// A drive stopped with a fault.
    DriveFault { drive: DriveId, fault: Fault },
    /// A file of origins cannot be used.
    Origins(OriginsError),
    /// A position is outside the travel of its axis.
    OutsideTravel {
        drive: DriveId,
        error: OutsideTravel,
    },
    /// Ctrl-C cannot be listened to.
    Interrupt(io::Error),
    /// CANopen drives have no serial port that this tool speaks to.
    CanopenOnSerial,
    /// A motion that a drive is to make by itself was refused.
    MoveRefused { drive: DriveId, reason: String },
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
    /// Only what was sent comes back on the serial line.
    OnlyEchoes { drive: StoredDriveId },
    /// More than one drive answers to an id.
    Several { drive: StoredDriveId },
    /// A drive did not get an id.
    Assign(AssignError),
    /// The user asked to stop between two writes.
    Interrupted,
    /// A drive is to be given the id that it has.
    SameId { id: DriveId },
    /// The serial protocol has no such command.
    NotOnSerial { what: &'static str },
    /// A reply of the drive does not decode.
    BadReply {
        drive: StoredDriveId,
        error: DecodeError,
    },
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
    /// The result cannot be written.
    Print(io::Error),
}

impl DrivesError {
    /// The end of everything that enables: what came of it, and what became of the power of the drives.
    pub(crate) fn after_shut_down<T>(
        moved: Result<T, Self>,
        station: &mut Station<'_>,
    ) -> Result<(T, End), Self> {
        let end = station
            .shut_down()
            .map_err(|fault| Self::LinkWhileEnabled {
                fault,
                warning: station.link_warning(),
            })?;
        if let Err(Self::Link(fault) | Self::BringUp(BringUpError::Link(fault))) = &moved
            && !end.left_on.is_empty()
        {
            // There was nothing left to switch off, and nothing could have been done either.
            return Err(Self::LinkWhileEnabled {
                fault: *fault,
                warning: station.link_warning(),
            });
        }
        if let Some(text) = left_on(&end.left_on) {
            tell(text);
        }
        if moved.is_err() && !end.disabled.is_empty() {
            // After an error nobody prints the end of a motion.
            tell(about(
                &end.disabled,
                "is disabled again",
                "are disabled again",
            ));
        }
        if end.unconfirmed.is_empty() {
            return moved.map(|moved| (moved, end));
        }
        Err(Self::StillEnabled {
            drives: end.unconfirmed,
            after: moved.err().map(Box::new),
        })
    }
}

impl Coded for DrivesError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Open(_)
            | Self::Link(_)
            | Self::NothingGetsOut
            | Self::LinkWhileEnabled { .. }
            | Self::Look(LookError::Link(_))
            | Self::BringUp(
                BringUpError::Link(_)
                | BringUpError::Fault {
                    fault: Fault::Bus, ..
                },
            )
            | Self::DriveFault {
                fault: Fault::Bus, ..
            } => exit::LINK_FAILED,
            Self::Interrupted
            | Self::Look(LookError::Interrupted)
            | Self::BringUp(BringUpError::Interrupted) => exit::INTERRUPTED,
            Self::StillEnabled {
                after: Some(error), ..
            } => error.exit_code(),
            Self::Config(_)
            | Self::Interrupt(_)
            | Self::Origins(_)
            | Self::OutsideTravel { .. }
            | Self::NotConfirmed(_)
            | Self::CanopenOnSerial
            | Self::NoIdOnCan
            | Self::NotOnSerial { .. }
            | Self::SameId { .. }
            | Self::Twice { .. }
            | Self::Gear { .. }
            | Self::MoveRefused { .. }
            | Self::Enabled { .. }
            | Self::Look(LookError::Config(_)) => exit::BAD_INPUT,
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
            Self::NothingGetsOut => f.write_str(
                "no frame gets out to the bus: check --bit-rate, wiring and termination, and that at least one drive has power",
            ),
            Self::Interrupt(source) => write!(f, "cannot listen to Ctrl-C: {source}"),
            Self::Origins(source) => source.fmt(f),
            Self::OutsideTravel { drive, error } => {
                write!(f, "drive {drive}: {error}. Nothing has moved")
            }
            Self::NotConfirmed(source) => source.fmt(f),
            Self::MoveRefused { drive, reason } => {
                write!(f, "drive {drive}: {reason}. Nothing has moved")
            }
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
            Self::OnlyEchoes { drive } => write!(
                f,
                "drive {drive} does not answer, only what was sent comes back: check its power, its wiring and its id, or look with `motionctl scan`"
            ),
            Self::Several { drive } => write!(
                f,
                "more than one drive answers as drive {drive}: what is sent to one would reach all of them. Leave one of them connected and give it another id with `motionctl assign-id`; nothing was changed"
            ),
            Self::Assign(source) => source.fmt(f),
            Self::Interrupted => f.write_str("stopped by the user"),
            Self::SameId { id } => write!(f, "--from and --to are both {id}: nothing to do"),
            Self::NotOnSerial { what } => write!(
                f,
                "the serial protocol has no {what}: use CAN, with --slcan or --can; nothing was sent"
            ),
            Self::BadReply {
                drive,
                error: error @ DecodeError::OrderUnknown { .. },
            } => write!(f, "drive {drive}: {error} with --group3-order"),
            Self::BadReply { drive, error } => {
                write!(f, "a reply of drive {drive} cannot be read: {error}")
            }
            Self::Incomplete { drive } => {
                write!(
                    f,
                    "drive {drive} did not answer all requests in time: try again, or look for a second master"
                )
            }
            Self::Fault { drive, reason } => write!(f, "drive {drive}: {reason}"),
            Self::LinkWhileEnabled { fault, warning } => {
                write!(f, "the link failed: {fault}. {warning}")
            }
            Self::Look(source) => write!(f, "{source}. Nothing was switched and nothing has moved"),
            Self::BringUp(source) => source.fmt(f),
            Self::Gear {
                drive,
                expected,
                actual,
            } => write!(
                f,
                "drive {drive} has gear number {actual}, --gear-number says {expected}: correct one of the two. Nothing has moved"
            ),
            Self::Enabled { drive } => write!(
                f,
                "drive {drive} is enabled, and it takes no new values while its motor has power: `motionctl disable --drives {drive}` first, where nothing hangs on it"
            ),
            Self::DriveFault { drive, fault } => f.write_str(&fault_text(*drive, *fault)),
            Self::StillEnabled { drives, after } => {
                if let Some(error) = after {
                    write!(f, "{error}; and ")?;
                }
                f.write_str(&unconfirmed_warning(drives))
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
                }?;
                f.write_str(": the command was lost, or the drive refuses the value; try again, and check the line")
            }
            Self::Print(source) => write!(f, "cannot write the result: {source}"),
        }
    }
}

impl std::error::Error for DrivesError {}
