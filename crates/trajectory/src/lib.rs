#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod bisection;
mod builder;
mod fixed;
mod jerk;
mod limits;
mod profile;
mod quantity;
mod segment;

pub use builder::PlanError;
pub use limits::{Limits, Quantity, RangeError, State};
pub use profile::{Profile, Stretch};
pub use quantity::{Position, Time};
