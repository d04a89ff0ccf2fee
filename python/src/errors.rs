//! The exceptions of the package, which are defined in Python.

use core::fmt::Display;

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;

const MODULE: &str = "motion_board.errors";

/// A message that cannot be encoded or decoded.
pub(crate) fn codec_error(py: Python<'_>, text: impl Display) -> PyErr {
    static TYPE: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    raise(py, &TYPE, "CodecError", (text.to_string(),))
}

/// An argument that makes no sense.
pub(crate) fn input_error(py: Python<'_>, text: impl Display) -> PyErr {
    static TYPE: PyOnceLock<Py<PyType>> = PyOnceLock::new();
    raise(py, &TYPE, "InputError", (text.to_string(),))
}

/// An exception by its name.
pub(crate) fn raise<A>(
    py: Python<'_>,
    cell: &PyOnceLock<Py<PyType>>,
    name: &str,
    arguments: A,
) -> PyErr
where
    A: pyo3::PyErrArguments + Send + Sync + 'static,
{
    match cell.import(py, MODULE, name) {
        Ok(class) => PyErr::from_type(class.clone(), arguments),
        Err(error) => error,
    }
}
