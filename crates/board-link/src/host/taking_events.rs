//! Events as they come.

use super::client::Client;
use super::incoming::Incoming;
use crate::message::Event;

impl<const WINDOW: usize, const OUT: usize> Client<WINDOW, OUT> {
    pub(super) fn take_event(&mut self, number: u32, event: Event) {
        let next = self.events.next.unwrap_or(number);
        if number != next || !self.has_room() {
            // One that was there, or one behind a gap; those that are missing are asked for.
            if number >= next {
                self.events.next = Some(next);
                self.events.known = self.events.known.max(number.wrapping_add(1));
            }
            return;
        }
        let after = number.wrapping_add(1);
        self.events.next = Some(after);
        self.events.known = self.events.known.max(after);
        self.tell(Incoming::Event { number, event });
    }
}
