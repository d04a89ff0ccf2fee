//! What the thread with the link and the interrupt with the cycle share: two queues, and words that each half alone writes.

use core::sync::atomic::{AtomicU32, Ordering};

use heapless::spsc::Queue;
use trajectory::curve::Piece;
use trajectory::{Position, Time};

use super::phase::StreamPhase;
use super::quick::{Places, Scale};
use crate::config::WhenDry;
use crate::rate::ONE;

/// Orders that may wait for the next cycle.
const ORDERS: usize = 8;

/// A segment that has passed every check.
#[derive(Debug)]
pub(super) struct Admitted<const AXES: usize> {
    pub(super) generation: u16,
    /// Since the start of the stream.
    pub(super) start: Time,
    pub(super) end: Time,
    pub(super) scale: Scale,
    pub(super) places: [Places; AXES],
    pub(super) pieces: [Piece; AXES],
}

/// What the cycle shall do.
#[derive(Debug)]
pub(super) enum Order<const AXES: usize> {
    Begin(Start<AXES>),
    End,
    Pause,
    Resume,
    Override(i64),
    Stop,
}

/// A stream that begins.
#[derive(Debug)]
pub(super) struct Start<const AXES: usize> {
    pub(super) generation: u16,
    /// The first cycle in which it may move.
    pub(super) at: u64,
    pub(super) when_dry: WhenDry,
    pub(super) override_rate: i64,
    pub(super) from: [Position; AXES],
}

/// The end of what was admitted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Tail {
    /// Whole cycles since the start of the stream, rounded down; below 2^31.
    pub(super) cycles: u32,
    /// Every axis is at rest there.
    pub(super) rests: bool,
}

impl Tail {
    /// The highest rate with which the axes may come there, if something may follow. At an end at rest every rate ends, but what follows may
    /// allow no more than 1.
    pub(super) const fn floor(self) -> i64 {
        if self.rests { ONE } else { 0 }
    }
}

/// What the player does, as of its latest cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Status {
    pub(super) generation: u16,
    pub(super) phase: StreamPhase,
}

/// Words of 32 bits: each has one writer.
#[derive(Debug)]
pub(super) struct Shared {
    tail: AtomicU32,
    highest_rate: AtomicU32,
    changes: AtomicU32,
    status: AtomicU32,
    pub(super) time_cycles: AtomicU32,
    pub(super) rate: AtomicU32,
    pub(super) finished: AtomicU32,
}

impl Shared {
    const fn new() -> Self {
        Self {
            tail: AtomicU32::new(0),
            highest_rate: AtomicU32::new(0),
            changes: AtomicU32::new(0),
            status: AtomicU32::new(0),
            time_cycles: AtomicU32::new(0),
            rate: AtomicU32::new(0),
            finished: AtomicU32::new(0),
        }
    }

    /// Before a segment that allows no more is queued.
    pub(super) fn set_highest_rate(&self, highest_rate: i64) {
        let rate = u32::try_from(highest_rate).unwrap_or(ONE as u32);
        self.highest_rate.store(rate, Ordering::Release);
        self.note_change();
    }

    /// After a segment is queued: until then the player takes the end before for the end.
    pub(super) fn set_tail(&self, tail: Tail) {
        let word = (tail.cycles << 1) | u32::from(tail.rests);
        self.tail.store(word, Ordering::Release);
        self.note_change();
    }

    pub(super) fn tail(&self) -> Tail {
        let word = self.tail.load(Ordering::Acquire);
        Tail {
            cycles: word >> 1,
            rests: word & 1 != 0,
        }
    }

    pub(super) fn highest_rate(&self) -> i64 {
        i64::from(self.highest_rate.load(Ordering::Acquire))
    }

    /// Changes whenever the admission has told or ordered something: until then a player may go on as before.
    #[inline(always)]
    pub(super) fn changes(&self) -> u32 {
        self.changes.load(Ordering::Acquire)
    }

    /// After what has changed.
    pub(super) fn note_change(&self) {
        let changes = self.changes.load(Ordering::Relaxed);
        self.changes
            .store(changes.wrapping_add(1), Ordering::Release);
    }

    pub(super) fn set_status(&self, status: Status) {
        let word = (u32::from(status.generation) << 16) | u32::from(status.phase.number());
        self.status.store(word, Ordering::Release);
    }

    pub(super) fn status(&self) -> Status {
        let word = self.status.load(Ordering::Acquire);
        Status {
            generation: (word >> 16) as u16,
            phase: StreamPhase::of_number(word as u8),
        }
    }
}

/// The memory of a stream of segments: split into the [`Admission`](super::Admission) of the thread and
/// the [`Player`](super::Player) of the cycle.
///
/// `AXES` is the largest number of axes, `SEGMENTS` one more than the largest number of segments that wait. The halves share queues of one
/// writer and one reader, and words; neither ever waits for the other, and no interrupt is masked.
#[derive(Debug)]
pub struct SegmentQueue<const AXES: usize, const SEGMENTS: usize> {
    pub(super) segments: Queue<Admitted<AXES>, SEGMENTS>,
    pub(super) orders: Queue<Order<AXES>, ORDERS>,
    pub(super) shared: Shared,
}

impl<const AXES: usize, const SEGMENTS: usize> SegmentQueue<AXES, SEGMENTS> {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            segments: Queue::new(),
            orders: Queue::new(),
            shared: Shared::new(),
        }
    }
}

impl<const AXES: usize, const SEGMENTS: usize> Default for SegmentQueue<AXES, SEGMENTS> {
    fn default() -> Self {
        Self::new()
    }
}
