//! Frames for ZLAC8030L drives on CANopen; what frames say comes from the decoder of logs.

use pyo3::prelude::*;
use pyo3::types::PyBytes;
use zlac8030l::{
    AbortCode, DataFrame, Heartbeat, MappingEntry, NmtCommand, NmtRequest, NmtState, NodeId,
    ObjectAddress, ObjectData, PdoMapping, PdoNumber, SdoReply, SdoRequest, Sync,
};

use crate::errors::codec_error;
use crate::values::Octets;

type Parts<'py> = (u16, Bound<'py, PyBytes>);

/// A command of the network management; no node is every node.
#[pyfunction]
pub(crate) fn canopen_nmt<'py>(
    py: Python<'py>,
    command: &str,
    node: Option<i32>,
) -> PyResult<Parts<'py>> {
    let command = match command {
        "start" => NmtCommand::Start,
        "stop" => NmtCommand::Stop,
        "pre-operational" => NmtCommand::PreOperational,
        "reset-node" => NmtCommand::ResetNode,
        "reset-communication" => NmtCommand::ResetCommunication,
        other => {
            let expected = "start, stop, pre-operational, reset-node or reset-communication";
            return Err(codec_error(
                py,
                format_args!("NMT command: expected {expected}, got {other}"),
            ));
        }
    };
    let node = node.map(|node| node_of(py, node)).transpose()?;
    Ok(parts(py, &NmtRequest { command, node }.encode()))
}

/// SYNC.
#[pyfunction]
pub(crate) fn canopen_sync(py: Python<'_>) -> Parts<'_> {
    parts(py, &Sync.encode())
}

/// The heartbeat of a node.
#[pyfunction]
pub(crate) fn canopen_heartbeat<'py>(
    py: Python<'py>,
    node: i32,
    state: &str,
) -> PyResult<Parts<'py>> {
    let state = match state {
        "boot-up" => NmtState::BootUp,
        "stopped" => NmtState::Stopped,
        "operational" => NmtState::Operational,
        "pre-operational" => NmtState::PreOperational,
        other => {
            let expected = "boot-up, stopped, operational or pre-operational";
            return Err(codec_error(
                py,
                format_args!("NMT state: expected {expected}, got {other}"),
            ));
        }
    };
    let node = node_of(py, node)?;
    Ok(parts(py, &Heartbeat { node, state }.encode()))
}

/// Read an object.
#[pyfunction]
pub(crate) fn canopen_sdo_read(
    py: Python<'_>,
    node: i32,
    index: u16,
    sub: u8,
) -> PyResult<Parts<'_>> {
    let request = SdoRequest::Read(ObjectAddress::new(index, sub));
    Ok(parts(py, &request.encode(node_of(py, node)?)))
}

/// Write an object.
#[pyfunction]
pub(crate) fn canopen_sdo_write<'py>(
    py: Python<'py>,
    node: i32,
    index: u16,
    sub: u8,
    data: Octets,
) -> PyResult<Parts<'py>> {
    let request = SdoRequest::Write(ObjectAddress::new(index, sub), data_of(py, &data)?);
    Ok(parts(py, &request.encode(node_of(py, node)?)))
}

/// The reply to a read.
#[pyfunction]
pub(crate) fn canopen_sdo_value<'py>(
    py: Python<'py>,
    node: i32,
    index: u16,
    sub: u8,
    data: Octets,
) -> PyResult<Parts<'py>> {
    let reply = SdoReply::Value(ObjectAddress::new(index, sub), data_of(py, &data)?);
    Ok(parts(py, &reply.encode(node_of(py, node)?)))
}

/// The reply to a write.
#[pyfunction]
pub(crate) fn canopen_sdo_written(
    py: Python<'_>,
    node: i32,
    index: u16,
    sub: u8,
) -> PyResult<Parts<'_>> {
    let reply = SdoReply::Written(ObjectAddress::new(index, sub));
    Ok(parts(py, &reply.encode(node_of(py, node)?)))
}

/// The reply of a drive that refuses.
#[pyfunction]
pub(crate) fn canopen_sdo_abort(
    py: Python<'_>,
    node: i32,
    index: u16,
    sub: u8,
    code: u32,
) -> PyResult<Parts<'_>> {
    let reply = SdoReply::Abort(ObjectAddress::new(index, sub), AbortCode::new(code));
    Ok(parts(py, &reply.encode(node_of(py, node)?)))
}

/// Process data: each value is index, sub-index and its bytes.
#[pyfunction]
pub(crate) fn canopen_pdo(
    py: Python<'_>,
    to_drive: bool,
    node: i32,
    number: u8,
    values: Vec<(u16, u8, Vec<u8>)>,
) -> PyResult<Parts<'_>> {
    let node = node_of(py, node)?;
    let numbers = PdoNumber::ALL.into_iter();
    let number = numbers
        .enumerate()
        .find(|(place, _)| *place == usize::from(number));
    let Some((_, number)) = number else {
        return Err(codec_error(py, "PDO number: expected 0 to 3"));
    };
    let mut entries = Vec::new();
    let mut data = Vec::new();
    for (index, sub, bytes) in &values {
        data.push(data_of(py, bytes)?);
        entries.push(MappingEntry {
            address: ObjectAddress::new(*index, *sub),
            bits: 8 * bytes.len() as u8,
        });
    }
    let mapping = PdoMapping::new(&entries).map_err(|error| codec_error(py, error))?;
    let frame = if to_drive {
        mapping.rpdo(node, number, &data)
    } else {
        mapping.tpdo(node, number, &data)
    };
    Ok(parts(py, &frame))
}

fn node_of(py: Python<'_>, node: i32) -> PyResult<NodeId> {
    NodeId::new(node).map_err(|error| codec_error(py, error))
}

fn data_of(py: Python<'_>, bytes: &[u8]) -> PyResult<ObjectData> {
    ObjectData::from_bytes(bytes).ok_or_else(|| {
        let actual = bytes.len();
        codec_error(
            py,
            format_args!("object: expected 1 to 4 bytes, got {actual}"),
        )
    })
}

fn parts<'py>(py: Python<'py>, frame: &DataFrame) -> Parts<'py> {
    (frame.id(), PyBytes::new(py, frame.data()))
}
