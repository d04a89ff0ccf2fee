//! The three transmit mailboxes (RM0090, sections 32.7.1 and 32.9.2).

use std::collections::VecDeque;

use drive_sim::Frame;

use super::register_frame::{Registers, from_registers};

/// Number of mailboxes.
pub(super) const MAILBOXES: usize = 3;

const REQUEST: u32 = 1;
const COMPLETED: u32 = 1;
const SENT: u32 = 1 << 1;
const ERROR: u32 = 1 << 3;
const ABORT: u32 = 1 << 7;
/// The status flags of one mailbox in TSR.
const FLAGS: u32 = 0xF;
const FIRST_COMPLETED: u32 = 0x01_0101;

/// The mailboxes with the TSR register.
#[derive(Debug, Clone, Default)]
pub(super) struct Mailboxes {
    registers: [Registers; MAILBOXES],
    /// Mailboxes in the order of request.
    order: VecDeque<usize>,
    flags: u32,
}

impl Mailboxes {
    /// Whether a frame waits in a mailbox.
    #[must_use]
    pub(super) fn is_pending(&self, mailbox: usize) -> bool {
        self.registers[mailbox][0] & REQUEST != 0
    }

    /// The frame in a mailbox.
    #[must_use]
    pub(super) fn frame(&self, mailbox: usize) -> Frame {
        from_registers(&self.registers[mailbox])
    }

    /// The mailbox that goes next: first come, first served, or by priority and then number.
    #[must_use]
    pub(super) fn next(&self, first_come: bool) -> Option<usize> {
        if first_come {
            return self.order.front().copied();
        }
        self.order
            .iter()
            .copied()
            .min_by_key(|&mailbox| self.urgency(mailbox))
    }

    fn urgency(&self, mailbox: usize) -> (u32, usize) {
        (self.frame(mailbox).arbitration_field(), mailbox)
    }

    fn set_flags(&mut self, mailbox: usize, flags: u32) {
        self.flags = self.flags & !(FLAGS << (8 * mailbox)) | flags << (8 * mailbox);
    }

    fn finish(&mut self, mailbox: usize, flags: u32) {
        self.registers[mailbox][0] &= !REQUEST;
        self.order.retain(|&other| other != mailbox);
        self.set_flags(mailbox, flags);
    }

    /// The frame went out and was acknowledged.
    pub(super) fn sent(&mut self, mailbox: usize) {
        self.finish(mailbox, COMPLETED | SENT);
    }

    /// The frame was given up.
    pub(super) fn aborted(&mut self, mailbox: usize) {
        self.finish(mailbox, COMPLETED);
    }

    /// An attempt failed; the frame stays.
    pub(super) fn failed(&mut self, mailbox: usize) {
        self.flags |= ERROR << (8 * mailbox);
    }

    /// Whether a mailbox has completed: the level of the transmit interrupt.
    #[must_use]
    pub(super) fn has_completed(&self) -> bool {
        self.flags & FIRST_COMPLETED != 0
    }

    /// The TSR register. Its code field names a free mailbox, or the one that goes last when all are taken.
    #[must_use]
    pub(super) fn status(&self) -> u32 {
        let free = (0..MAILBOXES).filter(|&mailbox| !self.is_pending(mailbox));
        let empty = free
            .clone()
            .fold(0, |bits, mailbox| bits | 1 << (26 + mailbox));
        let last = (0..MAILBOXES)
            .max_by_key(|&mailbox| self.urgency(mailbox))
            .unwrap_or(0);
        let code = free.min().unwrap_or(last) as u32;
        self.flags | code << 24 | empty
    }

    /// Writes TSR; returns the mailboxes whose frame shall be given up.
    pub(super) fn write_status(&mut self, value: u32) -> impl Iterator<Item = usize> + use<> {
        for mailbox in 0..MAILBOXES {
            if value >> (8 * mailbox) & COMPLETED != 0 {
                self.set_flags(mailbox, 0);
            }
        }
        let pending: Vec<bool> = (0..MAILBOXES)
            .map(|mailbox| self.is_pending(mailbox))
            .collect();
        (0..MAILBOXES)
            .filter(move |&mailbox| value >> (8 * mailbox) & ABORT != 0 && pending[mailbox])
    }

    /// Reads a register of a mailbox by its offset from the first.
    #[must_use]
    pub(super) fn read(&self, offset: u32) -> u32 {
        self.registers[offset as usize / 16][(offset as usize % 16) / 4]
    }

    /// Writes a register of a mailbox; one that waits to be sent cannot be changed.
    pub(super) fn write(&mut self, offset: u32, value: u32) {
        let (mailbox, register) = (offset as usize / 16, (offset as usize % 16) / 4);
        if self.is_pending(mailbox) {
            return;
        }
        self.registers[mailbox][register] = value;
        if register == 0 && value & REQUEST != 0 {
            self.set_flags(mailbox, 0);
            self.order.push_back(mailbox);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn request(mailboxes: &mut Mailboxes, mailbox: u32, id: u32) {
        mailboxes.write(16 * mailbox, id << 21 | REQUEST);
    }

    #[test]
    fn order_is_by_request_or_by_priority() {
        let mut mailboxes = Mailboxes::default();
        request(&mut mailboxes, 0, 0x40);
        request(&mut mailboxes, 1, 0x20);
        assert_eq!(
            (mailboxes.next(true), mailboxes.next(false)),
            (Some(0), Some(1))
        );
        mailboxes.sent(0);
        assert_eq!(mailboxes.next(true), Some(1));
        assert_eq!(mailboxes.status() & 0xFF, COMPLETED | SENT);
    }

    #[test]
    fn the_code_names_a_free_mailbox_or_the_last_to_go() {
        let mut mailboxes = Mailboxes::default();
        request(&mut mailboxes, 0, 0x20);
        assert_eq!(mailboxes.status() >> 24 & 3, 1);
        request(&mut mailboxes, 1, 0x60);
        request(&mut mailboxes, 2, 0x40);
        assert_eq!(
            (mailboxes.status() >> 24 & 3, mailboxes.status() >> 26),
            (1, 0)
        );
    }

    #[test]
    fn an_aborted_frame_completes_without_having_been_sent() {
        let mut mailboxes = Mailboxes::default();
        request(&mut mailboxes, 2, 0x20);
        assert_eq!(
            mailboxes
                .write_status(ABORT << 16 | ABORT)
                .collect::<Vec<_>>(),
            [2]
        );
        mailboxes.aborted(2);
        assert_eq!(mailboxes.status() >> 16 & 0xFF, COMPLETED);
        assert!(mailboxes.has_completed());
        let _ = mailboxes.write_status(COMPLETED << 16);
        assert!(!mailboxes.has_completed());
    }
}
