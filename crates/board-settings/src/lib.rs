#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(any(test, feature = "toml"))]
extern crate std;

mod axis;
mod board;
mod bytes;
mod configs;
#[cfg(feature = "homing")]
mod configs_of_homing;
mod fault;
#[cfg(feature = "toml")]
pub mod file;
mod homing;
mod refusal;
#[cfg(feature = "homing")]
mod refusal_of_abort;
mod refusal_of_master;
#[cfg(feature = "homing")]
mod sequence;
mod settings;

pub use axis::{AxisSettings, Dialect, MotorLimits, Polls, ReadBack, Travel};
pub use board::Board;
pub use bytes::{LONGEST, VERSION};
pub use configs::Configs;
#[cfg(feature = "homing")]
pub use configs_of_homing::AxisHoming;
pub use fault::FaultNumber;
pub use homing::{HomingDirection, HomingMethod, HomingSearch, HomingSettings, SwitchLevel};
pub use refusal::{Kind, Refusal};
#[cfg(feature = "homing")]
pub use sequence::{HomingSequence, HomingStep};
pub use settings::{BusSettings, Inputs, MOST_AXES, Name, Settings};
