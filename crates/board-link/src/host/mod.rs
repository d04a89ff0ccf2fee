//! The end of a host: requests out, replies in, and a stream of segments that is kept ahead of the board.
//!
//! Without I/O, without a clock: `now_us` is any clock of the host in microseconds. With `std` or without.

mod client;
mod clock;
mod connecting;
mod connection;
mod events;
mod exchange;
mod incoming;
mod set_points;
mod stream;
mod streaming;
mod taking_events;

pub use client::Client;
pub use clock::ClockEstimate;
pub use exchange::RequestError;
pub use incoming::{ClientConfig, Incoming};
pub use set_points::{SegmentMaker, SegmentMakerConfig};
pub use stream::StreamEnd;
