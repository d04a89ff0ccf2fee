//! The end of a host: requests out, replies in, and a stream of segments that is kept ahead of the board.
//!
//! Without I/O, without a clock: `now_us` is any clock of the host in microseconds. With `std` or without.

mod client;
mod clock;
mod connection;
mod events;
mod exchange;
mod streaming;

pub use client::{Client, ClientConfig, Incoming};
pub use clock::ClockEstimate;
pub use exchange::RequestError;
pub use streaming::StreamEnd;
