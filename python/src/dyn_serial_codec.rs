//! Packets of DYN drives on RS232 (DYN232M).

mod message;
mod request;

use dyn_serial::{
    Address, Decoder, Dialect, DriveId, Dummy, Event, GeneralId, Packet, ParameterForm, Reply,
    ReplyFunction, Request, RequestFunction,
};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::errors::codec_error;
use crate::values::{Octets, Values};

/// How the manual is read, as Python gives it: parameter form, dummy byte, what may go to every drive.
type DialectWords = (String, i32, String);

/// The packet of a request.
#[pyfunction]
pub(crate) fn dyn_serial_encode_request<'py>(
    py: Python<'py>,
    function: &str,
    drive: Option<i32>,
    values: &Bound<'py, PyDict>,
    dialect: DialectWords,
) -> PyResult<Bound<'py, PyBytes>> {
    let dialect = dialect_of(py, &dialect)?;
    let function = named(py, function, RequestFunction::ALL, |one| one.name())?;
    let values = Values::new(function.name(), values);
    let request = request::of(function, &values)?;
    values.confirm(&message::request_values(py, &request)?)?;
    let to = match drive {
        None => Address::All,
        Some(drive) => Address::Drive(drive_of(py, drive)?),
    };
    let packet = request
        .encode(to, &dialect)
        .map_err(|error| codec_error(py, error))?;
    Ok(PyBytes::new(py, packet.as_bytes()))
}

/// The packet of a reply.
#[pyfunction]
pub(crate) fn dyn_serial_encode_reply<'py>(
    py: Python<'py>,
    function: &str,
    drive: i32,
    values: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyBytes>> {
    let function = named(py, function, ReplyFunction::ALL, |one| one.name())?;
    let values = Values::new(function.name(), values);
    let reply = message::reply_of(function, &values)?;
    values.confirm(&message::reply_values(py, &reply)?)?;
    let packet = reply.encode(drive_of(py, drive)?);
    Ok(PyBytes::new(py, packet.as_bytes()))
}

/// A packet as a request: drive, function, values.
#[pyfunction]
pub(crate) fn dyn_serial_decode_request<'py>(
    py: Python<'py>,
    packet: Octets,
    dialect: DialectWords,
) -> PyResult<(Option<u8>, &'static str, Bound<'py, PyDict>)> {
    let (packet, dialect) = (packet_of(py, &packet)?, dialect_of(py, &dialect)?);
    let (to, request) =
        Request::decode(&packet, &dialect).map_err(|error| codec_error(py, error))?;
    let drive = match to {
        Address::Drive(drive) => Some(drive.get()),
        Address::All => None,
    };
    let values = message::request_values(py, &request)?;
    Ok((drive, request.function().name(), values))
}

/// A packet as a reply: drive, function, values.
#[pyfunction]
pub(crate) fn dyn_serial_decode_reply<'py>(
    py: Python<'py>,
    packet: Octets,
) -> PyResult<(Option<u8>, &'static str, Bound<'py, PyDict>)> {
    let packet = packet_of(py, &packet)?;
    let (from, reply) = Reply::decode(&packet).map_err(|error| codec_error(py, error))?;
    let values = message::reply_values(py, &reply)?;
    Ok((Some(from.get()), reply.function().name(), values))
}

/// Finds packets in a stream of bytes.
#[pyclass(module = "motion_board._native")]
pub(crate) struct SerialDecoder {
    decoder: Decoder,
}

#[pymethods]
impl SerialDecoder {
    #[new]
    fn new() -> Self {
        Self {
            decoder: Decoder::new(),
        }
    }

    /// What the bytes make: its kind, and its bytes.
    fn push<'py>(
        &mut self,
        py: Python<'py>,
        bytes: Octets,
    ) -> Vec<(&'static str, Bound<'py, PyBytes>)> {
        let events = bytes.iter().filter_map(|byte| self.decoder.push(*byte));
        events
            .map(|event| match event {
                Event::Packet(packet) => ("packet", PyBytes::new(py, packet.as_bytes())),
                Event::Stray(byte) => ("stray", PyBytes::new(py, &[byte])),
                Event::Truncated(part) => ("truncated", PyBytes::new(py, part.as_bytes())),
                Event::Checksum { received, .. } => {
                    ("checksum", PyBytes::new(py, received.as_bytes()))
                }
            })
            .collect()
    }
}

fn packet_of(py: Python<'_>, bytes: &[u8]) -> PyResult<Packet> {
    Packet::parse(bytes).map_err(|error| codec_error(py, error))
}

fn drive_of(py: Python<'_>, drive: i32) -> PyResult<DriveId> {
    DriveId::new(drive).map_err(|error| codec_error(py, error))
}

fn named<T: Copy>(
    py: Python<'_>,
    name: &str,
    all: &[T],
    name_of: fn(&T) -> &'static str,
) -> PyResult<T> {
    let found = all.iter().find(|one| name_of(one) == name);
    found.copied().ok_or_else(|| {
        let names: Vec<&str> = all.iter().map(name_of).collect();
        let known = names.join(", ");
        codec_error(
            py,
            format_args!("no function is called {name}: expected one of {known}"),
        )
    })
}

fn dialect_of(py: Python<'_>, (form, dummy, general): &DialectWords) -> PyResult<Dialect> {
    let unknown = |name: &str, expected: &str, actual: &str| {
        codec_error(
            py,
            format_args!("{name}: expected {expected}, got {actual}"),
        )
    };
    Ok(Dialect {
        parameter_form: match form.as_str() {
            "table" => ParameterForm::Table,
            "shortest-signed" => ParameterForm::ShortestSigned,
            other => return Err(unknown("parameter_form", "table or shortest-signed", other)),
        },
        dummy: Dummy::new(*dummy).map_err(|error| codec_error(py, error))?,
        general_id: match general.as_str() {
            "coordinated-moves" => GeneralId::CoordinatedMoves,
            "stop" => GeneralId::Stop,
            "lone-drive" => GeneralId::LoneDrive,
            other => {
                let expected = "coordinated-moves, stop or lone-drive";
                return Err(unknown("general_id", expected, other));
            }
        },
    })
}
