//! How a client treats a board, and what it tells the program.

use super::exchange::RequestError;
use super::stream::StreamEnd;
use crate::message::{Answer, Event, Snapshot};
use crate::refused::Refused;

/// How a client treats a board.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ClientConfig {
    /// A request without a reply is repeated after so long.
    pub timeout_us: u32,
    /// So often at most.
    pub tries: u8,
    /// The board is asked for a sign of life this often, at most.
    pub heartbeat_us: u32,
    /// Its clock is looked at this often.
    pub sync_us: u32,
    /// Whether the client commands; otherwise it only reads.
    pub commands: bool,
}

impl Default for ClientConfig {
    /// 100 ms, 15 tries, 50 ms, 1 s, commands. A board may stand still for 1.1 s while it stores its faults.
    fn default() -> Self {
        Self {
            timeout_us: 100_000,
            tries: 15,
            heartbeat_us: 50_000,
            sync_us: 1_000_000,
            commands: true,
        }
    }
}

/// What the program is told.
#[derive(Debug, Clone, PartialEq)]
#[allow(clippy::large_enum_variant, reason = "there is no heap")]
pub enum Incoming {
    /// The board has answered, and the command is claimed where it shall be.
    Connected {
        /// Whether the board was started anew since it was connected before.
        is_reset: bool,
    },
    /// The board does not answer, or does not know the session any more. The client connects again by itself.
    Disconnected,
    /// The board cannot be connected: another version, or another session commands. The client goes on trying.
    Unavailable(Refused),
    /// A request has its reply, or none.
    Reply {
        /// That of [`Client::request`](super::Client::request).
        ticket: u16,
        /// What came.
        result: Result<Answer, RequestError>,
    },
    /// The stream has ended for the client.
    Stream(StreamEnd),
    /// Something has happened on the board.
    Event {
        /// Its number.
        number: u32,
        /// What.
        event: Event,
    },
    /// So many events were overwritten before they could be fetched.
    EventsLost(u32),
    /// How everything is.
    Snapshot(Snapshot),
}
