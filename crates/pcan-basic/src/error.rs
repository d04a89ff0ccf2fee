//! Why a channel cannot be opened.

use crate::{ChannelName, Status};

/// A channel that cannot be opened. The text says what to do about it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The library is not installed.
    #[error(
        "there is no {library} ({reason}): it belongs to PEAK's drivers; install \"Device driver setup\" with PCAN-Basic from peak-system.com"
    )]
    NoLibrary {
        /// What was looked for.
        library: String,
        /// What the system says.
        reason: String,
    },
    /// A library of this name lacks a function.
    #[error(
        "{library} has no function {function}: expected PCAN-Basic 4 or later, install it from peak-system.com"
    )]
    NoFunction {
        /// The library.
        library: String,
        /// The function.
        function: &'static str,
    },
    /// PCAN-Basic has no register values for this bit rate here.
    #[error("expected 10, 20, 50, 100, 125, 250, 500, 800 or 1000 kbit/s, got {kbit_per_s}")]
    BitRate {
        /// The bit rate that was asked for.
        kbit_per_s: u32,
    },
    /// The driver of the adapters is not running.
    #[error("the driver of the PCAN adapters is not loaded: install it from peak-system.com")]
    NoDriver,
    /// No adapter has this channel.
    #[error("there is no adapter at {channel}: is it plugged in? PCAN-View lists the channels")]
    NoAdapter {
        /// The channel.
        channel: ChannelName,
    },
    /// Another program has the channel.
    #[error("{channel} is in use by another program: end that one first")]
    Busy {
        /// The channel.
        channel: ChannelName,
    },
    /// Another program has opened the channel with another bit rate.
    #[error(
        "{channel} runs at another bit rate than {kbit_per_s} kbit/s{}: another program (PCAN-View?) has set it; end that one, or choose its rate",
        actual.map_or(String::new(), |rate| format!(", at {} kbit/s", f64::from(rate) * 1e-3))
    )]
    OtherBitRate {
        /// The channel.
        channel: ChannelName,
        /// The bit rate that was asked for.
        kbit_per_s: u32,
        /// The bit rate that is in force, in bit/s, where the library says so.
        actual: Option<u32>,
    },
    /// The adapter cannot listen without acknowledging.
    #[error("{channel} cannot listen without acknowledging ({status})")]
    NoListenOnly {
        /// The channel.
        channel: ChannelName,
        /// What the library answers.
        status: Status,
    },
    /// Something else.
    #[error("{text} ({status})")]
    Other {
        /// What the library says about it.
        text: String,
        /// What it answers.
        status: Status,
    },
}
