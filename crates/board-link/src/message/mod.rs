//! The messages between a host and a motion board.
//!
//! In a frame is one message as postcard writes it: fields in their order, integers of more than 8 bits as varints (signed ones zigzag),
//! an enum as the number of its variant and its fields. A variant keeps its number for ever; new ones come at the end.

mod reply;
mod report;
mod request;

use heapless::{String, Vec};

pub use crate::refused::{Reason, Refused, Unit};
pub use reply::{Answer, Counters, FaultEntry, Info};
pub use report::{AxisSnapshot, BoardState, Event, Snapshot};
pub use request::{Request, ToBoard};

use serde::{Deserialize, Serialize};

/// A short text.
pub type Text = String<32>;
/// A piece of the settings.
pub type Chunk = Vec<u8, 128>;

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
