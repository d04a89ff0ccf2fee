//! Servo axes: DYN2 and DYN4 drives.
//!
//! Each cycle every axis in motion gets one `Go_Relative_Pos_PD` with the step from where its set-points have taken it towards its
//! target. Steps are relative, so the ledger counts each one: see `docs/master.md`.

mod activity;
mod ask;
mod books;
pub mod bus_frames;
pub(crate) mod config;
mod drift;
mod drive;
mod dyn_family;
mod event;
mod family;
mod fault;
mod feedback;
mod frames;
mod latest;
mod ledger;
mod own_move;
mod placement;
pub(crate) mod plan;
pub(crate) mod poll_kind;
mod polls;
mod procedure;
mod procedures;
mod readings;
mod request_slot;
mod response_watch;
mod settings;
mod snapshot;

pub use config::{
    AxisConfig, ConfigError, DialectChoice, Limits, LimitsError, MasterConfig, MotorLimits,
    PollPeriods, ReadBackScale, StepChange, Timeouts, Travel,
};
pub use drive::Servo;
pub use dyn_family::Dyn;
pub use event::EventKind;
pub use family::ServoMaster;
pub use fault::{DriftCause, Fault, Reactions};
pub use feedback::Feedback;
pub use placement::Aligned;
pub use poll_kind::PollKind;
pub use procedure::{Procedure, ProcedureEnd, ProcedureError, WearLimits};
pub use snapshot::AxisSnapshot;
