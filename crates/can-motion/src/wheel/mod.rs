//! Wheels: ZLAC8030L hub-motor drives on CANopen, driven by the same [`Master`](crate::Master).
//!
//! Each cycle every drive that is set up gets one PDO with its control word and its target, a speed or a position. Targets are
//! absolute, so a lost frame costs a cycle and no position. The PDO goes out in every state from `Ready` on, because a wheel
//! does not stop when its master falls silent: a stop is a frame (control word 2 or 0), and the drive's own supervision (2000h)
//! hears that the master lives. Feedback comes by two PDOs of the drive, by timer or by SYNC; SDO transfers run in the gaps,
//! one a drive.
//!
//! ```text
//!  control word and target --> RPDO1: 6040h, 60FFh (velocity), 607Ah (position) or 6071h (torque)
//!  status, fault, speed    <-- TPDO0: 6041h, 603Fh, 606Ch
//!  position, torque        <-- TPDO1: 6064h, 6077h
//! ```
//!
//! What the states of [`AxisState`](crate::AxisState) mean for a wheel is in `docs/wheels.md`.

mod arrival;
pub(crate) mod config;
mod drive;
mod event;
mod family;
mod fault;
mod feedback;
mod frames;
mod plan;
mod process_data;
mod readings;
mod request;
mod set_up;
mod transfer;
mod way;
mod zlac_family;

pub use config::{
    FeedbackTiming, WheelArrival, WheelConfig, WheelConfigError, WheelLimits, WheelMasterConfig,
    WheelMode, WheelPolls, WheelStops, WheelTimeouts,
};
pub use drive::Wheel;
pub use event::WheelEventKind;
pub use family::WheelMaster;
pub use fault::{WheelFault, WheelReactions};
pub use feedback::{WheelFeedback, WheelSnapshot};
pub use plan::{STREAMS, WheelPlan};
pub use request::{HealthReading, Purpose, WheelRequest};
pub use transfer::TransferError;
pub use zlac_family::Zlac;
