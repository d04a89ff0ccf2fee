#![doc = include_str!("../README.md")]
#![no_std]
#![forbid(unsafe_code)]

mod error;
mod service;
mod sink;
mod time;

pub use error::BusErrorKind;
pub use service::{service, service_taking_back};
pub use sink::{BusFrame, BusUser, Outcome, Progress, Sink};
pub use time::Instant;
