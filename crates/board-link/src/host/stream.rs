//! A stream of segments, as far as a host has it.

use heapless::Deque;

use super::exchange::Exchange;
use crate::refused::Refused;
use crate::segment::Segment;

/// How a stream has ended for the client.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StreamEnd {
    /// The board has every segment and the end: the motion completes by itself.
    Sent {
        /// Segments.
        segments: u32,
    },
    /// The board refuses it: its begin, a segment or its end.
    Refused {
        /// The segment, where it is about one.
        index: Option<u32>,
        /// Why.
        refused: Refused,
    },
    /// No reply came; or it was stopped before one came to its begin, and none has come since.
    TimedOut,
    /// The connection was lost.
    Lost,
}

/// A segment that the board has not confirmed.
#[derive(Debug, Clone)]
pub(super) struct Waiting {
    pub(super) segment: Segment,
    /// The number of its latest request; 0 before it is sent.
    pub(super) number: u16,
}

/// How far a stream is.
#[derive(Debug, Clone)]
pub(super) enum Phase {
    Beginning(Exchange),
    Sending,
    Ending(Exchange),
}

/// A stream under way.
#[derive(Debug, Clone)]
pub(super) struct Stream<const WINDOW: usize> {
    pub(super) number: u32,
    pub(super) phase: Phase,
    pub(super) window: Deque<Waiting, WINDOW>,
    /// The index of the first one in the window.
    pub(super) first: u32,
    /// So many of the window are sent.
    pub(super) sent: usize,
    /// The board takes segments below this index.
    pub(super) limit: u32,
    /// The latest progress, or the latest repetition.
    pub(super) progress_us: u64,
    pub(super) tries: u8,
    pub(super) is_finished: bool,
}

impl<const WINDOW: usize> Stream<WINDOW> {
    /// Its number, once the board has begun it.
    pub(super) const fn begun(&self) -> Option<u32> {
        match self.phase {
            Phase::Beginning(_) => None,
            Phase::Sending | Phase::Ending(_) => Some(self.number),
        }
    }

    /// The board has all segments below an index.
    pub(super) fn confirm(&mut self, next: u32, now_us: u64) {
        while self.first < next && self.sent > 0 && self.window.pop_front().is_some() {
            self.first = self.first.wrapping_add(1);
            self.sent -= 1;
            self.progress_us = now_us;
            self.tries = 0;
        }
    }
}
