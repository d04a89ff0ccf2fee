//! PEAK TRC, versions 1.0 to 2.1: times in milliseconds from the start of the log.
//!
//! | Version | Columns |
//! |---|---|
//! | 1.0 | `1)  535  0300 7 00 00 00 00 04 00 00` |
//! | 1.1 | the same with a type (`Rx`, `Tx`, `Warng`, `Error`) before the identifier |
//! | 1.2 | the same with a bus before the type |
//! | 1.3 | the same with a reserved column behind the identifier |
//! | 2.0, 2.1 | as the line `;$COLUMNS=` says |
//!
//! A 29-bit identifier has more than four digits. Facts: PEAK CAN TRC File Format (2023-08-22).

use super::error::LineError;
use super::fields::{TIME, Words, bus, classic_length, data_frame, hex_id, remote_frame, time_ns};
use super::{Entry, Event};

const NS_PER_MS: u64 = 1_000_000;
const STANDARD_DIGITS: usize = 4;
/// Identifier of the lines of version 1.0 that tell the state of the controller.
const STATE_ID: &str = "FFFFFFFF";
/// The bus of a log that does not name it.
const ONLY_BUS: &str = "1";

/// A column, as its letter in `$COLUMNS` says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Column {
    Number,
    Time,
    Type,
    Bus,
    Identifier,
    Direction,
    Reserved,
    Length,
    Data,
}

impl Column {
    fn of_letter(letter: &str) -> Option<Self> {
        Some(match letter {
            "N" => Self::Number,
            "O" => Self::Time,
            "T" => Self::Type,
            "B" => Self::Bus,
            "I" => Self::Identifier,
            "d" => Self::Direction,
            "R" => Self::Reserved,
            "l" | "L" => Self::Length,
            "D" => Self::Data,
            _ => return None,
        })
    }
}

/// What the header tells.
#[derive(Debug, Clone)]
pub(super) struct Trc {
    columns: Vec<Column>,
    /// Versions from 2 on, which name their columns.
    is_new: bool,
}

impl Default for Trc {
    /// Version 1.0 has no line that says so.
    fn default() -> Self {
        use Column::{Data, Identifier, Length, Number, Time};
        Self {
            columns: vec![Number, Time, Identifier, Length, Data],
            is_new: false,
        }
    }
}

/// The parts of a line.
#[derive(Debug, Default)]
struct Parts<'a> {
    at_ns: Option<u64>,
    kind: Option<&'a str>,
    bus: Option<&'a str>,
    id: Option<&'a str>,
    length: Option<&'a str>,
}

