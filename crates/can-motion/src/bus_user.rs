//! The seam between `service` and whoever uses the bus.

use embedded_can::Frame;

use crate::event::BusErrorKind;
use crate::time::Instant;

/// A frame of one protocol, which every driver's frame can carry.
pub trait BusFrame: Sized {
    /// Why a frame on the bus cannot be of this protocol.
    type Error;

    /// Reads a driver's frame.
    ///
    /// # Errors
    /// `Error` when no frame of this protocol looks like that.
    fn from_can(frame: &impl Frame) -> Result<Self, Self::Error>;

    /// Makes a driver's frame; `None` when that type refuses it.
    fn to_can<F: Frame>(&self) -> Option<F>;
}

impl BusFrame for can_frame::DataFrame {
    type Error = can_frame::FrameError;

    fn from_can(frame: &impl Frame) -> Result<Self, Self::Error> {
        Self::from_can(frame)
    }

    fn to_can<F: Frame>(&self) -> Option<F> {
        self.to_can()
    }
}

/// Something that sends and receives frames without knowing a driver: the [`Master`](crate::Master) while machines move,
/// a [`Commissioner`](crate::commission::Commissioner) before.
pub trait BusUser {
    /// A frame with what it means to its sender.
    type Outgoing: AsRef<Self::Frame>;
    /// A frame of its protocol.
    type Frame: BusFrame;

    /// The frame that should go out next; asking changes nothing.
    fn next_frame(&self) -> Option<Self::Outgoing>;

    /// The controller accepted a frame: now it counts.
    fn on_accepted(&mut self, now: Instant, outgoing: &Self::Outgoing);

    /// The controller gave back a frame that it had accepted, unsent, to make room for a more urgent one.
    fn on_displaced(&mut self, now: Instant, frame: &Self::Frame);

    /// The controller failed while it took a frame: whether that frame goes out is not known.
    fn on_transmit_error(&mut self, now: Instant, outgoing: &Self::Outgoing, kind: BusErrorKind);

    /// The controller reports an error while receiving.
    fn on_receive_error(&mut self, now: Instant, kind: BusErrorKind);

    /// A frame came in.
    fn on_frame(&mut self, now: Instant, frame: &Self::Frame);

    /// A frame came in, or back, that cannot belong to this protocol.
    fn on_foreign_frame(&mut self, now: Instant, error: <Self::Frame as BusFrame>::Error);
}
