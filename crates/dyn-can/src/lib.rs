#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod config;
mod dialect;
mod error;
mod frame;
mod id;
mod number;
mod parameters;
mod reply;
mod request;
mod selectors;
mod status;
pub mod units;
mod values;

pub use config::{CommandMode, ConfigByte, DriveConfig, ServoMode};
pub use dialect::{
    Dialect, Group3ReplyOrder, Revision, SetOriginData, TorqueFullScale, ZeroAddress,
};
pub use error::{DecodeError, EncodeError, FrameError, RangeError, Refusal};
pub use frame::DataFrame;
pub use id::{Address, DriveId, FunctionCode};
pub use number::ByteOrder;
pub use parameters::{
    ParamGroup1, ParamGroup2, ParamGroup3, SetParamGroup1, SetParamGroup2, SetParamGroup3,
};
pub use reply::{Reply, ReplyKind, Torque};
pub use request::{Request, go_relative_pos_pd};
pub use selectors::{DriveError, ReadSelector, ServoSwitch, StoredDriveId, SyncKind};
pub use status::{Alarm, DriveStatus, UnknownAlarm};
pub use values::{
    Amplitude, Counts28, FrequencyHz, GearNumber, IntegrationGain, LineNumber, MainGain,
    MaxAcceleration, MaxSpeed, OnPosRange, PdStep, Quantity, SpeedGain, SpeedRpm, StepLimit,
    TorqueFilter,
};
