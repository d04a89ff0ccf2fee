//! What happened, in order, for the application to read.

use dyn_can::{DecodeError, FrameError, FunctionCode, ReplyKind, Revision};
use heapless::Deque;

use crate::family::Happening;
use crate::fault::Fault;
use crate::life::{AxisState, Reason};
use crate::plan::Warning;
use crate::procedure::ProcedureEnd;
use crate::time::Instant;

/// Events that wait to be read. One that does not fit is counted, not forgotten.
const CAPACITY: usize = 64;

/// Something that happened to one axis or to the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Event<K = EventKind> {
    /// When.
    pub at: Instant,
    /// The axis by its place in the configuration; `None` for the bus.
    pub axis: Option<u8>,
    /// What.
    pub kind: K,
}

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EventKind {
    /// The axis went from one state to another.
    State {
        /// The state that it left.
        from: AxisState,
        /// The state that it entered.
        to: AxisState,
        /// Why.
        reason: Reason,
    },
    /// A fault was latched.
    Fault(Fault),
    /// The plan of the bus was admitted, but there is something to know about it.
    Plan(Warning),
    /// The drive's revision was recognised.
    Revision(Revision),
    /// The set-point of the cycle before did not reach the controller in time; its step is in the next frame.
    SetPointMerged,
    /// The controller gave back a set-point unsent; its step is owed again.
    SetPointDisplaced,
    /// The controller gave back a request unsent; it is asked again.
    RequestDisplaced(ReplyKind),
    /// A procedure ended.
    Procedure(ProcedureEnd),
    /// The reply did not come in time.
    ReplyTimeout(ReplyKind),
    /// A reply came too late or twice, and was dropped.
    LateReply(FunctionCode),
    /// A reply that nobody asked for was dropped: is there a second master on the bus?
    StrayReply(FunctionCode),
    /// A reply does not decode.
    BadReply(DecodeError),
    /// A frame of a drive that is in no axis, or one given back that does not decode, was ignored.
    ForeignFrame {
        /// Its identifier.
        id: u16,
    },
    /// A frame that no drive of this family sends, or one that the controller gave back, was ignored.
    NotOurs(FrameError),
    /// The time from one cycle to the next was longer than planned by so many cycles.
    CyclesMissed(u32),
    /// The controller reports a transmit or receive error.
    BusError(BusErrorKind),
    /// The controller is bus-off: nothing is sent until it is recovered and the axes are cleared.
    BusOff,
    /// The controller takes part in the bus again.
    BusRecovered,
}

impl From<Happening<Fault>> for EventKind {
    fn from(happening: Happening<Fault>) -> Self {
        match happening {
            Happening::State { from, to, reason } => Self::State { from, to, reason },
            Happening::Fault(fault) => Self::Fault(fault),
            Happening::SetPointMerged => Self::SetPointMerged,
            Happening::CyclesMissed(cycles) => Self::CyclesMissed(cycles),
            Happening::BusError(kind) => Self::BusError(kind),
            Happening::BusOff => Self::BusOff,
            Happening::BusRecovered => Self::BusRecovered,
        }
    }
}

/// What the controller reports of the bus, after `embedded_can::ErrorKind`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum BusErrorKind {
    /// The receive buffer overran: replies were lost.
    Overrun,
    /// A bit was read back differently.
    Bit,
    /// The stuffing rule was broken.
    Stuff,
    /// A checksum was wrong.
    Crc,
    /// A fixed bit was wrong.
    Form,
    /// Nobody acknowledged.
    Acknowledge,
    /// Something else.
    Other,
}

impl From<embedded_can::ErrorKind> for BusErrorKind {
    fn from(kind: embedded_can::ErrorKind) -> Self {
        match kind {
            embedded_can::ErrorKind::Overrun => Self::Overrun,
            embedded_can::ErrorKind::Bit => Self::Bit,
            embedded_can::ErrorKind::Stuff => Self::Stuff,
            embedded_can::ErrorKind::Crc => Self::Crc,
            embedded_can::ErrorKind::Form => Self::Form,
            embedded_can::ErrorKind::Acknowledge => Self::Acknowledge,
            _ => Self::Other,
        }
    }
}

/// A bounded queue of events.
#[derive(Debug)]
pub(crate) struct Events<K> {
    queue: Deque<Event<K>, CAPACITY>,
    dropped: u32,
}

impl<K> Events<K> {
    pub(crate) const fn new() -> Self {
        Self {
            queue: Deque::new(),
            dropped: 0,
        }
    }

    pub(crate) fn push(&mut self, at: Instant, axis: Option<u8>, kind: impl Into<K>) {
        let kind = kind.into();
        if self.queue.push_back(Event { at, axis, kind }).is_err() {
            self.dropped = self.dropped.saturating_add(1);
        }
    }

    pub(crate) fn pop(&mut self) -> Option<Event<K>> {
        self.queue.pop_front()
    }

    pub(crate) const fn dropped(&self) -> u32 {
        self.dropped
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_counted() {
        let mut events = Events::<EventKind>::new();
        for us in 0..CAPACITY as u64 + 3 {
            events.push(Instant::from_us(us), None, EventKind::BusOff);
        }
        assert_eq!(events.dropped(), 3);
        assert_eq!(
            events.pop().map(|event| event.at),
            Some(Instant::from_us(0))
        );
    }
}
