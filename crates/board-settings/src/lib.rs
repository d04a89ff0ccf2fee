#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(any(test, feature = "toml"))]
extern crate std;

mod axis;
mod board;
mod bytes;
mod configs;
#[cfg(feature = "toml")]
pub mod file;
mod refusal;
mod refusal_of_master;
mod settings;

pub use axis::{AxisSettings, Dialect, MotorLimits, Polls, ReadBack, Travel};
pub use board::Board;
pub use bytes::{LONGEST, VERSION};
pub use configs::Configs;
pub use refusal::{Kind, Refusal};
pub use settings::{BusSettings, Inputs, MOST_AXES, Name, Settings};
