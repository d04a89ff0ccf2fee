//! The Linux tool candump: its log (`-L`, `-l`) and its screen with times (`-t a`).
//!
//! `(1436509052.249713) can0 044#2A36`, with `R` or `T` behind it for received and sent;
//! `(1436509052.249713)  can0  044   [2]  2A 36`, with `RX - -` or `TX - -` before the identifier under `-x`.

use super::error::LineError;
use super::fields::{Data, TIME, Words, data_frame, hex_id, length, remote_frame, time_ns};
use super::{Entry, Event};

/// Flag of error frames in the identifier (`CAN_ERR_FLAG` of `linux/can.h`).
const ERROR_FLAG: u32 = 0x2000_0000;
/// Identifiers with more digits than this have 29 bits.
const STANDARD_DIGITS: usize = 3;
const NS_PER_S: u64 = 1_000_000_000;

pub(super) fn read(line: &str) -> Result<Entry<'_>, LineError> {
    let mut words = Words::of(line);
    let time = words.next(TIME)?;
    let inside = time
        .strip_prefix('(')
        .and_then(|time| time.strip_suffix(')'))
        .ok_or_else(|| LineError::field("a time in brackets", time))?;
    let at_ns = time_ns(inside, NS_PER_S)?;
    let interface = words.next("an interface")?;
    let frame = words.next("a frame")?;
    let event = match frame.split_once('#') {
        Some((id, data)) => log_frame(id, data)?,
        None => screen_frame(frame, words)?,
    };
    Ok(Entry {
        at_ns,
        interface,
        event,
    })
}

/// `044#2A36`, `044#R`, `044#R4`, `044##1...` for CAN FD.
fn log_frame(id: &str, data: &str) -> Result<Event, LineError> {
    let extended = id.len() > STANDARD_DIGITS;
    let id = hex_id(id)?;
    if id & ERROR_FLAG != 0 {
        return Ok(Event::ErrorFrame);
    }
    if data.starts_with('#') {
        return Ok(Event::FdFrame);
    }
    let frame = match data.strip_prefix(['R', 'r']) {
        Some("") => remote_frame(id, extended, 0)?,
        Some(len) => remote_frame(id, extended, length(len)?)?,
        None => data_frame(id, extended, Data::of_hex(data)?.as_slice())?,
    };
    Ok(Event::Frame(frame))
}

/// `044   [2]  2A 36`; two digits in the brackets for CAN FD.
fn screen_frame(first: &str, mut words: Words<'_>) -> Result<Event, LineError> {
    let mut id = first;
    if matches!(first, "RX" | "TX") {
        words.next("the flags of -x")?;
        words.next("the flags of -x")?;
        id = words.next("an identifier")?;
    }
    let extended = id.len() > STANDARD_DIGITS;
    let id = hex_id(id)?;
    let brackets = words.next("a data length in brackets")?;
    let len = brackets
        .strip_prefix('[')
        .and_then(|len| len.strip_suffix(']'))
        .ok_or_else(|| LineError::field("a data length in brackets", brackets))?;
    if id & ERROR_FLAG != 0 {
        return Ok(Event::ErrorFrame);
    }
    if len.len() > 1 {
        return Ok(Event::FdFrame);
    }
    let len = length(len)?;
    let is_remote = words.clone().next_if_any() == Some("remote");
    let frame = if is_remote {
        remote_frame(id, extended, len)?
    } else {
        data_frame(id, extended, words.data(len, 16)?.as_slice())?
    };
    Ok(Event::Frame(frame))
}
