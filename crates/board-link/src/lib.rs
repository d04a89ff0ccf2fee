#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod admission;
mod buffer;
mod config;
mod playback;
mod polynomial;
mod rate;
mod refusal;
mod refused;
pub mod segment;
mod stretch;

pub use buffer::{Counters, Phase, SetPointBuffer};
pub use config::{AxisLimits, Config, WhenDry};
pub use refusal::Refusal;
pub use refused::{Reason, Refused, Unit};
