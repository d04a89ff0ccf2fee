//! What a board or a port says, as exceptions.

use core::fmt::Display;

use board_link::host::RequestError;
use board_link::{Refused, Unit};
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

use crate::errors::raise;

const UNITS: f64 = trajectory::Position::UNITS as f64;
const TICKS: f64 = (1_u64 << 32) as f64;

pub(super) fn not_connected(py: Python<'_>, text: impl Display) -> PyErr {
    static TYPE: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    raise(py, &TYPE, "NotConnected", (text.to_string(),))
}

pub(super) fn connection_lost(py: Python<'_>, text: impl Display) -> PyErr {
    static TYPE: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    raise(py, &TYPE, "ConnectionLost", (text.to_string(),))
}

pub(super) fn no_reply(py: Python<'_>, text: impl Display) -> PyErr {
    static TYPE: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    raise(py, &TYPE, "NoReply", (text.to_string(),))
}

pub(super) fn request_failed(py: Python<'_>, error: &RequestError) -> PyErr {
    match error {
        RequestError::Refused(why) => refused(py, why, None),
        RequestError::TimedOut { .. } => no_reply(py, error),
        _ => connection_lost(py, error),
    }
}

/// A refusal with its values in units; `index` is the set-point.
pub(super) fn refused(py: Python<'_>, why: &Refused, index: Option<u32>) -> PyErr {
    static TYPE: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    let reason = why.reason();
    let (scale, unit) = match reason.map_or(Unit::Number, board_link::Reason::unit) {
        Unit::Nothing | Unit::Number | Unit::State | Unit::Fault => (1.0, ""),
        Unit::Position => (UNITS, "counts"),
        Unit::Velocity => (UNITS, "counts per cycle"),
        Unit::Acceleration => (UNITS, "counts per cycle^2"),
        Unit::Jerk => (UNITS, "counts per cycle^3"),
        Unit::Time => (TICKS, "cycles"),
    };
    let text = why.to_string();
    let advice = text
        .rsplit_once("; ")
        .map_or("", |parts| parts.1)
        .to_owned();
    let name = reason.map(|reason| format!("{reason:?}"));
    let (expected, actual) = (why.expected as f64 / scale, why.actual as f64 / scale);
    let arguments = (
        text, why.number, name, why.axis, expected, actual, unit, advice, index,
    );
    raise(py, &TYPE, "Refused", arguments)
}
