//! Three transmit mailboxes.
//!
//! Law (bxCAN, STM32 reference manual RM0090, "Transmission handling"; `embedded_can::nb::Can::transmit`): three frames can wait. They go out
//! by identifier, or in the order of request (TXFP). Equal identifiers keep the order of request. By identifier, a frame of higher
//! priority displaces the waiting one of the lowest, never the one on the wire. An abort frees waiting mailboxes at once; a frame on the wire
//! is finished, and given up only if that attempt fails.

use crate::frame::Frame;

/// Number of transmit mailboxes of a bxCAN.
pub const MAILBOXES: usize = 3;

/// Order in which waiting frames of one controller go out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TxOrder {
    /// Highest priority first (TXFP = 0, the state after reset).
    #[default]
    ByIdentifier,
    /// Oldest request first (TXFP = 1).
    Fifo,
}

/// What became of a frame handed to the mailboxes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Placement {
    Stored,
    Displaced(Frame),
    Full,
}

#[derive(Debug, Clone, Copy)]
struct Mailbox {
    frame: Frame,
    priority: u32,
    request: u64,
    attempts: u32,
    abort_requested: bool,
}

/// The mailboxes of one controller.
#[derive(Debug, Clone)]
pub(crate) struct TxMailboxes {
    order: TxOrder,
    slots: [Option<Mailbox>; MAILBOXES],
    requests: u64,
    /// Slot that goes out next; kept up to date so that arbitration need not search.
    head: Option<usize>,
    transmitting: bool,
}

impl TxMailboxes {
    pub(crate) fn new(order: TxOrder) -> Self {
        Self {
            order,
            slots: [None; MAILBOXES],
            requests: 0,
            head: None,
            transmitting: false,
        }
    }

    pub(crate) fn store(&mut self, frame: Frame) -> Placement {
        let priority = frame.arbitration_field();
        let (slot, placement) = match self.slots.iter().position(Option::is_none) {
            Some(free) => (free, Placement::Stored),
            None => match self.displaceable(priority) {
                Some((slot, evicted)) => (slot, Placement::Displaced(evicted)),
                None => return Placement::Full,
            },
        };
        self.requests += 1;
        self.slots[slot] = Some(Mailbox {
            frame,
            priority,
            request: self.requests,
            attempts: 0,
            abort_requested: false,
        });
        self.find_head();
        placement
    }

    /// The waiting frame of the lowest priority, if it ranks below `priority`.
    fn displaceable(&self, priority: u32) -> Option<(usize, Frame)> {
        if self.order == TxOrder::Fifo {
            return None;
        }
        let waiting = self
            .slots
            .iter()
            .enumerate()
            .filter(|(slot, _)| !self.is_on_wire(*slot));
        let lowest = waiting.filter_map(|(slot, mailbox)| Some((slot, mailbox.as_ref()?)));
        let (slot, mailbox) =
            lowest.max_by_key(|(_, mailbox)| (mailbox.priority, mailbox.request))?;
        (priority < mailbox.priority).then_some((slot, mailbox.frame))
    }

    fn is_on_wire(&self, slot: usize) -> bool {
        self.transmitting && self.head == Some(slot)
    }

    /// The head must not move while its frame is on the wire: the end of the attempt concerns that frame.
    fn find_head(&mut self) {
        if self.transmitting {
            return;
        }
        let order = self.order;
        let waiting = self
            .slots
            .iter()
            .enumerate()
            .filter_map(|(slot, mailbox)| Some((slot, mailbox.as_ref()?)));
        self.head = waiting
            .min_by_key(|(_, mailbox)| {
                (
                    if order == TxOrder::Fifo {
                        0
                    } else {
                        mailbox.priority
                    },
                    mailbox.request,
                )
            })
            .map(|(slot, _)| slot);
    }

    fn head_mailbox(&self) -> Option<&Mailbox> {
        self.slots[self.head?].as_ref()
    }

    /// Arbitration field of the frame that goes out next.
    pub(crate) fn head_priority(&self) -> Option<u32> {
        self.head_mailbox().map(|mailbox| mailbox.priority)
    }

    /// Puts the head on the wire and returns it with the number of this attempt, counted from 1.
    pub(crate) fn begin(&mut self) -> Option<(Frame, u32)> {
        let mailbox = self.slots[self.head?].as_mut()?;
        mailbox.attempts = mailbox.attempts.saturating_add(1);
        self.transmitting = true;
        Some((mailbox.frame, mailbox.attempts))
    }

    pub(crate) fn on_wire(&self) -> Option<Frame> {
        self.head_mailbox()
            .filter(|_| self.transmitting)
            .map(|mailbox| mailbox.frame)
    }

    pub(crate) fn is_transmitting(&self) -> bool {
        self.transmitting
    }

    /// The frame on the wire went out: its mailbox is free.
    pub(crate) fn complete(&mut self) {
        if self.transmitting {
            self.free_head();
        }
    }

    /// The attempt failed: the frame waits again, or is given up if an abort was asked for meanwhile (returns true).
    pub(crate) fn fail(&mut self) -> bool {
        let aborted = self.transmitting
            && self
                .head_mailbox()
                .is_some_and(|mailbox| mailbox.abort_requested);
        if aborted {
            self.free_head();
        } else {
            self.transmitting = false;
            self.find_head();
        }
        aborted
    }

