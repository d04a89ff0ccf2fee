//! The frames of a run as a candump log.

use core::fmt::Write as _;
use std::io::{self, Write};

use can_decode::Frame;

use super::about::{About, Origin};
use super::item::Item;
use super::keep::Keep;

/// A log in the making.
pub(super) struct Candump<W: Write> {
    to: W,
    interface: String,
    /// What times count from: a simulation's virtual time from 0, those of a real bus from 1970.
    from_ns: u64,
}

impl<W: Write> Candump<W> {
    pub(super) fn new(to: W, about: &About) -> Self {
        Self {
            to,
            interface: about.interface.clone(),
            from_ns: match about.origin {
                Origin::Simulation => 0,
                Origin::Bus | Origin::Log => about.started_unix_ns,
            },
        }
    }
}

impl<W: Write + Send> Keep for Candump<W> {
    fn keep(&mut self, item: &Item) -> io::Result<()> {
        let Item::Frame(frame) = item else {
            return Ok(());
        };
        if !frame.is_received {
            return Ok(());
        }
        let at_ns = self.from_ns.saturating_add(frame.end_ns);
        let line = candump_line(at_ns, &self.interface, &frame.frame);
        self.to.write_all(line.as_bytes())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }

    fn finish(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

/// A line of a candump log with its line end, as in `(1.002003) can0 03C#FF88`.
pub(crate) fn candump_line(at_ns: u64, interface: &str, frame: &Frame) -> String {
    let us = at_ns / 1_000;
    let mut line = format!("({}.{:06}) {interface} ", us / 1_000_000, us % 1_000_000);
    // Writing to a string cannot fail.
    let _ = if frame.is_extended() {
        write!(line, "{:08X}#", frame.id())
    } else {
        write!(line, "{:03X}#", frame.id())
    };
    if frame.is_remote() {
        let _ = write!(line, "R{}", frame.len());
    }
    for byte in frame.data() {
        let _ = write!(line, "{byte:02X}");
    }
    line.push('\n');
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use can_decode::log::{Event, LogReader};
    use proptest::prelude::*;

    #[test]
    fn golden_lines() {
        let line = |frame: Option<Frame>| candump_line(1_002_003_999, "can0", &frame.unwrap());
        assert_eq!(
            line(Frame::new(0x3C, false, &[0xFF, 0x88])),
            "(1.002003) can0 03C#FF88\n"
        );
        assert_eq!(
            line(Frame::new(0x3C, true, &[])),
            "(1.002003) can0 0000003C#\n"
        );
        assert_eq!(
            line(Frame::remote(0x3C, false, 4)),
            "(1.002003) can0 03C#R4\n"
        );
    }

    proptest! {
        #[test]
        fn the_reader_reads_every_frame_back(
            id in 0_u32..0x800,
            is_extended: bool,
            is_remote: bool,
            data in prop::collection::vec(any::<u8>(), 0..=8),
            at_us in 1_000_000_000_000_000_u64..2_000_000_000_000_000,
        ) {
            let frame = if is_remote {
                Frame::remote(id, is_extended, data.len() as u8)
            } else {
                Frame::new(id, is_extended, &data)
            };
            let frame = frame.unwrap();
            let line = candump_line(at_us * 1_000, "can1", &frame);
            let mut reader = LogReader::new();
            let entry = reader.line(&line).unwrap().unwrap();
            prop_assert_eq!(entry.event, Event::Frame(frame));
            prop_assert_eq!((entry.at_ns, entry.interface), (Some(at_us * 1_000), "can1"));
        }
    }
}
