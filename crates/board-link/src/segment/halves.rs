//! The two ends of a queue from the thread to the cycle.
//!
//! `heapless` divides by the length of a queue, which it knows at run time alone. A queue of length 0 cannot be made, but only where that is
//! asked before does the compiler leave out the panic of the division.

use heapless::spsc::{Consumer, Producer};

/// The end of the thread.
pub(super) struct Sender<'q, T>(Producer<'q, T>);

/// The end of the cycle.
pub(super) struct Receiver<'q, T>(Consumer<'q, T>);

/// The capacity of a queue of length 0, one less than nothing.
const NONE: usize = usize::MAX;

impl<'q, T> Sender<'q, T> {
    pub(super) const fn new(producer: Producer<'q, T>) -> Self {
        Self(producer)
    }

    pub(super) fn capacity(&self) -> usize {
        self.0.capacity()
    }

    pub(super) fn free(&self) -> usize {
        match self.0.capacity() {
            NONE => 0,
            capacity => capacity.saturating_sub(self.0.len()),
        }
    }

    /// Whether there was room.
    pub(super) fn send(&mut self, item: T) -> bool {
        self.0.capacity() != NONE && self.0.enqueue(item).is_ok()
    }
}

impl<'q, T> Receiver<'q, T> {
    pub(super) const fn new(consumer: Consumer<'q, T>) -> Self {
        Self(consumer)
    }

    pub(super) fn len(&self) -> usize {
        match self.0.capacity() {
            NONE => 0,
            _ => self.0.len(),
        }
    }

    pub(super) fn is_full(&self) -> bool {
        self.len() == self.0.capacity()
    }

    /// The oldest, which stays.
    pub(super) fn peek(&self) -> Option<&T> {
        match self.0.capacity() {
            NONE => None,
            _ => self.0.peek(),
        }
    }

    pub(super) fn receive(&mut self) -> Option<T> {
        match self.0.capacity() {
            NONE => None,
            _ => self.0.dequeue(),
        }
    }
}
