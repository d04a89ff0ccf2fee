//! Events come in order and without a gap, or with a gap that is counted.

/// Which event is next, and what the board is known to have.
#[derive(Debug, Clone, Copy)]
pub(super) struct EventOrder {
    /// Unknown before the first one.
    pub(super) next: Option<u32>,
    /// The board has events up to this number, this one not.
    pub(super) known: u32,
    is_asked: bool,
}

impl EventOrder {
    pub(super) const fn new() -> Self {
        Self {
            next: None,
            known: 0,
            is_asked: false,
        }
    }

    /// A session begins: what was before is not of interest.
    pub(super) const fn begin(&mut self, next: u32) {
        *self = Self {
            next: Some(next),
            known: next,
            is_asked: false,
        };
    }

    /// The board says which number its next event will have.
    pub(super) fn expect(&mut self, known: u32) {
        if self.next.is_some() {
            self.known = known;
        }
    }

    /// The first event that has not come although the board has it.
    pub(super) fn missing(&mut self) -> Option<u32> {
        let next = self.next?;
        let is_missing = next != self.known && !self.is_asked;
        self.is_asked |= is_missing;
        is_missing.then_some(next)
    }

    /// The board sends them again, from the oldest it has. Returns how many are lost.
    pub(super) fn resend(&mut self, oldest: u32, known: u32) -> Option<u32> {
        let next = self.next?;
        self.is_asked = false;
        self.known = known;
        // The board counts from 0, so a smaller number is an older one for a long time.
        let lost = oldest.checked_sub(next).filter(|&lost| lost > 0)?;
        self.next = Some(oldest);
        Some(lost)
    }
}
