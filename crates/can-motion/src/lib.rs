#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod axis;
mod bus_user;
mod command;
pub mod commission;
mod config;
mod drift;
mod dyn_axes;
mod event;
mod family;
mod fault;
mod feedback;
mod group;
mod life;
mod master;
pub mod motion;
mod outgoing;
mod placement;
pub mod plan;
mod polls;
mod procedure;
mod ramp;
mod request_choice;
mod request_slot;
mod response_watch;
mod service;
mod set_point;
mod snapshot;
mod time;
mod traffic;
#[cfg(feature = "zlac")]
pub mod wheel;

pub use bus_user::{BusFrame, BusUser};
pub use command::{CommandError, TargetError};
pub use config::{
    AxisConfig, ConfigError, DialectChoice, GroupId, Limits, MasterConfig, PollPeriods,
    ReadBackScale, Timeouts,
};
pub use dyn_axes::Dyn;
pub use event::{BusErrorKind, Event, EventKind};
pub use family::{CycleConfig, Family, FaultKind, Happening};
pub use fault::{DriftCause, Fault, Reaction, Reactions};
pub use feedback::{Feedback, Stamped};
pub use life::{AxisState, Reason};
pub use master::Master;
pub use outgoing::Outgoing;
pub use polls::PollKind;
pub use procedure::{Confirmation, Procedure, ProcedureEnd, ProcedureError, WearLimits};
pub use service::{Progress, service};
pub use snapshot::{AxisSnapshot, Counters, CycleCounters};
pub use time::Instant;
