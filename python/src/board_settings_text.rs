//! The settings of a board: its bytes as text and values, and a text as bytes; and the words of its faults.

use board_settings::{FaultNumber, LONGEST, Settings, file};
use dyn_can::GearNumber;
use dyn_can::units::command_counts_per_turn;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use pythonize::pythonize;

use crate::errors::codec_error;
use crate::values::Octets;

/// Text, values, and counts of a turn of each motor.
type Read<'py> = (String, Bound<'py, PyAny>, Vec<u32>);

/// What settings say.
#[pyfunction]
pub(crate) fn read_settings<'py>(py: Python<'py>, data: Octets) -> PyResult<Read<'py>> {
    let settings = Settings::read(&data).map_err(|refusal| codec_error(py, refusal))?;
    let turns: PyResult<Vec<u32>> = settings
        .axes
        .iter()
        .map(|axis| {
            let gear = GearNumber::new(axis.gear.into()).map_err(|error| codec_error(py, error))?;
            Ok(command_counts_per_turn(gear))
        })
        .collect();
    Ok((file::write(&settings), pythonize(py, &settings)?, turns?))
}

/// The bytes of a text.
#[pyfunction]
pub(crate) fn settings_of_text<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyBytes>> {
    let read = file::read(text).map_err(|error| codec_error(py, error))?;
    let mut room = [0; LONGEST];
    let bytes = read.settings.write(&mut room);
    let bytes = bytes.map_err(|refusal| codec_error(py, refusal))?;
    Ok(PyBytes::new(py, bytes))
}

/// What the number of a fault means.
#[pyfunction]
pub(crate) fn fault_text(code: u16, detail: i32) -> String {
    FaultNumber { code, detail }.to_string()
}
