#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod alarm;
mod config;
mod numbers;
mod quantity;
mod status;

pub use alarm::{Alarm, UnknownAlarm};
pub use config::{CommandMode, ConfigByte, DriveConfig, ServoMode};
pub use numbers::{
    Amplitude, Counts28, Dummy, FeedRate, FrequencyHz, GearNumber, IntegrationGain, LineNumber,
    MainGain, MaxAcceleration, MaxSpeed, OnPosRange, PdStep, SpeedGain, SpeedRpm, StepLimit,
    TorqueFilter,
};
pub use quantity::{Quantity, RangeError};
pub use status::DriveStatus;
