//! What hosts have asked of the board.

use core::fmt;

use board_link::message::Counters;
use schemars::JsonSchema;
use serde::Serialize;

use crate::counted::counted;

/// A board at the end.
#[derive(Debug, Clone, Copy, Default, Serialize, JsonSchema)]
pub(in crate::bench) struct BoardReport {
    /// Starts, the first one included.
    starts: u64,
    /// Cycles since the latest.
    cycles: u64,
    /// Messages of hosts that were right, and that were lost on the way: damaged, or of another version.
    messages: u64,
    lost_messages: u64,
    /// Requests that were refused.
    refused_requests: u64,
    /// Segments that were taken.
    segments: u64,
    /// Hosts that were silent for too long.
    silent_hosts: u64,
    /// Cycles that were late on the bus.
    late_cycles: u64,
}

impl BoardReport {
    /// One start more, with what came in since then.
    pub(super) fn add(&mut self, cycles: u64, counters: &Counters) {
        let losses = &counters.losses;
        let lost = losses.length + losses.stuffing + losses.checksum + losses.version + losses.body;
        self.starts += 1;
        self.cycles = cycles;
        self.messages += u64::from(counters.frames);
        self.lost_messages += u64::from(lost);
        self.refused_requests += u64::from(counters.refused);
        self.segments += u64::from(counters.segments);
        self.silent_hosts += u64::from(counters.silent_hosts);
        self.late_cycles += u64::from(counters.late_cycles);
    }
}

impl fmt::Display for BoardReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "The board: {}, {} of hosts and {} lost; {} refused; {}; silent hosts: {}; late cycles: {}",
            counted(self.starts, "start", "starts"),
            counted(self.messages, "message", "messages"),
            self.lost_messages,
            counted(self.refused_requests, "request", "requests"),
            counted(self.segments, "segment", "segments"),
            self.silent_hosts,
            self.late_cycles,
        )
    }
}
