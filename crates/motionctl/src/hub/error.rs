//! Why a command for hub motors did not succeed.

use core::fmt;
use std::io;

use can_motion::wheel::{WheelConfigError, WheelFault};
use zlac8030l::{AbortCode, FaultCode, NodeId, ObjectAddress, SdoEnd, dictionary};

use super::nodes::named;
use super::object::{ObjectSetting, address_text};
use crate::confirm::NotConfirmed;
use crate::exit::{self, Coded};
use crate::home::HomeError;
use crate::link::{LinkFault, OpenError};
use crate::recording::RecordingError;

/// A command that did not succeed.
#[derive(Debug)]
pub(super) enum HubError {
    /// The link cannot be opened.
    Open(OpenError),
    /// The link failed.
    Link(LinkFault),
    /// The link failed while drives may have power.
    LinkWhileEnabled {
        fault: LinkFault,
        nodes: Vec<NodeId>,
    },
    /// Nobody takes a frame.
    NothingGetsOut,
    /// Ctrl-C cannot be listened to.
    Interrupt(io::Error),
    /// The user asked to stop.
    Interrupted,
    /// Nobody agreed.
    NotConfirmed(NotConfirmed),
    /// The input cannot be used; nothing was sent.
    Input(String),
    /// A node is silent.
    NoAnswer {
        node: NodeId,
        address: ObjectAddress,
    },
    /// A write was not confirmed: it may have arrived.
    WriteInDoubt {
        node: NodeId,
        address: ObjectAddress,
    },
    /// The node answers with an abort.
    Refused {
        node: NodeId,
        address: ObjectAddress,
        code: AbortCode,
    },
    /// The answer makes no sense.
    BadReply {
        node: NodeId,
        address: ObjectAddress,
        reason: String,
    },
    /// The node is another device.
    OtherDevice {
        node: NodeId,
        address: ObjectAddress,
        expected: i64,
        actual: i64,
    },
    /// The drive is enabled, and settings are for drives without power.
    Enabled { node: NodeId },
    /// The drive has a fault.
    Fault { node: NodeId, fault: FaultCode },
    /// The fault stays.
    FaultStays { node: NodeId, fault: FaultCode },
    /// The drive reads back another value.
    NotTaken {
        node: NodeId,
        address: ObjectAddress,
        expected: i64,
        actual: i64,
    },
    /// The master refuses the configuration.
    Config(WheelConfigError),
    /// The wheel has a fault.
    WheelFault { node: NodeId, fault: WheelFault },
    /// The wheels did not become ready, or were refused.
    NotReady { node: NodeId, state: String },
    /// The drive does not say that it is off.
    StillEnabled {
        nodes: Vec<NodeId>,
        after: Option<Box<Self>>,
    },
    /// Somebody else is where the drive shall go.
    Taken { node: NodeId },
    /// Not everything that was to be written is.
    Unfinished { error: Box<Self>, is_started: bool },
    /// Objects that were changed for a while do not have their values again.
    NotBack {
        node: NodeId,
        left: Vec<ObjectSetting>,
        error: Box<Self>,
        after: Option<Box<Self>>,
    },
    /// A homing.
    Home(HomeError),
    /// A picture.
    Picture(String),
    /// A line of a stream could not be used, and the wheels were stopped there.
    Stream(String),
    /// The file of settings.
    File(String),
    /// The recording cannot begin.
    Recording(RecordingError),
    /// There is no terminal for the live view.
    Terminal(io::Error),
    /// The result cannot be written.
    Print(io::Error),
}

impl HubError {
    /// A transfer that ended without what it was for.
    pub(super) fn of_end(node: NodeId, address: ObjectAddress, end: SdoEnd) -> Self {
        match end {
            SdoEnd::Aborted(code) => Self::Refused {
                node,
                address,
                code,
            },
            SdoEnd::TimedOut => Self::NoAnswer { node, address },
            other => Self::BadReply {
                node,
                address,
                reason: other.to_string(),
            },
        }
    }
}

impl From<HomeError> for HubError {
    fn from(error: HomeError) -> Self {
        Self::Home(error)
    }
}

impl From<LinkFault> for HubError {
    fn from(fault: LinkFault) -> Self {
        Self::Link(fault)
    }
}

impl Coded for HubError {
    fn exit_code(&self) -> u8 {
        match self {
            Self::Open(_)
            | Self::Link(_)
            | Self::LinkWhileEnabled { .. }
            | Self::NothingGetsOut => exit::LINK_FAILED,
            Self::Interrupted => exit::INTERRUPTED,
            Self::StillEnabled {
                after: Some(error), ..
            } => error.exit_code(),
            Self::Unfinished {
                is_started: true, ..
            } => exit::PARTLY_DONE,
            Self::Unfinished { error, .. } => error.exit_code(),
            Self::Home(error) => error.exit_code(),
            Self::Interrupt(_)
            | Self::NotConfirmed(_)
            | Self::Input(_)
            | Self::Enabled { .. }
            | Self::Config(_)
            | Self::File(_) => exit::BAD_INPUT,
            _ => exit::BROKEN_PROMISE,
        }
    }
}

/// An object with its name.
fn with_name(address: ObjectAddress) -> String {
    match dictionary::find(address) {
        Some(entry) => format!("{} ({})", address_text(address), entry.name),
        None => address_text(address),
    }
}

