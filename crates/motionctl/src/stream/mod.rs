//! Set-points that arrive while the motion runs: lines from standard input, a port or a socket file.
//!
//! A thread reads lines and makes set-points of them ([`parser`]), the cycle takes them ([`conversation`]) into the buffer of `board-link`
//! ([`source`]), or whoever commands a board makes segments of them; another thread writes the answers ([`answer`]). Nothing that a sender does or does not do holds up a cycle: both channels are
//! bounded, and the cycle never waits for one. docs/stream.md is the protocol.

mod answer;
mod conversation;
mod options;
mod parser;
mod session;
mod source;

pub(crate) use conversation::{Conversation, SetPointTaker, StreamReport, status};
pub(crate) use options::{LONGEST_GAP_S, StreamOptions, WhenDryOption, positive};
pub(crate) use session::Open;
