#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod command;
mod error;
mod geometry;
mod limits;
mod odometry;
mod twist;
mod vehicle;

pub use command::{Command, Phase};
pub use error::{JumpError, ValueError};
pub use geometry::{Geometry, WheelSpeeds};
pub use limits::Limits;
pub use odometry::{Odometry, Pose};
pub use twist::Twist;
pub use vehicle::DiffDrive;
