//! Vector ASC, as python-can writes it too: times in seconds, absolute or from line to line; numbers hexadecimal or decimal.
//!
//! `0.001000 1  3C              Rx   d 2 FF 88`; an identifier ends in `x` when it has 29 bits; `r` stands for a remote frame. A
//! channel that can carry CAN FD is written as `CANFD`, and its flags say what each frame is. Everything else in the file is an
//! event of the tool: bus statistics, system variables, triggers.

use super::error::LineError;
use super::fields::{
    HIGHEST_CODE, TIME, Words, classic_length, data_frame, length, radix_id, remote_frame, time_ns,
};
use super::{Entry, Event};
use crate::frame::MAX_DATA_BYTES;

const NS_PER_S: u64 = 1_000_000_000;
/// Flags of a frame on a CAN FD channel: a remote frame, and the CAN FD format.
const REMOTE_FLAG: u32 = 0x10;
const FD_FORMAT_FLAG: u32 = 0x1000;
/// Most bytes of a CAN FD frame.
const MOST_FD_BYTES: usize = 64;

/// What the header and the lines so far tell.
#[derive(Debug, Clone, Default)]
pub(super) struct Asc {
    is_decimal: bool,
    /// Each time counts from the line before.
    is_relative: bool,
    now_ns: u64,
}

/// Whether a line is one of the header.
pub(super) fn is_heading(line: &str) -> bool {
    const HEADINGS: [&str; 8] = [
        "date ",
        "base ",
        "internal events logged",
        "no internal events logged",
        "begin triggerblock",
        "end triggerblock",
        "//",
        "previous log file",
    ];
    HEADINGS.iter().any(|heading| begins(line, heading))
}

fn begins(line: &str, begin: &str) -> bool {
    line.get(..begin.len())
        .is_some_and(|front| front.eq_ignore_ascii_case(begin))
}

