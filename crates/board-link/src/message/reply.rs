//! What a board answers.

use serde::{Deserialize, Serialize};

use super::{Chunk, Origin, Text};
use crate::frame::Losses;

/// The answer to a request that was carried out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub enum Answer {
    /// It is done.
    Done,
    /// To `Hello`.
    Info(Info),
    /// To `TimeSync`.
    Time {
        /// That of the request.
        host_us: u64,
        /// The cycle of the board.
        cycle: u64,
    },
    /// To `ReadSettings`.
    Settings {
        /// Bytes of all settings.
        length: u32,
        /// Their checksum.
        checksum: u32,
        /// The first byte of the piece.
        offset: u32,
        /// The piece.
        bytes: Chunk,
    },
    /// To `ReadFault`.
    Fault(FaultEntry),
    /// To `ReadCounters`.
    Counters(Counters),
    /// To `Events`.
    Events {
        /// The number of the oldest that is kept.
        oldest: u32,
        /// That of the next that will happen.
        next: u32,
    },
    /// To `Claim`.
    Claimed {
        /// So many cycles without a request of the session are a silent host, which is a stop.
        silence: u32,
        /// The number of the next event.
        events: u32,
    },
    /// To `Heartbeat`.
    Alive {
        /// The number of the next event.
        events: u32,
        /// The index of the next segment of the stream that was begun last.
        next: u32,
        /// So many may be sent from that one on.
        credit: u32,
    },
    /// To `Segment`, also to one that was there already.
    Taken {
        /// The index of the next segment.
        next: u32,
        /// So many may be sent from that one on.
        credit: u32,
    },
    /// To `WriteSettings`, also to a piece that was there already.
    Staged {
        /// Bytes that are there.
        received: u32,
    },
    /// To `ReadOrigin`.
    Origin(Origin),
}

/// What a board is.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Info {
    /// The board.
    pub board: Text,
    /// The version of the firmware.
    pub firmware: Text,
    /// The number of its start. Another one than before says that it was reset; so does an `uptime` that is less than expected, because a
    /// board without a supply forgets starts in which nothing happened.
    pub boot: u32,
    /// The cycle in microseconds.
    pub cycle_us: u32,
    /// Cycles since the start.
    pub uptime: u64,
    /// Number of axes; 0 without settings.
    pub axes: u8,
    /// Segments that the board keeps.
    pub segments: u16,
    /// Most bytes of settings.
    pub settings: u32,
    /// Entries of the fault log.
    pub faults: u32,
}

/// An entry of the fault log.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct FaultEntry {
    /// Counts the faults of the board for ever.
    pub number: u32,
    /// [`Info::boot`] of the start in which it happened.
    pub boot: u32,
    /// Milliseconds since that start.
    pub uptime_ms: u32,
    /// The version of the firmware.
    pub firmware: Text,
    /// The axis, where it is about one.
    pub axis: Option<u8>,
    /// The application's number of the fault.
    pub code: u16,
    /// What else is known of it.
    pub detail: i32,
    /// The place in the program, for a panic.
    pub place: Text,
}

/// What came in, and what was lost. A sum ends at its largest value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Counters {
    /// Frames that were right.
    pub frames: u32,
    /// Frames that were lost, by why.
    pub losses: Losses,
    /// Requests that were repeated and answered again.
    pub repeated: u32,
    /// Requests that were refused.
    pub refused: u32,
    /// Requests that were not answered, because nobody takes the bytes.
    pub unanswered: u32,
    /// Snapshots that were left out for the same reason.
    pub snapshots_left_out: u32,
    /// Events that were overwritten before this host took them.
    pub events_lost: u32,
    /// Segments that were taken.
    pub segments: u32,
    /// Hosts that were silent for too long.
    pub silent_hosts: u32,
    /// Cycles that were late.
    pub late_cycles: u32,
}
