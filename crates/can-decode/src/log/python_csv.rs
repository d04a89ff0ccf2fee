//! python-can's CSV: `timestamp,arbitration_id,extended,remote,error,dlc,data`, the data in base64. The channel is not in it.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::error::LineError;
use super::fields::{IDENTIFIER, TIME, data_frame, hex_id, length, remote_frame, time_ns};
use super::{Entry, Event};
use crate::frame::MAX_DATA_BYTES;

/// How the first line begins.
pub(super) const HEADER: &str = "timestamp,arbitration_id";
const NS_PER_S: u64 = 1_000_000_000;

pub(super) fn read(line: &str) -> Result<Option<Entry<'_>>, LineError> {
    if line.starts_with(HEADER) {
        return Ok(None);
    }
    let mut fields = line.split(',');
    let mut next = |expected| fields.next().ok_or(LineError::Missing { expected });
    let at_ns = time_ns(next(TIME)?, NS_PER_S)?;
    let id = next(IDENTIFIER)?;
    let extended = flag(next("0 or 1 for a 29-bit identifier")?)?;
    let remote = flag(next("0 or 1 for a remote frame")?)?;
    let error = flag(next("0 or 1 for an error frame")?)?;
    let len = next("a data length")?;
    let data = next("data in base64")?;
    let id = hex_id(id.strip_prefix("0x").unwrap_or(id))?;
    let event = if error {
        Event::ErrorFrame
    } else if remote {
        Event::Frame(remote_frame(id, extended, length(len)?)?)
    } else {
        data_event(id, extended, len, data)?
    };
    Ok(Some(Entry {
        at_ns,
        interface: "",
        event,
    }))
}

fn data_event(id: u32, extended: bool, len: &str, data: &str) -> Result<Event, LineError> {
    let bytes = STANDARD
        .decode(data)
        .map_err(|_| LineError::field("data in base64", data))?;
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
    data_frame(id, extended, &bytes).map(Event::Frame)
}

fn flag(text: &str) -> Result<bool, LineError> {
    match text {
        "0" => Ok(false),
        "1" => Ok(true),
        other => Err(LineError::field("0 or 1", other)),
    }
}