impl Asc {
    pub(super) fn read<'a>(&mut self, line: &'a str) -> Result<Option<Entry<'a>>, LineError> {
        if begins(line, "base ") {
            self.base(line)?;
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
        let mut channel = words.next("a channel or an event")?;
        let event = if channel.eq_ignore_ascii_case("CANFD") {
            channel = words.next("a channel")?;
            self.event_of_fd_channel(words)?
        } else if channel.bytes().all(|byte| byte.is_ascii_digit()) {
            self.event(words)?
        } else if channel.eq_ignore_ascii_case("CAN") {
            channel = words.next("a channel")?;
            controller_state(words)
        } else {
            // Measurement, statistics and other events of the tool.
            None
        };
        Ok(event.map(|event| Entry {
            at_ns: Some(self.now_ns),
            interface: channel,
            event,
        }))
    }

    /// `base hex  timestamps absolute`.
    fn base(&mut self, line: &str) -> Result<(), LineError> {
        let mut words = Words::of(line);
        words.next("base")?;
        let lower = |word: Option<&str>| word.map(str::to_ascii_lowercase);
        let base = lower(words.next_if_any());
        let (stamps, kind) = (lower(words.next_if_any()), lower(words.next_if_any()));
        let known_base = matches!(base.as_deref(), Some("hex" | "dec"));
        let known_kind = match (stamps.as_deref(), kind.as_deref()) {
            (None, None) => true,
            (Some("timestamps"), kind) => matches!(kind, Some("absolute" | "relative")),
            _ => false,
        };
        if !known_base || !known_kind {
            let expected = "base hex or dec, timestamps absolute or relative";
            return Err(LineError::header(expected, line));
        }
        self.is_decimal = base.as_deref() == Some("dec");
        self.is_relative = kind.as_deref() == Some("relative");
        Ok(())
    }

    const fn radix(&self) -> u32 {
        if self.is_decimal { 10 } else { 16 }
    }

    /// An identifier; `x` behind it for 29 bits.
    fn id(&self, text: &str) -> Result<(u32, bool), LineError> {
        let extended = text.strip_suffix(['x', 'X']);
        let id = radix_id(extended.unwrap_or(text), self.radix())?;
        Ok((id, extended.is_some()))
    }

    /// What stands behind the number of a classic channel.
    fn event(&self, mut words: Words<'_>) -> Result<Option<Event>, LineError> {
        let id = words.next("an identifier or an event")?;
        if let Some(event) = error_event(id) {
            return Ok(Some(event));
        }
        match words.peek() {
            Some("Rx" | "Tx") => {}
            // A request to send is not on the bus yet: the frame follows.
            Some("TxRq") => return Ok(None),
            // Events have words where frames have an identifier.
            _ if self.id(id).is_err() => return Ok(None),
            Some(other) => return Err(LineError::field("Rx or Tx", other)),
            None => {
                return Err(LineError::Missing {
                    expected: "Rx or Tx",
                });
            }
        }
        let (id, extended) = self.id(id)?;
        words.next("Rx or Tx")?;
        let frame = match words.next("d or r")? {
            "d" | "D" => {
                let code = words.next("a data length")?;
                if self.is_fd_length(code) {
                    return Ok(Some(Event::FdFrame));
                }
                let len = classic_length(code, self.radix())?;
                data_frame(id, extended, words.data(len, self.radix())?.as_slice())?
            }
            "r" | "R" => {
                let code = words.next_if_any().filter(|word| *word != "Length");
                let len = code.map_or(Ok(0), |code| classic_length(code, self.radix()))?;
                remote_frame(id, extended, len)?
            }
            other => return Err(LineError::field("d or r", other)),
        };
        Ok(Some(Event::Frame(frame)))
    }

    /// Early versions of python-can write CAN FD frames as classic ones.
    fn is_fd_length(&self, code: &str) -> bool {
        usize::from_str_radix(code, self.radix())
            .is_ok_and(|len| (HIGHEST_CODE + 1..=MOST_FD_BYTES).contains(&len))
    }

    /// `Rx 29 [name] 0 0 1 1 00 0 0 1000 ...`: direction, identifier, bit rate switch, error state, length code, length, data,
    /// duration, bits, flags.
    fn event_of_fd_channel(&self, mut words: Words<'_>) -> Result<Option<Event>, LineError> {
        match words.next("Rx or Tx")? {
            "Rx" | "Tx" => {}
            "TxRq" => return Ok(None),
            other => return Err(LineError::field("Rx or Tx", other)),
        }
        let id = words.next("an identifier")?;
        if let Some(event) = error_event(id) {
            return Ok(Some(event));
        }
        let (id, extended) = self.id(id)?;
        let mut switch = words.next("0 or 1 for the bit rate switch")?;
        if !matches!(switch, "0" | "1") {
            // The name of the message in the database.
            switch = words.next("0 or 1 for the bit rate switch")?;
        }
        let state = words.next("0 or 1 for the error state")?;
        for flag in [switch, state] {
            if !matches!(flag, "0" | "1") {
                return Err(LineError::field("0 or 1", flag));
            }
        }
        let code = words.next("a length code")?;
        let len: usize = number(words.next("a data length")?)?;
        if len > MOST_FD_BYTES {
            return Err(LineError::field("a data length 0..=64", &len.to_string()));
        }
        let mut behind = words.clone();
        for _ in 0..len {
            behind.next("a data byte")?;
        }
        behind.next("the duration of the message")?;
        behind.next("the bits of the message")?;
        let flags = behind.next("the flags of the message")?;
        let flags = u32::from_str_radix(flags, 16).map_err(|_| LineError::field("flags", flags))?;
        // The flags are missing in the logs of some tools.
        let is_fd = len > MAX_DATA_BYTES || switch == "1" || state == "1";
        if is_fd || flags & FD_FORMAT_FLAG != 0 {
            return Ok(Some(Event::FdFrame));
        }
        let frame = if flags & REMOTE_FLAG != 0 {
            remote_frame(id, extended, classic_length(code, 16)?)?
        } else {
            let len = length(&len.to_string())?;
            // Numbers of other things follow.
            data_frame(
                id,
                extended,
                words.first_data(len, self.radix())?.as_slice(),
            )?
        };
        Ok(Some(Event::Frame(frame)))
    }
}

fn number(text: &str) -> Result<usize, LineError> {
    text.parse().map_err(|_| LineError::field("a number", text))
}

/// `ErrorFrame`, `OverloadFrame`, whatever follows them.
fn error_event(word: &str) -> Option<Event> {
    if word.eq_ignore_ascii_case("ErrorFrame") {
        Some(Event::ErrorFrame)
    } else if word.eq_ignore_ascii_case("OverloadFrame") {
        Some(Event::OverloadFrame)
    } else {
        None
    }
}

/// `Status:chip status error passive`.
fn controller_state(mut words: Words<'_>) -> Option<Event> {
    words
        .next_if_any()
        .filter(|word| begins(word, "Status:"))
        .map(|_| Event::ControllerState)
}
