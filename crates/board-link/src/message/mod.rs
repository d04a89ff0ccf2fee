//! The messages between a host and a motion board.
//!
//! In a frame is one message as postcard writes it: fields in their order, integers of more than 8 bits as varints (signed ones zigzag),
//! an enum as the number of its variant and its fields. A variant keeps its number for ever; new ones come at the end.

mod bounds;
mod reply;
mod report;
mod request;
mod to_host;

pub use crate::reason::{Reason, Unit};
pub use crate::refused::Refused;
pub use bounds::{Chunk, Text};
pub use reply::{Answer, Counters, FaultEntry, Info};
pub use report::{AxisSnapshot, BoardState, Event, Origin, Snapshot};
pub use request::{Request, ToBoard};
pub use to_host::ToHost;
