//! Bytes on their way out, until whoever drives the wire takes them.

use serde::Serialize;

use crate::frame::{self, LONGEST_FRAME};

/// Frames that wait, at most `N` bytes of them, in one piece.
#[derive(Debug)]
pub(crate) struct Outbox<const N: usize> {
    bytes: [u8; N],
    start: usize,
    end: usize,
}

impl<const N: usize> Outbox<N> {
    pub(crate) const fn new() -> Self {
        const { assert!(N >= LONGEST_FRAME, "the longest frame must fit") };
        Self {
            bytes: [0; N],
            start: 0,
            end: 0,
        }
    }

    /// Bytes that fit.
    pub(crate) const fn free(&self) -> usize {
        N.saturating_sub(self.end.saturating_sub(self.start))
    }

    /// What is to be sent.
    pub(crate) fn waiting(&self) -> &[u8] {
        self.bytes.get(self.start..self.end).unwrap_or_default()
    }

    /// So many of [`Self::waiting`] are sent, or in a buffer of the driver.
    pub(crate) fn consume(&mut self, count: usize) {
        self.start = self.start.saturating_add(count).min(self.end);
        if self.start == self.end {
            (self.start, self.end) = (0, 0);
        }
    }

    /// A zero byte alone: it ends whatever the other side has taken for the beginning of a frame.
    pub(crate) fn end_frame(&mut self) {
        self.close_up();
        if let Some(place) = self.bytes.get_mut(self.end) {
            *place = 0;
            self.end += 1;
        }
    }

    /// Adds a frame; whether it fitted.
    pub(crate) fn send(&mut self, message: &impl Serialize) -> bool {
        self.close_up();
        let room = self.bytes.get_mut(self.end..).unwrap_or_default();
        let length = frame::encode(message, room);
        self.end = self.end.saturating_add(length.unwrap_or(0)).min(N);
        length.is_some()
    }

    fn close_up(&mut self) {
        if self.start > 0 && self.start <= self.end && self.end <= N {
            // Byte by byte: `copy_within` brings `memmove`, 1.6 KB, into an image that has no other use for it.
            for from in self.start..self.end {
                let byte = self.bytes.get(from).copied();
                if let (Some(byte), Some(place)) = (byte, self.bytes.get_mut(from - self.start)) {
                    *place = byte;
                }
            }
            self.end -= self.start;
            self.start = 0;
        }
    }

    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        (self.start, self.end) = (0, 0);
    }
}