impl Trc {
    pub(super) fn read<'a>(&mut self, line: &'a str) -> Result<Option<Entry<'a>>, LineError> {
        if let Some(comment) = line.strip_prefix(';') {
            return self.header(comment).map(|()| None);
        }
        if self.columns.is_empty() {
            return Err(LineError::header(
                "a line ;$COLUMNS= before the first frame",
                line,
            ));
        }
        let mut words = Words::of(line);
        let mut parts = Parts::default();
        for column in &self.columns {
            if let Some(event) = self.take(*column, &mut words, &mut parts)? {
                let (at_ns, interface) = (parts.at_ns, parts.bus.unwrap_or(ONLY_BUS));
                return Ok(event.map(|event| Entry {
                    at_ns,
                    interface,
                    event,
                }));
            }
        }
        let event = self.frame(&parts, words)?;
        Ok(Some(Entry {
            at_ns: parts.at_ns,
            interface: parts.bus.unwrap_or(ONLY_BUS),
            event,
        }))
    }

    fn header(&mut self, comment: &str) -> Result<(), LineError> {
        if let Some(version) = comment.strip_prefix("$FILEVERSION=") {
            self.version(version.trim_ascii())
        } else if let Some(columns) = comment.strip_prefix("$COLUMNS=") {
            self.columns = named_columns(columns.trim_ascii())?;
            Ok(())
        } else {
            Ok(())
        }
    }

    fn version(&mut self, version: &str) -> Result<(), LineError> {
        use Column::{Bus, Data, Identifier, Length, Number, Reserved, Time, Type};
        self.is_new = version.starts_with('2');
        self.columns = match version {
            "1.0" => Self::default().columns,
            "1.1" => vec![Number, Time, Type, Identifier, Length, Data],
            "1.2" => vec![Number, Time, Bus, Type, Identifier, Length, Data],
            "1.3" => vec![Number, Time, Bus, Type, Identifier, Reserved, Length, Data],
            "2.0" | "2.1" => Vec::new(),
            other => {
                return Err(LineError::header(
                    "TRC version 1.0, 1.1, 1.2, 1.3, 2.0 or 2.1",
                    other,
                ));
            }
        };
        Ok(())
    }

    /// Takes one column; an event when the line has no columns of a frame behind it, and none for a line that is no event of a bus.
    fn take<'a>(
        &self,
        column: Column,
        words: &mut Words<'a>,
        parts: &mut Parts<'a>,
    ) -> Result<Option<Option<Event>>, LineError> {
        match column {
            Column::Number => self.number(words.next("a number")?)?,
            Column::Time => parts.at_ns = Some(time_ns(words.next(TIME)?, NS_PER_MS)?),
            Column::Bus => parts.bus = Some(bus(words.next("a bus")?)?),
            Column::Type => {
                let kind = words.next("a type of message")?;
                parts.kind = Some(kind);
                let event = event_of(kind)?;
                let has_bus = self
                    .columns
                    .iter()
                    .skip_while(|c| **c != Column::Type)
                    .nth(1);
                if event.is_some() && has_bus == Some(&Column::Bus) {
                    parts.bus = Some(bus(words.next("a bus")?)?);
                }
                return Ok(event);
            }
            Column::Identifier => {
                let id = words.next("an identifier")?;
                if id == STATE_ID {
                    return Ok(Some(Some(Event::ControllerState)));
                }
                parts.id = Some(id);
            }
            Column::Direction => {
                let direction = words.next("Rx or Tx")?;
                if !matches!(direction, "Rx" | "Tx") {
                    return Err(LineError::field("Rx or Tx", direction));
                }
            }
            Column::Reserved => {
                words.next("the reserved column")?;
            }
            Column::Length => parts.length = Some(words.next("a data length")?),
            Column::Data => {}
        }
        Ok(None)
    }

    /// `1)` in the old versions, `1` in the new ones.
    fn number(&self, text: &str) -> Result<(), LineError> {
        let digits = if self.is_new {
            Some(text)
        } else {
            text.strip_suffix(')')
        };
        let is_number = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
        if digits.is_some_and(is_number) {
            return Ok(());
        }
        let expected = if self.is_new {
            "a number"
        } else {
            "a number such as 1)"
        };
        Err(LineError::field(expected, text))
    }

    fn frame(&self, parts: &Parts<'_>, mut words: Words<'_>) -> Result<Event, LineError> {
        let id = parts.id.ok_or(LineError::Missing {
            expected: "an identifier",
        })?;
        let (id, extended) = (hex_id(id)?, id.len() > STANDARD_DIGITS);
        let len = parts.length.ok_or(LineError::Missing {
            expected: "a data length",
        })?;
        let len = classic_length(len, 10)?;
        match words.peek() {
            Some("RTR") => return remote_frame(id, extended, len).map(Event::Frame),
            Some("ERROR") => return Ok(Event::ErrorFrame),
            _ => {}
        }
        if parts.kind == Some("RR") {
            return remote_frame(id, extended, len).map(Event::Frame);
        }
        data_frame(id, extended, words.data(len, 16)?.as_slice()).map(Event::Frame)
    }
}

/// The columns of a line such as `N,O,T,B,I,d,R,L,D`.
fn named_columns(text: &str) -> Result<Vec<Column>, LineError> {
    let expected = "the columns O, T, I, l or L, and D at the end, among N, B, d and R, each once";
    let bad = || LineError::header(expected, text);
    let columns: Option<Vec<Column>> = text.split(',').map(Column::of_letter).collect();
    let columns = columns.ok_or_else(bad)?;
    let is_single = |column: &Column| columns.iter().filter(|other| *other == column).count() == 1;
    use Column::{Data, Identifier, Length, Time, Type};
    let needed = [Time, Type, Identifier, Length, Data];
    let is_complete = needed.iter().all(|column| columns.contains(column));
    if !is_complete || !columns.iter().all(is_single) || columns.last() != Some(&Data) {
        return Err(bad());
    }
    Ok(columns)
}

/// What a type of message is: nothing for the frames that are read on, no event for what is not on the bus.
fn event_of(kind: &str) -> Result<Option<Option<Event>>, LineError> {
    Ok(match kind {
        "DT" | "RR" | "Rx" | "Tx" => None,
        "FD" | "FB" | "FE" | "BI" => Some(Some(Event::FdFrame)),
        "ER" | "Error" => Some(Some(Event::ErrorFrame)),
        "ST" | "EC" | "Warng" => Some(Some(Event::ControllerState)),
        // An event of the user.
        "EV" => Some(None),
        other => {
            return Err(LineError::field(
                "a type of message such as DT or Rx",
                other,
            ));
        }
    })
}
