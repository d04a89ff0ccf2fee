//! python-can's CSV: `timestamp,arbitration_id,extended,remote,error,dlc,data`, the data in base64. The channel is not in it.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::error::LineError;
use super::fields::{IDENTIFIER, TIME, data_frame, hex_id, length, remote_frame, time_ns};
use super::header::Places;
use super::{Entry, Event};
use crate::frame::MAX_DATA_BYTES;

const NS_PER_S: u64 = 1_000_000_000;
const COLUMNS: [&str; 8] = [
    "timestamp",
    "arbitration_id",
    "extended",
    "remote",
    "error",
    "dlc",
    "data",
    "channel",
];
/// All but the channel.
const NEEDED: usize = 7;

/// The columns of one log.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct PythonCsv(Places<8>);

impl PythonCsv {
    /// Whether a line is the header.
    pub(super) fn of_header(line: &str) -> Option<Self> {
        let places = Places::find(line, COLUMNS);
        places.has_first(NEEDED).then_some(Self(places))
    }

    pub(super) fn read<'a>(&self, line: &'a str) -> Result<Option<Entry<'a>>, LineError> {
        if Self::of_header(line).is_some() {
            return Ok(None);
        }
        let field = |column, expected| self.0.field(line, column, expected);
        let at_ns = time_ns(field(0, TIME)?, NS_PER_S)?;
        let id = field(1, IDENTIFIER)?;
        let extended = flag(field(2, "0 or 1 for a 29-bit identifier")?)?;
        let remote = flag(field(3, "0 or 1 for a remote frame")?)?;
        let error = flag(field(4, "0 or 1 for an error frame")?)?;
        let len = field(5, "a data length")?;
        let data = field(6, "data in base64")?;
        let id = hex_id(id.strip_prefix("0x").unwrap_or(id))?;
        let bytes = STANDARD
            .decode(data)
            .map_err(|_| LineError::field("data in base64", data))?;
        let event = if error {
            Event::ErrorFrame
        } else if remote {
            if !bytes.is_empty() {
                return Err(LineError::field("no data of a remote frame", data));
            }
            Event::Frame(remote_frame(id, extended, length(len)?)?)
        } else {
            data_event(id, extended, len, &bytes)?
        };
        Ok(Some(Entry {
            at_ns: Some(at_ns),
            interface: self.0.optional(line, NEEDED).unwrap_or_default(),
            event,
        }))
    }
}

fn data_event(id: u32, extended: bool, len: &str, bytes: &[u8]) -> Result<Event, LineError> {
    let expected: usize = len
        .parse()
        .map_err(|_| LineError::field("a data length", len))?;
    if bytes.len() != expected {
        return Err(LineError::DataLength {
            expected,
            actual: bytes.len(),
        });
    }
    // Longer than a classic frame can be: the format does not mark CAN FD otherwise.
    if expected > MAX_DATA_BYTES {
        return Ok(Event::FdFrame);
    }
    data_frame(id, extended, bytes).map(Event::Frame)
}

fn flag(text: &str) -> Result<bool, LineError> {
    match text {
        "0" => Ok(false),
        "1" => Ok(true),
        other => Err(LineError::field("0 or 1", other)),
    }
}
