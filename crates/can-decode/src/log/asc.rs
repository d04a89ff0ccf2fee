//! Vector ASC, as python-can writes it too: times in seconds, absolute or from line to line; numbers hexadecimal or decimal.
//!
//! `0.001000 1  3C              Rx   d 2 FF 88`; an identifier ends in `x` when it has 29 bits; `r` stands for a remote frame.

use super::error::LineError;
use super::fields::{TIME, Words, data_frame, length, radix_id, remote_frame, time_ns};
use super::{Entry, Event};

const NS_PER_S: u64 = 1_000_000_000;

/// What the header and the lines so far tell.
#[derive(Debug, Clone, Default)]
pub(super) struct Header {
    is_decimal: bool,
    /// Each time counts from the line before.
    is_relative: bool,
    now_ns: u64,
}

impl Header {
    pub(super) fn read<'a>(&mut self, line: &'a str) -> Result<Option<Entry<'a>>, LineError> {
        if line.starts_with("base ") {
            self.is_decimal = line.contains("base dec");
            self.is_relative = line.contains("timestamps relative");
            return Ok(None);
        }
        if is_heading(line) {
            return Ok(None);
        }
        let mut words = Words::of(line);
        let time_ns = time_ns(words.next(TIME)?, NS_PER_S)?;
        self.now_ns = if self.is_relative {
            self.now_ns.saturating_add(time_ns)
        } else {
            time_ns
        };
        let mut channel = words.next("a channel")?;
        let event = match channel {
            "CANFD" => {
                channel = words.next("a channel")?;
                Some(Event::FdFrame)
            }
            _ if channel.bytes().all(|byte| byte.is_ascii_digit()) => self.event(words)?,
            // Measurement, statistics and other events of the tool.
            _ => None,
        };
        Ok(event.map(|event| Entry {
            at_ns: self.now_ns,
            interface: channel,
            event,
        }))
    }

    fn event(&self, mut words: Words<'_>) -> Result<Option<Event>, LineError> {
        let id = words.next("an identifier")?;
        if id.eq_ignore_ascii_case("ErrorFrame") {
            return Ok(Some(Event::ErrorFrame));
        }
        if id.ends_with(':') {
            // `Statistic:` and the like.
            return Ok(None);
        }
        let radix = if self.is_decimal { 10 } else { 16 };
        let standard = id.strip_suffix(['x', 'X']);
        let (extended, id) = (standard.is_some(), radix_id(standard.unwrap_or(id), radix)?);
        words.next("Rx or Tx")?;
        let kind = words.next("d or r")?;
        let frame = match kind {
            "d" | "D" => {
                let len = length(words.next("a data length")?)?;
                data_frame(id, extended, words.data(len, radix)?.as_slice())?
            }
            "r" | "R" => {
                let len = words.next_if_any().map_or(Ok(0), length)?;
                remote_frame(id, extended, len)?
            }
            other => return Err(LineError::field("d or r", other)),
        };
        Ok(Some(Event::Frame(frame)))
    }
}

/// Lines around the traffic.
fn is_heading(line: &str) -> bool {
    const HEADINGS: [&str; 7] = [
        "date ",
        "internal events logged",
        "no internal events logged",
        "begin triggerblock",
        "end triggerblock",
        "//",
        "previous log file",
    ];
    HEADINGS.iter().any(|heading| {
        line.get(..heading.len())
            .is_some_and(|begin| begin.eq_ignore_ascii_case(heading))
    })
}
