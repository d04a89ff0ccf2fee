//! PEAK TRC: times in milliseconds from the start of the log.
//!
//! Version 1.0: `1)  535  0300 7 00 00 00 00 04 00 00`; version 2.1: `1  1059.900 DT 1  0300 Rx -  7  00 00 00 00 04 00 00`, with the
//! columns that python-can writes. A 29-bit identifier has more than four digits.

use super::error::LineError;
use super::fields::{TIME, Words, data_frame, hex_id, length, remote_frame, time_ns};
use super::{Entry, Event};

const NS_PER_MS: u64 = 1_000_000;
const STANDARD_DIGITS: usize = 4;
/// The columns of version 2.1 that are read.
const COLUMNS: &str = "N,O,T,B,I,d,R,L,D";

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
enum Version {
    #[default]
    V1_0,
    V2_1,
}

/// What the header tells.
#[derive(Debug, Clone, Default)]
pub(super) struct Header {
    version: Version,
}

impl Header {
    pub(super) fn read<'a>(&mut self, line: &'a str) -> Result<Option<Entry<'a>>, LineError> {
        if let Some(comment) = line.strip_prefix(';') {
            return self.header(comment).map(|()| None);
        }
        let mut words = Words::of(line);
        words.next("a number")?;
        let at_ns = time_ns(words.next(TIME)?, NS_PER_MS)?;
        let (interface, event) = match self.version {
            Version::V1_0 => ("1", old_frame(words)?),
            Version::V2_1 => new_frame(words)?,
        };
        Ok(Some(Entry {
            at_ns,
            interface,
            event,
        }))
    }

    fn header(&mut self, comment: &str) -> Result<(), LineError> {
        if let Some(version) = comment.strip_prefix("$FILEVERSION=") {
            self.version = match version.trim_ascii() {
                "2.1" => Version::V2_1,
                "1.0" => Version::V1_0,
                other => {
                    return Err(LineError::TrcVersion {
                        actual: other.to_owned(),
                    });
                }
            };
        } else if let Some(columns) = comment.strip_prefix("$COLUMNS=")
            && columns.trim_ascii() != COLUMNS
        {
            return Err(LineError::field("the columns N,O,T,B,I,d,R,L,D", columns));
        }
        Ok(())
    }
}

fn identifier(text: &str) -> Result<(u32, bool), LineError> {
    Ok((hex_id(text)?, text.len() > STANDARD_DIGITS))
}

/// `0300 7 00 00 00 00 04 00 00`, `0300 4 RTR`, `FFFFFFFF` for errors.
fn old_frame(mut words: Words<'_>) -> Result<Event, LineError> {
    let id = words.next("an identifier")?;
    if id == "FFFFFFFF" {
        return Ok(Event::ErrorFrame);
    }
    let (id, extended) = identifier(id)?;
    let len = length(words.next("a data length")?)?;
    let frame = if words.clone().next_if_any() == Some("RTR") {
        remote_frame(id, extended, len)?
    } else {
        data_frame(id, extended, words.data(len, 16)?.as_slice())?
    };
    Ok(Event::Frame(frame))
}

/// `DT 1  0300 Rx -  7  00 00 00 00 04 00 00`: type, bus, identifier, direction, reserved, length, data.
fn new_frame<'a>(mut words: Words<'a>) -> Result<(&'a str, Event), LineError> {
    let kind = words.next("a type such as DT")?;
    let bus = words.next("a bus")?;
    let event = match kind {
        "DT" | "RR" => {
            let (id, extended) = identifier(words.next("an identifier")?)?;
            words.next("Rx or Tx")?;
            words.next("the reserved column")?;
            let len = length(words.next("a data length")?)?;
            Event::Frame(if kind == "RR" {
                remote_frame(id, extended, len)?
            } else {
                data_frame(id, extended, words.data(len, 16)?.as_slice())?
            })
        }
        "FD" | "FB" | "FE" | "BI" => Event::FdFrame,
        "ER" | "ST" | "EC" => Event::ErrorFrame,
        other => return Err(LineError::field("a type such as DT", other)),
    };
    Ok((bus, event))
}
