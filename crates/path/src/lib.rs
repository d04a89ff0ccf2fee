#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod angle;
mod bounds;
mod corner;
mod error;
mod filter;
mod front;
mod length;
pub mod machine;
mod order;
mod path;
mod queue;
mod roots;
mod shape;
pub mod tables;

pub use error::PathError;
pub use machine::Machine;
pub use path::{Arc, Join, Path};
