//! The seam between `service` and whoever uses the bus.

use dyn_can::{DataFrame, FrameError};

use crate::event::BusErrorKind;
use crate::time::Instant;

/// Something that sends and receives frames without knowing a driver: the [`Master`](crate::Master) while machines move,
/// a [`Commissioner`](crate::commission::Commissioner) before.
pub trait BusUser {
    /// A frame with what it means to its sender.
    type Outgoing: AsRef<DataFrame>;

    /// The frame that should go out next; asking changes nothing.
    fn next_frame(&self) -> Option<Self::Outgoing>;

    /// The controller accepted a frame: now it counts.
    fn on_accepted(&mut self, now: Instant, outgoing: &Self::Outgoing);

    /// The controller gave back a frame that it had accepted, unsent, to make room for a more urgent one.
    fn on_displaced(&mut self, now: Instant, frame: &DataFrame);

    /// The controller failed while it took a frame: whether that frame goes out is not known.
    fn on_transmit_error(&mut self, now: Instant, outgoing: &Self::Outgoing, kind: BusErrorKind);

    /// The controller reports an error while receiving.
    fn on_receive_error(&mut self, now: Instant, kind: BusErrorKind);

    /// A frame came in.
    fn on_frame(&mut self, now: Instant, frame: &DataFrame);

    /// A frame came in, or back, that cannot belong to this protocol.
    fn on_foreign_frame(&mut self, now: Instant, error: FrameError);
}
