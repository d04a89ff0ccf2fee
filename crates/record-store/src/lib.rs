#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

mod flash;
mod head;
mod store;

pub use flash::{Area, Flash, Reading};
pub use store::{Store, StoreError};
