//! python-can's Printer and its logger on the terminal, as versions 3 and 4 write them.
//!
//! `Timestamp:  0.001000    ID: 03c    S Rx    DL:  2    ff 88    Channel: can0`; `X` for 29 bits, `R` and `E` behind the direction for
//! remote and error frames, `F` for CAN FD. Version 3 has `DLC:` in place of `DL:` and no direction.

use super::error::LineError;
use super::fields::{TIME, Words, data_frame, hex_id, length, remote_frame, time_ns};
use super::{Entry, Event};

const NS_PER_S: u64 = 1_000_000_000;

pub(super) fn read(line: &str) -> Result<Entry<'_>, LineError> {
    let mut words = Words::of(line);
    expect(&mut words, "Timestamp:")?;
    let at_ns = time_ns(words.next(TIME)?, NS_PER_S)?;
    expect(&mut words, "ID:")?;
    let id = hex_id(words.next("an identifier")?)?;
    let kind = words.next("S or X")?;
    let extended = match kind {
        "S" => false,
        "X" => true,
        other => return Err(LineError::field("S or X", other)),
    };
    let flags = Flags::read(&mut words)?;
    let len = words.next("a data length")?;
    let event = if flags.error {
        Event::ErrorFrame
    } else if flags.fd {
        Event::FdFrame
    } else if flags.remote {
        Event::Frame(remote_frame(id, extended, length(len)?)?)
    } else {
        let data = words.data(length(len)?, 16)?;
        Event::Frame(data_frame(id, extended, data.as_slice())?)
    };
    Ok(Entry {
        at_ns: Some(at_ns),
        interface: channel(line),
        event,
    })
}

#[derive(Debug, Clone, Copy, Default)]
struct Flags {
    error: bool,
    remote: bool,
    fd: bool,
}

impl Flags {
    /// Everything up to the data length.
    fn read(words: &mut Words<'_>) -> Result<Self, LineError> {
        let mut flags = Self::default();
        loop {
            match words.next("DL:")? {
                "DL:" | "DLC:" => return Ok(flags),
                "E" => flags.error = true,
                "R" => flags.remote = true,
                "F" => flags.fd = true,
                "Rx" | "Tx" | "BS" | "EI" => {}
                other => return Err(LineError::field("Rx, Tx or a flag", other)),
            }
        }
    }
}

fn expect(words: &mut Words<'_>, expected: &'static str) -> Result<(), LineError> {
    let actual = words.next(expected)?;
    if actual == expected {
        Ok(())
    } else {
        Err(LineError::field(expected, actual))
    }
}

fn channel(line: &str) -> &str {
    line.rsplit_once("Channel: ")
        .map_or("", |(_, channel)| channel.trim_ascii())
}
