//! SavvyCAN's own CSV (GVRET): `Time Stamp,ID,Extended,Dir,Bus,LEN,D1,...,D8`, without `Dir` in its first version; times in
//! microseconds, identifiers and data hexadecimal (`framefileio.cpp` of SavvyCAN).

use super::error::LineError;
use super::fields::{Data, IDENTIFIER, TIME, bus, byte, data_frame, hex_id, time_ns};
use super::header::Places;
use super::{Entry, Event};
use crate::frame::MAX_DATA_BYTES;

const NS_PER_US: u64 = 1_000;
const COLUMNS: [&str; 14] = [
    "Time Stamp",
    "ID",
    "Extended",
    "Bus",
    "LEN",
    "D1",
    "D2",
    "D3",
    "D4",
    "D5",
    "D6",
    "D7",
    "D8",
    "Dir",
];
const FIRST_BYTE: usize = 5;
/// The direction is missing in the first version.
const DIRECTION: usize = 13;

/// The columns of one log.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Gvret(Places<14>);

impl Gvret {
    /// Whether a line is the header.
    pub(super) fn of_header(line: &str) -> Option<Self> {
        let places = Places::find(line, COLUMNS);
        places.has_first(DIRECTION).then_some(Self(places))
    }

    pub(super) fn read<'a>(&self, line: &'a str) -> Result<Option<Entry<'a>>, LineError> {
        if Self::of_header(line).is_some() {
            return Ok(None);
        }
        let field = |column, expected| self.0.field(line, column, expected);
        let at_ns = time_ns(field(0, TIME)?, NS_PER_US)?;
        let id = hex_id(digits(field(1, IDENTIFIER)?))?;
        let extended = match field(2, "true or false for a 29-bit identifier")? {
            "true" | "True" | "TRUE" | "1" => true,
            "false" | "False" | "FALSE" | "0" => false,
            other => return Err(LineError::field("true or false", other)),
        };
        let interface = bus(field(3, "a bus")?)?;
        if let Some(direction) = self.0.optional(line, DIRECTION)
            && !matches!(direction, "Rx" | "Tx")
        {
            return Err(LineError::field("Rx or Tx", direction));
        }
        let len = field(4, "a data length")?;
        let len: usize = len
            .parse()
            .map_err(|_| LineError::field("a data length", len))?;
        let event = if len > MAX_DATA_BYTES {
            Event::FdFrame
        } else {
            let mut data = Data::default();
            for index in 0..len {
                let word = digits(field(FIRST_BYTE + index, "a data byte")?);
                data.push(byte(word, 16)?)?;
            }
            // What stands behind the data is nothing or zero.
            for index in len..MAX_DATA_BYTES {
                let rest = self
                    .0
                    .optional(line, FIRST_BYTE + index)
                    .unwrap_or_default();
                if !rest.is_empty() && byte(digits(rest), 16)? != 0 {
                    return Err(LineError::DataLength {
                        expected: len,
                        actual: index + 1,
                    });
                }
            }
            Event::Frame(data_frame(id, extended, data.as_slice())?)
        };
        Ok(Some(Entry {
            at_ns: Some(at_ns),
            interface,
            event,
        }))
    }
}

/// Other writers of the format put `0x` in front.
fn digits(text: &str) -> &str {
    text.strip_prefix("0x").unwrap_or(text)
}