    fn free_head(&mut self) {
        if let Some(slot) = self.head {
            self.slots[slot] = None;
        }
        self.transmitting = false;
        self.find_head();
    }

    /// Frees every waiting mailbox and marks the one on the wire; returns the number freed.
    pub(crate) fn abort_all(&mut self) -> usize {
        let mut freed = 0;
        for slot in 0..MAILBOXES {
            if self.is_on_wire(slot) {
                self.slots[slot]
                    .iter_mut()
                    .for_each(|mailbox| mailbox.abort_requested = true);
            } else {
                freed += usize::from(self.slots[slot].take().is_some());
            }
        }
        self.find_head();
        freed
    }

    pub(crate) fn clear(&mut self) {
        self.transmitting = false;
        self.slots = [None; MAILBOXES];
        self.head = None;
    }

    pub(crate) fn pending(&self) -> usize {
        self.slots.iter().flatten().count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::tests::standard;

    fn drain(mailboxes: &mut TxMailboxes) -> Vec<String> {
        let mut out = Vec::new();
        while let Some((frame, _)) = mailboxes.begin() {
            out.push(frame.to_string());
            mailboxes.complete();
        }
        out
    }

    fn filled(order: TxOrder, ids: [u16; 3]) -> TxMailboxes {
        let mut mailboxes = TxMailboxes::new(order);
        for id in ids {
            assert_eq!(mailboxes.store(standard(id, &[])), Placement::Stored);
        }
        mailboxes
    }

    #[test]
    fn order_by_identifier_and_by_request() {
        assert_eq!(
            drain(&mut filled(TxOrder::ByIdentifier, [0x30, 0x10, 0x20])),
            ["010#", "020#", "030#"]
        );
        assert_eq!(
            drain(&mut filled(TxOrder::Fifo, [0x30, 0x10, 0x20])),
            ["030#", "010#", "020#"]
        );
    }

    #[test]
    fn equal_identifiers_keep_the_order_of_request() {
        let mut mailboxes = TxMailboxes::new(TxOrder::ByIdentifier);
        for byte in [1, 2, 3] {
            mailboxes.store(standard(0x10, &[byte]));
        }
        mailboxes.begin();
        mailboxes.complete();
        mailboxes.store(standard(0x10, &[4]));
        assert_eq!(drain(&mut mailboxes), ["010#02", "010#03", "010#04"]);
    }

    #[test]
    fn higher_priority_displaces_the_lowest() {
        let mut mailboxes = filled(TxOrder::ByIdentifier, [0x30, 0x10, 0x20]);
        assert_eq!(mailboxes.store(standard(0x30, &[])), Placement::Full);
        assert_eq!(
            mailboxes.store(standard(0x05, &[])),
            Placement::Displaced(standard(0x30, &[]))
        );
        assert_eq!(drain(&mut mailboxes), ["005#", "010#", "020#"]);
    }

    #[test]
    fn fifo_never_displaces() {
        let mut mailboxes = filled(TxOrder::Fifo, [0x30, 0x10, 0x20]);
        assert_eq!(mailboxes.store(standard(0x05, &[])), Placement::Full);
    }

    #[test]
    fn frame_on_the_wire_is_never_displaced() {
        let mut mailboxes = TxMailboxes::new(TxOrder::ByIdentifier);
        mailboxes.store(standard(0x700, &[]));
        mailboxes.begin();
        mailboxes.store(standard(0x10, &[]));
        mailboxes.store(standard(0x20, &[]));
        assert_eq!(
            mailboxes.store(standard(0x15, &[])),
            Placement::Displaced(standard(0x20, &[]))
        );
        assert_eq!(mailboxes.store(standard(0x16, &[])), Placement::Full);
        mailboxes.complete();
        assert_eq!(drain(&mut mailboxes), ["010#", "015#"]);
    }

    #[test]
    fn abort_spares_the_frame_on_the_wire_until_it_fails() {
        let mut mailboxes = filled(TxOrder::Fifo, [1, 2, 3]);
        mailboxes.begin();
        assert_eq!(mailboxes.abort_all(), 2);
        assert_eq!(
            (mailboxes.pending(), mailboxes.is_transmitting()),
            (1, true)
        );
        assert!(mailboxes.fail());
        assert_eq!(
            (mailboxes.pending(), mailboxes.is_transmitting()),
            (0, false)
        );
    }

    #[test]
    fn failed_frame_waits_again_behind_a_more_urgent_one() {
        let mut mailboxes = TxMailboxes::new(TxOrder::ByIdentifier);
        mailboxes.store(standard(0x50, &[]));
        assert_eq!(mailboxes.begin(), Some((standard(0x50, &[]), 1)));
        mailboxes.store(standard(0x40, &[]));
        assert!(!mailboxes.fail());
        assert_eq!(mailboxes.begin(), Some((standard(0x40, &[]), 1)));
        mailboxes.complete();
        assert_eq!(mailboxes.begin(), Some((standard(0x50, &[]), 2)));
    }
}
