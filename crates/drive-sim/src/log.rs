//! Traffic log: one record for each attempt on the wire.
//!
//! Specification: one bus, one frame at a time. Records are in order and never overlap, interframe space and error frames included.

use std::collections::VecDeque;

use crate::frame::Frame;
use crate::node::NodeId;

/// How an attempt ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Outcome {
    /// Received by all that listen, acknowledged.
    Delivered,
    /// Received by all that listen, but the sender saw an error in the last bit of EOF and repeats the frame.
    EofError,
    /// Destroyed by a bit error; repeated.
    BitError,
    /// Senders of the same identifier with different contents destroyed each other's frames; all repeat.
    Collision,
    /// Nobody acknowledged; repeated.
    AckError,
    /// The sender left the bus in mid-frame.
    Interrupted,
}

impl Outcome {
    /// Whether receivers have the frame.
    pub fn is_received(self) -> bool {
        matches!(self, Self::Delivered | Self::EofError)
    }
}

/// One attempt on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Record {
    /// Start of frame.
    pub start_ns: u64,
    /// End of the last EOF bit, or of the bit in which the error was seen.
    pub end_ns: u64,
    /// End of the interframe space behind the frame or its error frame: from then on the bus is idle.
    pub free_ns: u64,
    /// The sender; the first one registered when there were several.
    pub node: NodeId,
    /// Nodes that sent this frame at once: 1, or more after equal identifiers met.
    pub senders: u16,
    /// What that sender sent.
    pub frame: Frame,
    /// How it ended.
    pub outcome: Outcome,
}

/// How much of the traffic is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LogMode {
    /// Nothing.
    #[default]
    Off,
    /// The newest records, at most this many.
    Ring(usize),
    /// Everything; grows without limit.
    Full,
}

/// Records of the traffic, oldest first.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct TrafficLog {
    mode: LogMode,
    records: VecDeque<Record>,
}

impl TrafficLog {
    /// An empty log. A ring reserves its memory here.
    pub fn new(mode: LogMode) -> Self {
        let capacity = if let LogMode::Ring(capacity) = mode {
            capacity
        } else {
            0
        };
        Self {
            mode,
            records: VecDeque::with_capacity(capacity),
        }
    }

    /// How much is kept.
    pub fn mode(&self) -> LogMode {
        self.mode
    }

    /// Number of records kept.
    pub fn len(&self) -> usize {
        self.records.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.records.is_empty()
    }

    /// The records, oldest first.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = &Record> + ExactSizeIterator {
        self.records.iter()
    }

    /// Takes the records out, oldest first; the log goes on empty.
    pub fn drain(&mut self) -> impl Iterator<Item = Record> + '_ {
        self.records.drain(..)
    }

    pub(crate) fn push(&mut self, record: Record) {
        match self.mode {
            LogMode::Off | LogMode::Ring(0) => return,
            LogMode::Ring(capacity) if self.records.len() == capacity => {
                self.records.pop_front();
            }
            LogMode::Ring(_) | LogMode::Full => {}
        }
        self.records.push_back(record);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::tests::standard;

    fn kept(mode: LogMode) -> Vec<u64> {
        let mut log = TrafficLog::new(mode);
        for start_ns in 0..5 {
            let outcome = Outcome::Delivered;
            let (node, frame) = (NodeId(0), standard(1, &[]));
            log.push(Record {
                start_ns,
                end_ns: 0,
                free_ns: 0,
                node,
                senders: 1,
                frame,
                outcome,
            });
        }
        log.iter().map(|record| record.start_ns).collect()
    }

    #[test]
    fn modes_keep_what_they_say() {
        assert_eq!(kept(LogMode::Off), []);
        assert_eq!(kept(LogMode::Ring(0)), []);
        assert_eq!(kept(LogMode::Ring(2)), [3, 4]);
        assert_eq!(kept(LogMode::Full), [0, 1, 2, 3, 4]);
    }
}
