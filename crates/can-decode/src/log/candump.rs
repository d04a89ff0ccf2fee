//! The Linux tool candump: its log (`-L`, `-l`) and its screen, with or without times and colours.
//!
//! `(1436509052.249713) can0 044#2A36`, with `R` or `T` behind it for received and sent, `_B` for a length code above 8;
//! `(1436509052.249713)  can0  044   [2]  2A 36`, with `RX - -` or `TX - -` before the identifier under `-x`, the length in braces
//! under `-8`, bytes in binary under `-i` and from the last to the first under `-S` (`lib.c` of can-utils).

use super::error::LineError;
use super::fields::{Data, Words, byte, classic_length, data_frame, hex_id, length, remote_frame};
use super::stamps::Clock;
use super::{Entry, Event};

/// Flag of error frames in the identifier (`CAN_ERR_FLAG` of `linux/can.h`).
const ERROR_FLAG: u32 = 0x2000_0000;
/// Identifiers of 11 bits have at most as many digits, those of 29 bits all eight.
const STANDARD_DIGITS: usize = 3;
const EXTENDED_DIGITS: usize = 8;
/// What a length code above 8 stands behind.
const CODE_DELIMITER: char = '_';
/// What bytes stand between under `-S`.
const SWAPPED: char = '`';

/// Reads the lines of one log.
#[derive(Debug, Clone, Default)]
pub(super) struct Candump {
    pub(super) clock: Clock,
}

/// Whether a line without a time is one of candump's screen.
pub(super) fn is_screen_line(line: &str) -> bool {
    let mut words = Words::of(line);
    let (Some(_interface), Some(mut id)) = (words.next_if_any(), words.next_if_any()) else {
        return false;
    };
    if matches!(id, "RX" | "TX") {
        words.next_if_any();
        words.next_if_any();
        id = words.next_if_any().unwrap_or_default();
    }
    hex_id(id).is_ok()
        && words
            .next_if_any()
            .is_some_and(|word| brackets(word).is_some())
}

impl Candump {
    /// Reads a line; `indented` lines explain the error frame before them (`-e`).
    pub(super) fn read<'a>(
        &mut self,
        line: &'a str,
        indented: bool,
    ) -> Result<Option<Entry<'a>>, LineError> {
        if indented {
            return Ok(None);
        }
        if line.starts_with("DROPCOUNT:") {
            return Err(LineError::lost(line));
        }
        let mut words = Words::of(line);
        let at_ns = self.clock.read(&mut words)?;
        let interface = words.next("an interface")?;
        let frame = words.next("a frame")?;
        let event = match frame.split_once('#') {
            Some((id, data)) => log_frame(id, data, words)?,
            None => screen_frame(frame, words)?,
        };
        Ok(Some(Entry {
            at_ns,
            interface,
            event,
        }))
    }
}

/// `044#2A36`, `044#R`, `044#R4`, `044#R8_C`, `044#1122334455667788_B`, `044##1...` for CAN FD.
fn log_frame(id: &str, data: &str, mut behind: Words<'_>) -> Result<Event, LineError> {
    match behind.next_if_any() {
        None | Some("R" | "T" | "r" | "t") => {}
        Some(other) => return Err(LineError::field("R, T or the end of the line", other)),
    }
    let (id, extended) = identifier(id)?;
    if id & ERROR_FLAG != 0 {
        return Ok(Event::ErrorFrame);
    }
    if data.starts_with('#') {
        return Ok(Event::FdFrame);
    }
    let (data, code) = match data.split_once(CODE_DELIMITER) {
        Some((data, code)) => (data, Some(code)),
        None => (data, None),
    };
    let (frame, len) = match data.strip_prefix(['R', 'r']) {
        Some("") => (remote_frame(id, extended, 0)?, 0),
        Some(text) => {
            let len = length(text)?;
            (remote_frame(id, extended, len)?, len)
        }
        None => {
            let data = Data::of_hex(data)?;
            let data = data.as_slice();
            (data_frame(id, extended, data)?, data.len())
        }
    };
    if let Some(code) = code
        && !(len == 8 && matches!(u8::from_str_radix(code, 16), Ok(9..=15)))
    {
        return Err(LineError::field("a length code 9..=F behind 8 bytes", code));
    }
    Ok(Event::Frame(frame))
}

/// An identifier, and whether it has 29 bits; one with digits in between was cut or is no identifier.
fn identifier(text: &str) -> Result<(u32, bool), LineError> {
    match text.len() {
        1..=STANDARD_DIGITS => Ok((hex_id(text)?, false)),
        EXTENDED_DIGITS => Ok((hex_id(text)?, true)),
        _ => Err(LineError::field("an identifier of 3 or 8 digits", text)),
    }
}

/// What stands in brackets or, under `-8`, in braces.
fn brackets(word: &str) -> Option<(&str, bool)> {
    let inside = |open, close| word.strip_prefix(open)?.strip_suffix(close);
    let raw = |open, close| inside(open, close);
    match raw('[', ']') {
        Some(len) => Some((len, false)),
        None => Some((raw('{', '}')?, true)),
    }
}

/// `044   [2]  2A 36`; two digits in the brackets for CAN FD.
fn screen_frame(first: &str, mut words: Words<'_>) -> Result<Event, LineError> {
    let mut id = first;
    if matches!(first, "RX" | "TX") {
        words.next("the flags of -x")?;
        words.next("the flags of -x")?;
        id = words.next("an identifier")?;
    }
    let (id, extended) = identifier(id)?;
    let word = words.next("a data length in brackets")?;
    let (len, is_code) =
        brackets(word).ok_or_else(|| LineError::field("a data length in brackets", word))?;
    if id & ERROR_FLAG != 0 {
        return Ok(Event::ErrorFrame);
    }
    if len.len() > 1 {
        return Ok(Event::FdFrame);
    }
    let len = if is_code {
        classic_length(len, 16)?
    } else {
        length(len)?
    };
    let frame = if words.peek() == Some("remote") {
        remote_frame(id, extended, len)?
    } else {
        data_frame(id, extended, screen_data(words, len)?.as_slice())?
    };
    Ok(Event::Frame(frame))
}

/// `2A 36`, `00101010 00110110` or, from the last byte to the first, ``36`2A``.
fn screen_data(mut words: Words<'_>, len: usize) -> Result<Data, LineError> {
    let swapped = words.peek().filter(|word| word.contains(SWAPPED));
    let mut data = Data::default();
    let mut parts = swapped.unwrap_or_default().split(SWAPPED);
    for index in 0..len {
        let next = match swapped {
            Some(_) => parts.next(),
            None => words.next_if_any(),
        };
        let word = next.ok_or(LineError::DataLength {
            expected: len,
            actual: index,
        })?;
        let radix = if word.len() == 8 { 2 } else { 16 };
        data.push(byte(word, radix)?)?;
    }
    if swapped.is_none() {
        words.no_more_data(len, 16)?;
    }
    if swapped.is_some() {
        if parts.next().is_some() {
            return Err(LineError::DataLength {
                expected: len,
                actual: len + 1,
            });
        }
        data.reverse();
    }
    Ok(data)
}
