#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod angle;
mod backlash;
mod bounds;
mod corner;
mod error;
mod filter;
mod front;
mod inbox;
mod known;
mod length;
pub mod machine;
mod measure;
mod order;
mod path;
mod plan;
mod preparation;
mod queue;
mod request;
mod roots;
mod shape;
mod step;
pub mod tables;
mod tool;

pub use error::PathError;
pub use machine::Machine;
pub use path::Path;
pub use request::{Arc, Join};
