//! One row of the object dictionary.

use crate::error::WriteError;
use crate::node::NodeId;
use crate::object::{DataType, ObjectAddress, ObjectData};
use crate::sdo::SdoRequest;

/// What may be done with an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Access {
    /// RO: read.
    Ro,
    /// RW: read and written, kept until the drive restarts.
    Rw,
    /// RW/S: as RW, and each write goes to the EEPROM unless 2010h is 1 (Z32).
    RwS,
}

impl Access {
    /// A master may write it.
    #[must_use]
    pub const fn is_writable(self) -> bool {
        !matches!(self, Self::Ro)
    }

    /// It has a place in the EEPROM.
    #[must_use]
    pub const fn is_stored(self) -> bool {
        matches!(self, Self::RwS)
    }
}

/// What the guide prints as default.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Default {
    /// A number.
    Value(i64),
    /// An identifier to which the node number is added.
    CanId(u16),
    /// Nothing.
    Unstated,
}

impl Default {
    /// The number that a drive with this node number starts with; `None` where the guide prints nothing.
    #[must_use]
    pub const fn of(self, node: NodeId) -> Option<i64> {
        match self {
            Self::Value(value) => Some(value),
            Self::CanId(base) => Some(base as i64 + node.get() as i64),
            Self::Unstated => None,
        }
    }
}

/// An object as the guide's dictionary describes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Entry {
    /// Index and sub-index.
    pub address: ObjectAddress,
    /// What it is, in few words.
    pub name: &'static str,
    /// Type; temperatures are signed (Z7).
    pub data_type: DataType,
    /// Access; mapping counts are writable (Z18).
    pub access: Access,
    /// It may be mapped into a PDO.
    pub mappable: bool,
    /// Default.
    pub default: Default,
    /// Smallest and largest value; that of the type where the guide prints none.
    pub min: i64,
    /// Largest value.
    pub max: i64,
    /// Unit, empty for none.
    pub unit: &'static str,
    /// Number of the entry in `docs/errata.md` when something about it is unclear.
    pub doubt: Option<u8>,
}

impl Entry {
    /// The request that reads it.
    #[must_use]
    pub const fn read(&self) -> SdoRequest {
        SdoRequest::Read(self.address)
    }

    /// The request that writes it, in its width.
    ///
    /// # Errors
    /// [`WriteError::ReadOnly`] and [`WriteError::Range`].
    pub const fn write(&self, value: i64) -> Result<SdoRequest, WriteError> {
        let address = self.address;
        if !self.access.is_writable() {
            return Err(WriteError::ReadOnly { address });
        }
        match self.check(value) {
            Ok(data) => Ok(SdoRequest::Write(address, data)),
            Err(error) => Err(error),
        }
    }

    /// A value within the range, in the width of the object.
    ///
    /// # Errors
    /// [`WriteError::Range`].
    pub const fn check(&self, value: i64) -> Result<ObjectData, WriteError> {
        match self.data_type.data(value) {
            Some(data) if value >= self.min && value <= self.max => Ok(data),
            _ => Err(WriteError::Range {
                address: self.address,
                data_type: self.data_type,
                min: self.min,
                max: self.max,
                actual: value,
            }),
        }
    }
}

/// Makes the rows of one group. One line a row, which rustfmt leaves alone.
macro_rules! entries {
    ($($index:literal, $sub:literal, $name:literal, $type:ident, $access:ident, $mappable:literal, $default:expr, $range:expr, $unit:literal, $doubt:expr;)*) => {
        pub(super) const ENTRIES: &[Entry] = &[$(
            Entry::row($index, $sub, $name, $type, $access, $mappable, $default, $range, $unit, $doubt),
        )*];
    };
}
pub(super) use entries;

impl Entry {
    #[expect(clippy::too_many_arguments, reason = "the columns of the table")]
    pub(super) const fn row(
        index: u16,
        sub: u8,
        name: &'static str,
        data_type: DataType,
        access: Access,
        mappable: bool,
        default: Default,
        range: Option<(i64, i64)>,
        unit: &'static str,
        doubt: Option<u8>,
    ) -> Self {
        let (min, max) = match range {
            Some(range) => range,
            None => (data_type.min(), data_type.max()),
        };
        Self {
            address: ObjectAddress::new(index, sub),
            name,
            data_type,
            access,
            mappable,
            default,
            min,
            max,
            unit,
            doubt,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENTRY: Entry = Entry::row(
        0x2000,
        1,
        "an object",
        DataType::I16,
        Access::RwS,
        false,
        Default::CanId(0x180),
        Some((-5, 9)),
        "",
        None,
    );

    #[test]
    fn what_is_written_and_stored_follows_the_access() {
        let kinds = [Access::Ro, Access::Rw, Access::RwS];
        assert_eq!(kinds.map(Access::is_writable), [false, true, true]);
        assert_eq!(kinds.map(Access::is_stored), [false, false, true]);
        let read_only = Entry {
            access: Access::Ro,
            ..ENTRY
        };
        let refused = WriteError::ReadOnly {
            address: ENTRY.address,
        };
        assert_eq!(read_only.write(1), Err(refused));
    }

    #[test]
    fn the_node_is_added_to_an_identifier_alone() {
        let node = NodeId::new(7).unwrap();
        assert_eq!(Default::CanId(0x180).of(node), Some(0x187));
        assert_eq!(Default::Value(3).of(node), Some(3));
        assert_eq!(Default::Unstated.of(node), None);
    }

    #[test]
    fn a_value_is_refused_beyond_either_end_of_its_range() {
        for value in [-5, 0, 9] {
            let data = DataType::I16.data(value).unwrap();
            assert_eq!(ENTRY.check(value), Ok(data));
            assert_eq!(
                ENTRY.write(value),
                Ok(SdoRequest::Write(ENTRY.address, data))
            );
        }
        for actual in [-6, 10, 40_000] {
            let refused = WriteError::Range {
                address: ENTRY.address,
                data_type: DataType::I16,
                min: -5,
                max: 9,
                actual,
            };
            assert_eq!(ENTRY.check(actual), Err(refused));
        }
    }
}
