#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod admission;
pub mod board;
mod buffer;
mod config;
pub mod frame;
pub mod host;
pub mod message;
mod outbox;
mod playback;
mod polynomial;
mod rate;
mod reason;
mod refusal;
mod refused;
pub mod segment;
mod stretch;

pub use buffer::{Counters, Phase, SetPointBuffer};
pub use config::{AxisLimits, Config, WhenDry};
pub use reason::{Reason, Unit};
pub use refusal::Refusal;
pub use refused::Refused;
