//! Faults on single frames, decided outside the bus.
//!
//! Specification: an error anywhere in a frame destroys it for all, and the sender repeats it by itself. An error in the last EOF bit does not: receivers
//! have accepted the frame by then, the sender has not finished it and repeats it, so that they receive it twice (Bosch CAN 2.0 B, section 4
//! "Message validation"). The bus asks its [`FaultModel`] at each attempt and each delivery and draws nothing at random itself.

use crate::frame::Frame;
use crate::node::NodeId;
use crate::wire::WireLength;

/// One attempt to send a frame, as it begins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Attempt {
    /// Start of frame.
    pub start_ns: u64,
    /// The sender; the first one registered when several send the same frame at once.
    pub node: NodeId,
    /// What is sent.
    pub frame: Frame,
    /// Its length on the wire.
    pub wire: WireLength,
    /// Number of this attempt for this frame of that sender, counted from 1.
    pub number: u32,
}

/// What becomes of an attempt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AttemptOutcome {
    /// No fault.
    #[default]
    Intact,
    /// An error is seen in bit `at_bit` on the wire, counted from 1 at SOF. Nobody receives the frame; the sender repeats it.
    ///
    /// A bit behind the ACK delimiter means the ACK delimiter, where a CRC error is signalled: an error in EOF has other consequences.
    BitError {
        /// Bit on the wire, counted from 1 at SOF, stuff bits included.
        at_bit: u32,
    },
    /// An error in the last bit of EOF: receivers accept the frame, the sender repeats it.
    EofError,
}

/// A frame about to be stored by one receiver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Delivery {
    /// End of frame.
    pub end_ns: u64,
    /// The receiver.
    pub receiver: NodeId,
    /// What is received.
    pub frame: Frame,
}

/// What becomes of a delivery.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DeliveryOutcome {
    /// The frame is stored.
    #[default]
    Store,
    /// This receiver loses the frame, as software does that reads too late. It was acknowledged nevertheless.
    Drop,
}

/// Source of faults. Models that draw random numbers must be seeded by their owner.
pub trait FaultModel {
    /// Decides about an attempt. Not asked when senders collide or the bus is disturbed, since such an attempt fails anyway.
    fn on_attempt(&mut self, attempt: &Attempt) -> AttemptOutcome {
        let _ = attempt;
        AttemptOutcome::Intact
    }

    /// Decides about a delivery. Asked for each receiver whose filter accepts the frame.
    fn on_delivery(&mut self, delivery: &Delivery) -> DeliveryOutcome {
        let _ = delivery;
        DeliveryOutcome::Store
    }
}

/// A bus without faults.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct NoFaults;

impl FaultModel for NoFaults {}

impl<M: FaultModel + ?Sized> FaultModel for Box<M> {
    fn on_attempt(&mut self, attempt: &Attempt) -> AttemptOutcome {
        (**self).on_attempt(attempt)
    }

    fn on_delivery(&mut self, delivery: &Delivery) -> DeliveryOutcome {
        (**self).on_delivery(delivery)
    }
}
