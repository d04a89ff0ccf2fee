#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod address;
mod client;
mod config;
mod dialect;
mod error;
mod function;
mod groups;
mod moves;
mod packet;
mod reply;
mod request;
#[cfg(feature = "embedded-io")]
mod service;
mod stream;

pub use address::{Address, DriveId};
pub use client::{Answer, BYTE_US, Busy, Client, Failure, Poll, Timing, Traffic};
pub use config::ConfigByte;
pub use dialect::{Dialect, GeneralId, ParameterForm};
pub use error::{DecodeError, EncodeError, Function, PacketError};
pub use function::{ReplyFunction, RequestFunction};
pub use moves::{CircularMove, LinearMove, Turn};
pub use packet::{MAX_PACKET, MIN_PACKET, Packet};
pub use reply::Reply;
pub use request::{ReadSelector, Request};
#[cfg(feature = "embedded-io")]
pub use service::{MAX_BYTES_A_CALL, service};
pub use stream::{Decoder, Event, Fragment, LineCounters};
// The values that the CAN protocol of the same drives carries as well, and those of this one.
pub use dyn_values::{
    Alarm, Amplitude, CommandMode, Counts28, DriveConfig, DriveStatus, Dummy, FeedRate,
    FrequencyHz, GearNumber, IntegrationGain, MainGain, MaxAcceleration, MaxSpeed, OnPosRange,
    Quantity, RangeError, ServoMode, SpeedGain, SpeedRpm, TorqueFilter, UnknownAlarm,
};
