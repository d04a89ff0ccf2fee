//! The seam between whoever uses the bus and whoever drives it.

use embedded_can::Frame;

use crate::error::BusErrorKind;
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

/// What the controller did with a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[must_use]
pub enum Outcome<Fr> {
    /// It will send the frame.
    Accepted,
    /// It will send the frame, and gives back another one unsent that it had accepted before.
    Displaced(Fr),
    /// It has no room; offer the frame again later.
    Full,
    /// It failed: whether the frame goes out is not known.
    Failed(BusErrorKind),
}

/// Where frames go: one transmit side of one controller. Every closure `FnMut(&Frame) -> Outcome<Frame>` is one.
pub trait Sink<Fr> {
    /// Offers a frame.
    fn offer(&mut self, frame: &Fr) -> Outcome<Fr>;

    /// Whether there is room for a frame, as far as the sink knows without one: where it says no, none is made to be refused.
    fn has_room(&self) -> bool {
        true
    }

    /// Takes back one frame that waits unsent in the controller; `None` when there is none, or when this controller cannot.
    ///
    /// A master calls it when an axis must stop at once, until nothing comes back. Where it always returns `None`, set-points that
    /// the controller holds still go out: three with usual mailboxes, sixteen behind a slcan adapter.
    fn take_back(&mut self) -> Option<Fr> {
        None
    }
}

impl<Fr, O: FnMut(&Fr) -> Outcome<Fr>> Sink<Fr> for O {
    fn offer(&mut self, frame: &Fr) -> Outcome<Fr> {
        self(frame)
    }
}

/// What is left to send.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[must_use]
pub enum Progress {
    /// Every frame of this cycle is with the controller; come back with the next frame or the next cycle.
    Idle,
    /// A frame waits for room; come back as soon as the controller has sent one.
    Blocked,
}

/// Something that sends and receives frames without knowing a driver: a master while machines move, a task of commissioning before.
pub trait BusUser {
    /// A frame of its protocol.
    type Frame: BusFrame;

    /// Offers what is to be sent, most urgent first, until nothing is left or the sink takes no more. Each frame is made once for each
    /// time it is offered, and counts only when it was accepted.
    fn send<S: Sink<Self::Frame>>(&mut self, now: Instant, sink: &mut S) -> Progress;

    /// The controller gave back a frame that it had accepted, unsent.
    fn on_displaced(&mut self, now: Instant, frame: &Self::Frame);

    /// The controller reports an error while receiving.
    fn on_receive_error(&mut self, now: Instant, kind: BusErrorKind);

    /// A frame came in.
    fn on_frame(&mut self, now: Instant, frame: &Self::Frame);

    /// A frame came in, or back, that cannot belong to this protocol.
    fn on_foreign_frame(&mut self, now: Instant, error: <Self::Frame as BusFrame>::Error);
}
