//! A message of a board.

use serde::{Deserialize, Serialize};

use super::{Answer, Event, Snapshot};
use crate::refused::Refused;

/// A message of a board.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(
    clippy::large_enum_variant,
    reason = "there is no heap, and each lives for one call"
)]
pub enum ToHost {
    /// To a request.
    Reply {
        /// That of the request; 0 where it could not be read.
        number: u16,
        /// What was asked for, or why it is refused.
        result: Result<Answer, Refused>,
    },
    /// Something has happened.
    Event {
        /// One more than that of the event before.
        number: u32,
        /// What.
        event: Event,
    },
    /// How everything is, at the rate that was asked for.
    Snapshot(Snapshot),
}
