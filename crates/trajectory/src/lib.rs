#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod bisection;
mod builder;
pub mod curve;
pub mod fixed;
mod jerk;
mod limits;
mod plan;
mod profile;
mod quantity;
mod segment;
mod time_scale;
mod tracker;
mod trapezoid;
pub mod units;
pub mod whole_counts;

pub use builder::PlanError;
pub use limits::{Limits, Quantity, RangeError, State};
pub use profile::{Profile, Stretch};
pub use quantity::{Position, Time};
pub use time_scale::{TimeScale, TimeScaleError};
pub use tracker::Tracker;
