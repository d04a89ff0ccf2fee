//! The log as text, in the format of the Linux tool `candump -l`.
//!
//! Specification: the time is that of the end of the frame, when a receiver has it; only frames that receivers got are shown. One line reads
//! `(0.001234) can0 03C#FF88`.

use core::fmt;

use crate::frame::Frame;
use crate::log::Record;

/// One line of a candump log, without its line end; written by `Display`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CandumpLine<'a> {
    end_ns: u64,
    interface: &'a str,
    frame: Frame,
}

impl<'a> CandumpLine<'a> {
    /// The line of `record` as seen on `interface`, or `None` when no receiver got the frame.
    pub fn new(record: &Record, interface: &'a str) -> Option<Self> {
        record.outcome.is_received().then_some(Self {
            end_ns: record.end_ns,
            interface,
            frame: record.frame,
        })
    }
}

impl fmt::Display for CandumpLine<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let us = self.end_ns / 1_000;
        write!(
            f,
            "({}.{:06}) {} {}",
            us / 1_000_000,
            us % 1_000_000,
            self.interface,
            self.frame
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::tests::{extended, remote, standard};
    use crate::log::Outcome;
    use crate::node::NodeId;

    fn record(end_ns: u64, frame: Frame, outcome: Outcome) -> Record {
        Record {
            start_ns: 0,
            end_ns,
            free_ns: end_ns,
            node: NodeId(0),
            senders: 1,
            frame,
            outcome,
        }
    }

    fn line(record: &Record) -> Option<String> {
        CandumpLine::new(record, "can0").map(|line| line.to_string())
    }

    #[test]
    fn golden_lines() {
        let lines = [
            (
                record(
                    1_234_000,
                    standard(0x03C, &[0xFF, 0x88]),
                    Outcome::Delivered,
                ),
                "(0.001234) can0 03C#FF88",
            ),
            (
                record(12_000_001_999, remote(0x7FF, 0), Outcome::Delivered),
                "(12.000001) can0 7FF#R",
            ),
            (
                record(999, extended(0x12345, &[0]), Outcome::EofError),
                "(0.000000) can0 00012345#00",
            ),
        ];
        for (record, want) in lines {
            assert_eq!(line(&record).as_deref(), Some(want));
        }
    }

    #[test]
    fn frames_that_nobody_got_have_no_line() {
        for outcome in [
            Outcome::BitError,
            Outcome::Collision,
            Outcome::AckError,
            Outcome::Interrupted,
        ] {
            assert_eq!(line(&record(0, standard(1, &[]), outcome)), None);
        }
    }
}
