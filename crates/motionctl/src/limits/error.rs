//! Why a limit could not be measured.

use core::fmt;

use can_motion::{CommandError, ConfigError, Fault, TargetError};
use drive_sim::EmptyOutage;

/// A run that did not come to its end.
#[derive(Debug)]
pub(crate) enum LimitsError {
    /// The master does not take this load.
    Refused(ConfigError),
    /// The axes did not stream in time.
    StartUp {
        /// The fault that kept them from it.
        fault: Option<Fault>,
    },
    /// The axes could not be enabled.
    Enable(CommandError<Fault>),
    /// A target was refused.
    Target(TargetError),
    /// An axis got a fault while it streamed.
    Fault(Fault),
    /// The outage is empty.
    Outage(EmptyOutage),
    /// The figures cannot be written.
    Print(std::io::Error),
}

impl fmt::Display for LimitsError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(error) => error.fmt(f),
            Self::StartUp { fault: Some(fault) } => {
                write!(f, "the simulated axes do not stream: {fault}")
            }
            Self::StartUp { fault: None } => {
                f.write_str("the simulated axes do not stream in time")
            }
            Self::Enable(error) => error.fmt(f),
            Self::Target(error) => error.fmt(f),
            Self::Fault(fault) => write!(f, "a simulated axis stopped: {fault}"),
            Self::Outage(error) => error.fmt(f),
            Self::Print(error) => write!(f, "cannot write the figures: {error}"),
        }
    }
}

impl std::error::Error for LimitsError {}
