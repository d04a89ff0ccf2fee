#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod bit_rates;
mod byte_order;
mod dialect;
mod error;
mod frame;
mod function;
mod id;
mod number;
mod parameter_change;
mod parameters;
mod reply;
mod request;
mod revision;
mod selectors;
pub mod units;

pub use bit_rates::{BIT_RATES, knows_bit_rate};
pub use byte_order::ByteOrder;
pub use can_frame::{DataFrame, FrameError};
pub use dialect::{
    Dialect, Group3ReplyOrder, Rotation, SetOriginData, TorqueFullScale, ZeroAddress,
};
pub use error::{DecodeError, EncodeError};
pub use frame::DynFrame;
pub use function::{FunctionCode, Refusal};
pub use id::{Address, DriveId};
pub use parameters::{
    ParamGroup1, ParamGroup2, ParamGroup3, SetParamGroup1, SetParamGroup2, SetParamGroup3,
};
pub use reply::{Reply, ReplyKind, Torque};
pub use request::{Request, go_relative_pos_pd};
pub use revision::Revision;
pub use selectors::{DriveError, ReadSelector, ServoSwitch, StoredDriveId, SyncKind};
// The values that the serial protocol of the same drives carries as well, and those of this one.
pub use dyn_values::{
    Alarm, Amplitude, CommandMode, ConfigByte, Counts28, DriveConfig, DriveStatus, FrequencyHz,
    GearNumber, IntegrationGain, LineNumber, MainGain, MaxAcceleration, MaxSpeed, OnPosRange,
    PdStep, Quantity, RangeError, ServoMode, SpeedGain, SpeedRpm, StepLimit, TorqueFilter,
    UnknownAlarm,
};
