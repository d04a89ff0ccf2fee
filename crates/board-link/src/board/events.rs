//! Events with numbers: the last ones are kept, so that a host may ask again, and sees by the numbers what it has lost.

use crate::message::Event;

/// Events that are kept.
const KEPT: usize = 32;

#[derive(Debug)]
pub(super) struct Events {
    kept: heapless::Deque<Event, KEPT>,
    next: u32,
}

impl Events {
    pub(super) const fn new() -> Self {
        Self {
            kept: heapless::Deque::new(),
            next: 0,
        }
    }

    /// The number of the next one.
    pub(super) const fn next(&self) -> u32 {
        self.next
    }

    /// The number of the oldest that is kept.
    pub(super) fn oldest(&self) -> u32 {
        self.next.wrapping_sub(self.kept.len() as u32)
    }

    pub(super) fn add(&mut self, event: Event) {
        if self.kept.is_full() {
            self.kept.pop_front();
        }
        // There is room now.
        let _ = self.kept.push_back(event);
        self.next = self.next.wrapping_add(1);
    }

    pub(super) fn get(&self, number: u32) -> Option<Event> {
        let place = number.wrapping_sub(self.oldest());
        self.kept.get(place as usize).copied()
    }

    /// The nearest number that can be sent, for one that a host asks for.
    pub(super) fn nearest(&self, number: u32) -> u32 {
        let (oldest, place) = (self.oldest(), number.wrapping_sub(self.oldest()));
        if place as usize <= self.kept.len() {
            number
        } else {
            oldest
        }
    }
}
