//! How the documents are read, from the names that Python uses.

use dyn_can::{ByteOrder, Dialect, Group3ReplyOrder, Revision, Rotation, SetOriginData};
use dyn_can::{TorqueFullScale, ZeroAddress};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::codec_error;

/// The preset of the revision, with what was changed; `None` changes nothing.
pub(super) fn dialect_of(given: &Bound<'_, PyDict>) -> PyResult<Dialect> {
    let choice = Choice { given };
    let revision = choice.of(
        "revision",
        &[("1.6A", Revision::V1_6A), ("1.2A", Revision::V1_2A)],
    )?;
    let mut dialect = Dialect::of(revision.unwrap_or(Revision::V1_6A));
    let orders = [("msb", ByteOrder::MsbFirst), ("lsb", ByteOrder::LsbFirst)];
    let reply_orders = [
        ("msb", Group3ReplyOrder::Fixed(ByteOrder::MsbFirst)),
        ("lsb", Group3ReplyOrder::Fixed(ByteOrder::LsbFirst)),
        ("recognise", Group3ReplyOrder::Recognise),
    ];
    choice.set("number_order", &orders, &mut dialect.number_order)?;
    choice.set(
        "group3_request_order",
        &orders,
        &mut dialect.group3_request_order,
    )?;
    choice.set(
        "group3_reply_order_1_2a",
        &reply_orders,
        &mut dialect.group3_reply_order_1_2a,
    )?;
    choice.set(
        "group3_reply_order_1_6a",
        &reply_orders,
        &mut dialect.group3_reply_order_1_6a,
    )?;
    let scales = [
        ("700", TorqueFullScale::Raw700),
        ("981", TorqueFullScale::Raw981),
    ];
    choice.set("torque_full_scale", &scales, &mut dialect.torque_full_scale)?;
    let rotations = [
        ("clockwise", Rotation::Clockwise),
        ("counter-clockwise", Rotation::CounterClockwise),
    ];
    choice.set("positive_torque", &rotations, &mut dialect.positive_torque)?;
    let zero = [
        ("sync-trigger", ZeroAddress::SyncTrigger),
        ("disable", ZeroAddress::Disable),
        ("disable-and-speed-zero", ZeroAddress::DisableAndSpeedZero),
        ("lone-fresh-drive", ZeroAddress::LoneFreshDrive),
    ];
    choice.set("zero_address", &zero, &mut dialect.zero_address)?;
    choice.bytes_and_switches(&mut dialect)?;
    Ok(dialect)
}

/// -1 stands for no data byte.
struct OriginByte(SetOriginData);

impl<'py> FromPyObject<'_, 'py> for OriginByte {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let number: i16 = value.extract()?;
        Ok(Self(if number == -1 {
            SetOriginData::Empty
        } else {
            SetOriginData::Magic(u8::try_from(number)?)
        }))
    }
}

struct Choice<'a, 'py> {
    given: &'a Bound<'py, PyDict>,
}

impl Choice<'_, '_> {
    fn get<T>(&self, name: &str, expected: &str) -> PyResult<Option<T>>
    where
        T: for<'b, 'c> FromPyObject<'b, 'c, Error = PyErr>,
    {
        let Some(value) = self.given.get_item(name)?.filter(|value| !value.is_none()) else {
            return Ok(None);
        };
        value.extract().map(Some).map_err(|_| {
            let text = format_args!("dialect: {name}: expected {expected}, got {value}");
            codec_error(self.given.py(), text)
        })
    }

    fn of<T: Copy>(&self, name: &str, choices: &[(&str, T)]) -> PyResult<Option<T>> {
        let Some(value) = self.given.get_item(name)?.filter(|value| !value.is_none()) else {
            return Ok(None);
        };
        let text = value.str()?.to_string();
        let found = choices.iter().find(|choice| choice.0 == text);
        found.map(|choice| Some(choice.1)).ok_or_else(|| {
            let names: Vec<&str> = choices.iter().map(|choice| choice.0).collect();
            let expected = names.join(", ");
            codec_error(
                self.given.py(),
                format_args!("dialect: {name}: expected one of {expected}, got {text}"),
            )
        })
    }

    fn set<T: Copy>(&self, name: &str, choices: &[(&str, T)], place: &mut T) -> PyResult<()> {
        if let Some(value) = self.of(name, choices)? {
            *place = value;
        }
        Ok(())
    }

    fn bytes_and_switches(&self, dialect: &mut Dialect) -> PyResult<()> {
        if let Some(OriginByte(data)) = self.get("set_origin", "0 to 255, or -1 for no byte")? {
            dialect.set_origin = data;
        }
        if let Some(byte) = self.get::<u8>("read_dummy", "0 to 255")? {
            dialect.read_dummy = Some(byte);
        }
        let switches = [
            ("accept_beyond_28_bit", &mut dialect.accept_beyond_28_bit),
            ("strict_minimal", &mut dialect.strict_minimal),
            ("allow_assign_zero", &mut dialect.allow_assign_zero),
        ];
        for (name, place) in switches {
            if let Some(value) = self.get::<bool>(name, "True or False")? {
                *place = value;
            }
        }
        Ok(())
    }
}
