#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod core;
mod servo;
#[cfg(feature = "zlac")]
pub mod wheel;

pub use crate::core::command::{CommandError, MoveError, TargetError};
pub use crate::core::drive_move::{DriveMove, MoveEnd, MoveRefusal, WaveShape};
pub use crate::core::event::{CommonEvent, Event, EventLog};
pub use crate::core::family::{GroupId, Reaction};
pub use crate::core::master::Master;
pub use crate::core::procedure::Confirmation;
pub use crate::core::snapshot::{Counters, CycleCounters, Stamped};
pub use crate::core::state::{AxisState, Reason, Stage};
pub use bus_user::{
    BusErrorKind, BusFrame, BusUser, Instant, Outcome, Progress, Sink, service, service_taking_back,
};
pub use servo::{
    Aligned, AxisConfig, AxisSnapshot, ConfigError, DialectChoice, DriftCause, Dyn, EventKind,
    Fault, Feedback, Limits, LimitsError, MasterConfig, MotorLimits, PollKind, PollPeriods,
    Procedure, ProcedureEnd, ProcedureError, Reactions, ReadBackScale, Servo, ServoMaster,
    StepChange, Timeouts, Travel, WearLimits,
};

/// Whether a bus carries its axes, proved before anything moves: the crate [`bus_plan`], and what servo axes put on a bus.
pub mod plan {
    pub use crate::servo::bus_frames as frames;
    pub use crate::servo::plan::BusPlan;
    pub use bus_plan::{
        BitRate, BusSetup, Canopen, CanopenService, Clash, Refusal, Remedies, RequestMix,
        ResponseWindow, TxOrder, Warning, analysis, streams, wire,
    };
}

/// The facts of an axis, the pure function that changes them, and the exit for frames.
pub mod facts {
    pub use crate::core::exit::{Class, may_leave};
    pub use crate::core::facts::{Brake, Facts, Goal, Knowledge, Latch, Motion, Power, Work};
    pub use crate::core::step::{Input, Loss, accepts, step, transition};
}

/// What a family of drives implements: `examples/third_family.rs` is one.
pub mod family {
    pub use crate::core::drive_move::MoveReport;
    pub use crate::core::family::{
        CommonFault, Context, CycleConfig, CycleUs, Drive, Family, FaultKind, FaultOf, FrameOf,
        Meaning, OutOfTravel, Outlook, Plan, PowerReport, ProcedureRefusal, RequestOf, Returned,
        Unplanned, View, Wanted,
    };
    pub use crate::core::placement::{BehindFrames, RequestPlacement};
    pub use crate::core::targets::{AbsoluteLedger, ValueKind, ValueLimits};
    pub use bus_plan::ResponseWindow;
}
