//! What happened, in order, for the application to read.

use bus_user::{BusErrorKind, Instant};
use heapless::Deque;

use crate::core::stamp::Stamp;
use crate::core::state::{AxisState, Reason};

/// Events that wait to be read. One that does not fit is counted, not forgotten.
const CAPACITY: usize = 64;

/// Something that happened to one axis or to the bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Event<K> {
    /// When.
    pub at: Instant,
    /// The axis by its place in the configuration; `None` for the bus.
    pub axis: Option<u8>,
    /// What.
    pub kind: K,
}

/// What happens to every axis and bus, whatever the family. Each family has events of its own besides, and one type for both.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CommonEvent<F> {
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
    Fault(F),
    /// The drive reports power that this master did not switch on. It is left alone until `disable` or `adopt`.
    FoundOn,
    /// The drive did not confirm the disable command, or it could not be sent in time; it is repeated. Reported at the first, second, fourth, eighth ... repetition, up to 2^15.
    DisableUnconfirmed {
        /// Repetitions so far.
        repeated: u32,
    },
    /// A set-point missed its cycle.
    SetPointMerged,
    /// Cycles that were never begun.
    CyclesMissed(u32),
    /// The controller reports an error.
    BusError(BusErrorKind),
    /// The controller is bus-off.
    BusOff,
    /// The controller takes part in the bus again.
    BusRecovered,
}

/// Where one axis writes its events.
#[derive(Debug)]
pub struct EventLog<'a, K: Copy> {
    pub(crate) events: &'a mut Events<K>,
    /// The present moment.
    pub now: Instant,
    pub(crate) axis: u8,
}

impl<K: Copy> EventLog<'_, K> {
    /// Writes an event of this axis.
    pub fn push(&mut self, kind: impl Into<K>) {
        self.events.push(self.now, Some(self.axis), kind);
    }
}

/// An event as the queue keeps it: packed, because events are a good part of the memory of a master, and are written and read as a
/// whole.
#[derive(Debug, Clone, Copy)]
#[repr(Rust, packed)]
struct Record<K: Copy> {
    at: Stamp,
    /// One of at most 64, or [`NO_AXIS`].
    axis: u8,
    kind: K,
}

/// What a record has in the place of an axis that concerns the bus.
const NO_AXIS: u8 = u8::MAX;

/// A bounded queue of events.
#[derive(Debug)]
pub(crate) struct Events<K: Copy> {
    queue: Deque<Record<K>, CAPACITY>,
    dropped: u32,
}

impl<K: Copy> Events<K> {
    pub(crate) const fn new() -> Self {
        Self {
            queue: Deque::new(),
            dropped: 0,
        }
    }

    #[inline]
    pub(crate) fn push(&mut self, at: Instant, axis: Option<u8>, kind: impl Into<K>) {
        self.push_event(at, axis, kind.into());
    }

    /// Events are rare: one copy of this, not one at each place that has something to tell.
    #[cold]
    #[inline(never)]
    fn push_event(&mut self, at: Instant, axis: Option<u8>, kind: K) {
        let record = Record {
            at: Stamp::of(at),
            axis: axis.unwrap_or(NO_AXIS),
            kind,
        };
        if self.queue.push_back(record).is_err() {
            self.dropped = self.dropped.saturating_add(1);
        }
    }

    /// The oldest event, seen from a moment close to the present.
    pub(crate) fn pop(&mut self, now: Instant) -> Option<Event<K>> {
        let Record { at, axis, kind } = self.queue.pop_front()?;
        Some(Event {
            at: at.at(now),
            axis: (axis != NO_AXIS).then_some(axis),
            kind,
        })
    }

    /// Forgets what was not read.
    pub(crate) fn clear(&mut self) {
        self.queue.clear();
    }

    /// As [`Stamp::keep`].
    pub(crate) fn keep_stamps(&mut self, now: Instant, is_long_ago: bool) {
        for record in &mut self.queue {
            let mut at = record.at;
            at.keep(now, is_long_ago);
            record.at = at;
        }
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
        let mut events = Events::<u32>::new();
        for us in 0..CAPACITY as u64 + 3 {
            events.push(Instant::from_us(us), None, 7_u32);
        }
        assert_eq!(events.dropped(), 3);
        assert_eq!(
            events.pop(Instant::from_us(70)).map(|event| event.at),
            Some(Instant::from_us(0))
        );
    }
}
