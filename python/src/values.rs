//! The values of a message by their names: what decoding gives is what encoding takes.

use dyn_can::{Alarm, CommandMode, DriveConfig, DriveStatus, RangeError, ServoMode};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyMemoryView, PyString, PyTuple};

use crate::errors::codec_error;

/// Anything that holds bytes: `bytes`, `bytearray`, `memoryview`, an array of bytes.
pub(crate) struct Octets(Vec<u8>);

impl core::ops::Deref for Octets {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.0
    }
}

impl<'py> FromPyObject<'_, 'py> for Octets {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(bytes) = value.cast::<PyBytes>() {
            return Ok(Self(bytes.as_bytes().to_vec()));
        }
        let view = PyMemoryView::from(&value)?;
        let width: usize = view.getattr("itemsize")?.extract()?;
        if width != 1 {
            let text = format!("expected bytes, got numbers of {width} bytes");
            return Err(PyTypeError::new_err(text));
        }
        let bytes = view.call_method0("tobytes")?;
        Ok(Self(bytes.cast::<PyBytes>()?.as_bytes().to_vec()))
    }
}

/// What a caller gave for a message.
pub(crate) struct Values<'a, 'py> {
    function: &'static str,
    given: &'a Bound<'py, PyDict>,
}

impl<'a, 'py> Values<'a, 'py> {
    pub(crate) const fn new(function: &'static str, given: &'a Bound<'py, PyDict>) -> Self {
        Self { function, given }
    }

    pub(crate) fn py(&self) -> Python<'py> {
        self.given.py()
    }

    /// A value that may be left out or be `None`.
    pub(crate) fn get<T>(&self, name: &str) -> PyResult<Option<T>>
    where
        T: for<'b> FromPyObject<'b, 'py, Error = PyErr>,
    {
        let Some(value) = self.given.get_item(name)?.filter(|value| !value.is_none()) else {
            return Ok(None);
        };
        let function = self.function;
        value.extract().map(Some).map_err(|error: PyErr| {
            let text = error.value(self.py()).to_string();
            codec_error(
                self.py(),
                format_args!("{function}: {name}: {text}, got {value}"),
            )
        })
    }

    /// A value that must be there.
    pub(crate) fn need<T>(&self, name: &str) -> PyResult<T>
    where
        T: for<'b> FromPyObject<'b, 'py, Error = PyErr>,
    {
        self.get(name)?.ok_or_else(|| {
            let function = self.function;
            codec_error(self.py(), format_args!("{function} needs the value {name}"))
        })
    }

    /// A number within its range.
    pub(crate) fn number<T>(
        &self,
        name: &str,
        check: impl FnOnce(i32) -> Result<T, RangeError>,
    ) -> PyResult<T> {
        check(self.need(name)?).map_err(|error| self.beyond(name, error))
    }

    /// The same, which may be left out or be `None`.
    pub(crate) fn optional<T>(
        &self,
        name: &str,
        check: impl FnOnce(i32) -> Result<T, RangeError>,
    ) -> PyResult<Option<T>> {
        let number = self.get(name)?;
        number
            .map(|number| check(number).map_err(|error| self.beyond(name, error)))
            .transpose()
    }

    fn beyond(&self, name: &str, error: RangeError) -> PyErr {
        let function = self.function;
        codec_error(self.py(), format_args!("{function}: {name}: {error}"))
    }

    /// Everything that was given must be in the message that was made of it.
    pub(crate) fn confirm(&self, carried: &Bound<'py, PyDict>) -> PyResult<()> {
        let function = self.function;
        for (name, given) in self.given.iter() {
            let Some(carried_value) = carried.get_item(&name)? else {
                let known = carried.keys();
                return Err(codec_error(
                    self.py(),
                    format_args!("{function} has no value {name}: expected {known}"),
                ));
            };
            if !as_tuple(given.clone())?.eq(as_tuple(carried_value.clone())?)? {
                return Err(codec_error(
                    self.py(),
                    format_args!(
                        "{function}: {name}: got {given}, with the other values the message carries {carried_value}"
                    ),
                ));
            }
        }
        Ok(())
    }
}

/// Bytes, lists and arrays are the same sequence.
fn as_tuple(value: Bound<'_, PyAny>) -> PyResult<Bound<'_, PyAny>> {
    if value.is_instance_of::<PyString>() || value.try_iter().is_err() {
        return Ok(value);
    }
    value.py().get_type::<PyTuple>().call1((value,))
}

/// The configuration: its byte, or what the byte says.
pub(crate) fn drive_config(values: &Values<'_, '_>) -> PyResult<DriveConfig> {
    if let Some(byte) = values.get::<u8>("config")? {
        return DriveConfig::from_byte(byte).map_err(|error| values.beyond("config", error));
    }
    Ok(DriveConfig {
        command_mode: values.number("command_mode", CommandMode::new)?,
        absolute_mode: values.need("absolute_mode")?,
        servo_mode: values.number("servo_mode", ServoMode::new)?,
        servo_free: values.need("servo_free")?,
    })
}

/// The status by its bits.
pub(crate) fn drive_status(values: &Values<'_, '_>) -> PyResult<DriveStatus> {
    Ok(DriveStatus::new(
        values.need("on_position")?,
        values.need("disabled")?,
        Alarm::from_code(values.need("alarm_code")?),
        values.need("motion_busy")?,
    ))
}