impl fmt::Display for HubError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Open(source) => source.fmt(f),
            Self::Link(source) => write!(f, "the link failed: {source}"),
            Self::LinkWhileEnabled { fault, nodes } => write!(
                f,
                "the link failed: {fault}. No command gets through any more, and {} may still be ENABLED and turn until its own supervision (2000h) stops it: use the emergency stop before you go near",
                named(nodes)
            ),
            Self::NothingGetsOut => f.write_str(
                "no frame gets out to the bus: check --bit-rate (hub motors leave the factory with 500), wiring and termination, and that at least one drive has power",
            ),
            Self::Interrupt(source) => write!(f, "cannot listen to Ctrl-C: {source}"),
            Self::Interrupted => f.write_str("stopped by the user"),
            Self::NotConfirmed(source) => source.fmt(f),
            Self::Input(text) | Self::File(text) | Self::Stream(text) => f.write_str(text),
            Self::NoAnswer { node, address } => write!(
                f,
                "node {node} does not answer to a read of {}: check its power, wiring, termination, bit rate and node number, or look with `motionctl scan --drives zlac`",
                with_name(*address)
            ),
            Self::WriteInDoubt { node, address } => write!(
                f,
                "node {node} did not confirm the write of {}: it may have taken it or not; check its power and wiring, then read it back with `motionctl read --drives zlac:{node} {}`",
                with_name(*address),
                address_text(*address)
            ),
            Self::Refused {
                node,
                address,
                code,
            } => write!(f, "node {node} refuses {}: {code}", with_name(*address)),
            Self::BadReply {
                node,
                address,
                reason,
            } => write!(
                f,
                "the answer of node {node} for {} cannot be read: {reason}",
                with_name(*address)
            ),
            Self::OtherDevice {
                node,
                address,
                expected,
                actual,
            } => write!(
                f,
                "node {node} is no ZLAC8030L: {} is {actual:X}h, expected {expected:X}h. On other devices the same objects mean something else; nothing was written",
                with_name(*address)
            ),
            Self::Enabled { node } => write!(
                f,
                "node {node} is enabled, and settings are written to drives without power only: `motionctl disable --drives zlac:{node}` first, where nothing hangs on it"
            ),
            Self::Fault { node, fault } => write!(
                f,
                "node {node} has a fault ({fault}): remove its cause, then `motionctl reset --drives zlac:{node}`"
            ),
            Self::FaultStays { node, fault } => write!(
                f,
                "node {node} still reports {fault} after its reset: its cause is still there"
            ),
            Self::NotTaken {
                node,
                address,
                expected,
                actual,
            } => write!(
                f,
                "node {node} did not take {} = {expected}, it reads back {actual}: its firmware refuses the value without a word, or somebody else writes to it",
                with_name(*address)
            ),
            Self::Config(source) => source.fmt(f),
            Self::WheelFault { node, fault } => write!(f, "node {node}: {fault}{}", advice(fault)),
            Self::NotReady { node, state } => write!(
                f,
                "node {node} is still {state}: try again, or look for a second master"
            ),
            Self::StillEnabled { nodes, after } => {
                if let Some(error) = after {
                    write!(f, "{error}; and ")?;
                }
                write!(
                    f,
                    "{} did not confirm that its power is OFF: use the emergency stop before you go near",
                    named(nodes)
                )
            }
            Self::Taken { node } => write!(
                f,
                "node {node} answers already: two drives with one number cannot be told apart. Choose another --to; nothing was written"
            ),
            Self::Unfinished { error, is_started } => {
                let state = if *is_started {
                    "What is listed as written is in the RAM of the drive and was not saved: a power cycle undoes it"
                } else {
                    "Nothing was written"
                };
                write!(f, "{error}. {state}")
            }
            Self::Recording(source) => source.fmt(f),
            Self::Terminal(source) => write!(
                f,
                "the live view needs a terminal ({source}): leave out --live, or use --report"
            ),
            Self::NotBack {
                node,
                left,
                error,
                after,
            } => {
                if let Some(after) = after {
                    write!(f, "{after}; and ")?;
                }
                write!(
                    f,
                    "objects of node {node} do NOT have their values again: {error}. Switch its power off and on, which brings them back, or write"
                )?;
                for setting in left {
                    write!(f, " {setting}")?;
                }
                Ok(())
            }
            Self::Home(source) => source.fmt(f),
            Self::Picture(reason) => write!(f, "cannot draw the picture: {reason}"),
            Self::Print(source) => write!(f, "cannot write the result: {source}"),
        }
    }
}

/// What to do about a fault of a wheel.
fn advice(fault: &WheelFault) -> &'static str {
    match fault {
        WheelFault::Lost => {
            ". Check its power, wiring, termination, bit rate and node number, or look with `motionctl scan --drives zlac`"
        }
        WheelFault::Drive(_) | WheelFault::Emergency(_) => {
            ". Remove the cause, then `motionctl reset --drives zlac`"
        }
        WheelFault::EmergencyInput => {
            ". Release it; where no button is wired, `motionctl write --drives zlac 2030h:02=0` takes its function away"
        }
        WheelFault::SwitchedOn | WheelFault::NotOperational(_) => ". Look for a second master",
        WheelFault::SpeedResolution { .. } => ". Give the drive's number with --speed-resolution",
        _ => "",
    }
}

impl std::error::Error for HubError {}
