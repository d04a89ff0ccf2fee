#![doc = include_str!("../README.md")]
#![deny(unsafe_code)]

mod channel;
mod channel_name;
mod error;
mod library;
mod message;
mod status;

pub use channel::{Channel, Mode};
pub use channel_name::{BadName, ChannelName};
pub use error::Error;
pub use library::PcanBasic;
pub use message::Message;
pub use status::Status;
