#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

#[cfg(test)]
extern crate std;

mod bit_rate;
mod error;
mod frame;
pub mod wire;
mod worst_case;
#[cfg(test)]
mod worst_case_search;

pub use bit_rate::{BitRate, UnsupportedBitRate};
pub use error::FrameError;
pub use frame::DataFrame;
