#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod abort;
mod config;
mod frame;
mod inputs;
mod mover;
mod power_loss;
mod run;

pub use abort::{Abort, Awaited};
pub use config::{Config, Direction, HardStop, Level, Method, Refusal, Switch, Travel, Watch};
pub use frame::{Frame, OutsideTravel};
pub use inputs::{Inputs, Reading};
pub use power_loss::{AfterPowerLoss, PositionMemory};
pub use run::{Home, Homing, Progress};
