//! Requests and replies of DYN drives on CAN.

mod dialect;
mod reply;
mod request;

use can_decode::dyn_drives::{Content, Message};
use dyn_can::{Address, DataFrame, DriveId, FunctionCode, Reply, ReplyKind, Request};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use pythonize::pythonize;

use crate::errors::codec_error;
use crate::values::{Octets, Values};
use dialect::dialect_of;

/// What surrounds the values in a decoded message.
const SURROUNDINGS: [&str; 3] = ["drive", "direction", "function"];

/// The frame of a request: identifier and data.
#[pyfunction]
pub(crate) fn dyn_can_encode_request<'py>(
    py: Python<'py>,
    function: &str,
    drive: Option<i32>,
    values: &Bound<'py, PyDict>,
    dialect: &Bound<'py, PyDict>,
) -> PyResult<(u16, Bound<'py, PyBytes>)> {
    let (dialect, address) = (dialect_of(dialect)?, address_of(py, drive)?);
    let values = Values::new(function_of(py, function)?.name(), values);
    let request = request::of(function_of(py, function)?, &values)?;
    values.confirm(&carried(py, address, Content::Request(request))?)?;
    let frame = request
        .encode(address, &dialect)
        .map_err(|error| codec_error(py, error))?;
    Ok(parts(py, &frame))
}

/// The frame of a reply: identifier and data.
#[pyfunction]
pub(crate) fn dyn_can_encode_reply<'py>(
    py: Python<'py>,
    function: &str,
    drive: Option<i32>,
    values: &Bound<'py, PyDict>,
    dialect: &Bound<'py, PyDict>,
) -> PyResult<(u16, Bound<'py, PyBytes>)> {
    let (dialect, address) = (dialect_of(dialect)?, address_of(py, drive)?);
    let function = function_of(py, function)?;
    let values = Values::new(function.name(), values);
    function
        .admit_reply(dialect.revision)
        .map_err(|error| codec_error(py, error))?;
    let reply = reply::of(function, &values, &dialect)?;
    let content = Content::Reply {
        reply,
        response_ns: None,
    };
    values.confirm(&carried(py, address, content)?)?;
    Ok(parts(py, &reply.encode(address, &dialect)))
}

/// A frame as a request: function, drive and values.
#[pyfunction]
pub(crate) fn dyn_can_decode_request<'py>(
    py: Python<'py>,
    id: u16,
    data: Octets,
    dialect: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let (frame, dialect) = (frame_of(py, id, &data)?, dialect_of(dialect)?);
    let (address, request) =
        Request::decode(&frame, &dialect).map_err(|error| codec_error(py, error))?;
    message(py, address, Content::Request(request))
}

/// A frame as the reply to what was asked, or to anything that does not depend on it.
#[pyfunction]
pub(crate) fn dyn_can_decode_reply<'py>(
    py: Python<'py>,
    id: u16,
    data: Octets,
    asked: Option<&str>,
    dialect: &Bound<'py, PyDict>,
) -> PyResult<Bound<'py, PyAny>> {
    let (frame, dialect) = (frame_of(py, id, &data)?, dialect_of(dialect)?);
    let outstanding = match asked {
        None => None,
        Some("position") => Some(ReplyKind::Position),
        Some("torque") => Some(ReplyKind::Torque),
        Some(name) => {
            let function = function_of(py, name)?;
            Some(kind_of(py, function)?)
        }
    };
    let (address, reply) =
        Reply::decode(&frame, outstanding, &dialect).map_err(|error| codec_error(py, error))?;
    let content = Content::Reply {
        reply,
        response_ns: None,
    };
    message(py, address, content)
}

/// The kind of the reply to a function of which there is one alone.
fn kind_of(py: Python<'_>, function: FunctionCode) -> PyResult<ReplyKind> {
    let kinds = [
        ReplyKind::DriveId,
        ReplyKind::DriveConfig,
        ReplyKind::DriveStatus,
        ReplyKind::ParamGroup1,
        ReplyKind::ParamGroup2,
        ReplyKind::ParamGroup3,
        ReplyKind::MotorSpeed,
        ReplyKind::DriveReset,
        ReplyKind::Echo,
        ReplyKind::DiagnosticCounter,
    ];
    let found = kinds.into_iter().find(|kind| kind.function() == function);
    found.ok_or_else(|| {
        let hint = match function {
            FunctionCode::GeneralRead => "asked: General_Read is asked for position or torque",
            _ => "asked: the function has no reply",
        };
        codec_error(py, hint)
    })
}

fn message(py: Python<'_>, address: Address, content: Content) -> PyResult<Bound<'_, PyAny>> {
    let function = match &content {
        Content::Request(request) => request.function(),
        Content::Reply { reply, .. } => reply.function(),
        // Nothing here makes another content.
        _ => FunctionCode::GeneralRead,
    };
    let message = Message {
        address,
        function,
        content,
        note: None,
    };
    Ok(pythonize(py, &message)?)
}

/// The values alone.
fn carried(py: Python<'_>, address: Address, content: Content) -> PyResult<Bound<'_, PyDict>> {
    let values = message(py, address, content)?.cast_into::<PyDict>()?;
    for name in SURROUNDINGS {
        values.del_item(name)?;
    }
    Ok(values)
}

fn function_of(py: Python<'_>, name: &str) -> PyResult<FunctionCode> {
    let found = FunctionCode::ALL
        .into_iter()
        .find(|function| function.name() == name);
    found.ok_or_else(|| {
        let names: Vec<&str> = FunctionCode::ALL
            .iter()
            .map(|function| function.name())
            .collect();
        let known = names.join(", ");
        codec_error(
            py,
            format_args!("no function is called {name}: expected one of {known}"),
        )
    })
}

/// No drive is every drive.
fn address_of(py: Python<'_>, drive: Option<i32>) -> PyResult<Address> {
    let Some(drive) = drive else {
        return Ok(Address::Broadcast);
    };
    let drive = DriveId::new(drive).map_err(|error| codec_error(py, error))?;
    Ok(Address::Drive(drive))
}

fn frame_of(py: Python<'_>, id: u16, data: &[u8]) -> PyResult<DataFrame> {
    DataFrame::new(id, data).map_err(|error| codec_error(py, error))
}

fn parts<'py>(py: Python<'py>, frame: &DataFrame) -> (u16, Bound<'py, PyBytes>) {
    (frame.id(), PyBytes::new(py, frame.data()))
}
