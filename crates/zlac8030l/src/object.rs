//! What an object of the dictionary is: address, type, and its value in an expedited SDO.

use core::fmt;

/// Index and sub-index of an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ObjectAddress {
    /// Index, such as 0x6040.
    pub index: u16,
    /// Sub-index, 0 for a single value.
    pub sub: u8,
}

impl ObjectAddress {
    /// An address from its parts.
    #[must_use]
    pub const fn new(index: u16, sub: u8) -> Self {
        Self { index, sub }
    }
}

impl fmt::Display for ObjectAddress {
    /// `6081h:00`, as in the guide.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:04X}h:{:02X}", self.index, self.sub)
    }
}

/// Type of an object: the six integers of the guide's dictionary (section 9).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DataType {
    /// Signed 8 bit.
    I8,
    /// Unsigned 8 bit.
    U8,
    /// Signed 16 bit.
    I16,
    /// Unsigned 16 bit.
    U16,
    /// Signed 32 bit.
    I32,
    /// Unsigned 32 bit.
    U32,
}

impl DataType {
    /// Bytes on the wire.
    #[must_use]
    pub const fn bytes(self) -> u8 {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 => 4,
        }
    }

    /// Smallest value.
    #[must_use]
    pub const fn min(self) -> i64 {
        match self {
            Self::I8 => i8::MIN as i64,
            Self::I16 => i16::MIN as i64,
            Self::I32 => i32::MIN as i64,
            Self::U8 | Self::U16 | Self::U32 => 0,
        }
    }

    /// Largest value.
    #[must_use]
    pub const fn max(self) -> i64 {
        match self {
            Self::I8 => i8::MAX as i64,
            Self::U8 => u8::MAX as i64,
            Self::I16 => i16::MAX as i64,
            Self::U16 => u16::MAX as i64,
            Self::I32 => i32::MAX as i64,
            Self::U32 => u32::MAX as i64,
        }
    }

    /// A value of this type in its width; `None` when it does not fit.
    #[must_use]
    pub const fn data(self, value: i64) -> Option<ObjectData> {
        if value < self.min() || value > self.max() {
            return None;
        }
        Some(ObjectData::from_raw(value as u32, self.bytes()))
    }

    /// The value of data of this width.
    ///
    /// # Errors
    /// [`WidthError`] when the data has another width.
    pub const fn value(self, data: ObjectData) -> Result<i64, WidthError> {
        let raw = match data.raw_of_width(self.bytes()) {
            Ok(raw) => raw,
            Err(error) => return Err(error),
        };
        Ok(match self {
            Self::I8 => raw as i8 as i64,
            Self::I16 => raw as i16 as i64,
            Self::I32 => raw as i32 as i64,
            Self::U8 | Self::U16 | Self::U32 => raw as i64,
        })
    }
}

impl fmt::Display for DataType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::I8 => "I8",
            Self::U8 => "U8",
            Self::I16 => "I16",
            Self::U16 => "U16",
            Self::I32 => "I32",
            Self::U32 => "U32",
        })
    }
}

/// The value of one object as it travels: 1 ..= 4 bytes, least significant first.
///
/// A reply to a read may leave the size open; its four bytes are then read in the width of whoever asks, which is the object's own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ObjectData {
    raw: u32,
    len: u8,
    is_open: bool,
}

impl ObjectData {
    /// The lowest `len` bytes of `raw`; `len` is 1 ..= 4.
    pub(crate) const fn from_raw(raw: u32, len: u8) -> Self {
        Self {
            raw: match len {
                1 => raw & 0xFF,
                2 => raw & 0xFFFF,
                3 => raw & 0xFF_FFFF,
                _ => raw,
            },
            len,
            is_open: false,
        }
    }

    /// Four bytes of which nobody says how many count.
    pub(crate) const fn of_open_size(raw: u32) -> Self {
        Self {
            raw,
            len: 4,
            is_open: true,
        }
    }

    /// Whether the message left the number of bytes open.
    #[must_use]
    pub const fn has_open_size(self) -> bool {
        self.is_open
    }

    /// From bytes, least significant first; `None` unless there are 1 ..= 4.
    #[must_use]
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let mut padded = [0; 4];
        padded.get_mut(..bytes.len())?.copy_from_slice(bytes);
        (!bytes.is_empty()).then(|| Self::from_raw(u32::from_le_bytes(padded), bytes.len() as u8))
    }

    /// Number of bytes, 1 ..= 4; 4 when the size is open.
    #[must_use]
    #[expect(clippy::len_without_is_empty, reason = "there is always a byte")]
    pub const fn len(self) -> u8 {
        self.len
    }

    /// The bytes as one number without sign.
    #[must_use]
    pub const fn raw(self) -> u32 {
        self.raw
    }

    pub(crate) const fn raw_of_width(self, expected: u8) -> Result<u32, WidthError> {
        if self.is_open {
            return Ok(Self::from_raw(self.raw, expected).raw);
        }
        if self.len != expected {
            return Err(WidthError {
                expected,
                actual: self.len,
            });
        }
        Ok(self.raw)
    }
}

/// An integer that an object can hold.
pub trait ObjectValue: Copy {
    /// Its type in the dictionary.
    const DATA_TYPE: DataType;

    /// In its width.
    fn to_data(self) -> ObjectData;

    /// From data of its width.
    ///
    /// # Errors
    /// [`WidthError`] when the data has another width.
    fn from_data(data: ObjectData) -> Result<Self, WidthError>;
}

macro_rules! object_values {
    ($($integer:ty: $data_type:ident,)*) => {$(
        impl ObjectValue for $integer {
            const DATA_TYPE: DataType = DataType::$data_type;

            fn to_data(self) -> ObjectData {
                ObjectData::from_raw(self as u32, Self::DATA_TYPE.bytes())
            }

            fn from_data(data: ObjectData) -> Result<Self, WidthError> {
                Ok(data.raw_of_width(Self::DATA_TYPE.bytes())? as Self)
            }
        }
    )*};
}

object_values! { i8: I8, u8: U8, i16: I16, u16: U16, i32: I32, u32: U32, }

/// Data of another width than the object has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WidthError {
    /// Bytes of the object.
    pub expected: u8,
    /// Bytes that came.
    pub actual: u8,
}

impl fmt::Display for WidthError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the object has {} bytes, got {}",
            self.expected, self.actual
        )
    }
}

impl core::error::Error for WidthError {}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn values_keep_their_sign_in_every_width() {
        assert_eq!(DataType::I8.data(-1).map(ObjectData::raw), Some(0xFF));
        assert_eq!(DataType::I16.data(-1000).map(ObjectData::raw), Some(0xFC18));
        assert_eq!(DataType::I16.data(32_768), None);
        assert_eq!(DataType::U8.data(-1), None);
        assert_eq!(i16::from_data(ObjectData::from_raw(0xFC18, 2)), Ok(-1000));
        assert_eq!(
            i32::from_data(ObjectData::from_raw(0, 2)),
            Err(WidthError {
                expected: 4,
                actual: 2
            })
        );
    }

    #[test]
    fn data_of_open_size_has_the_width_of_who_asks() {
        // What lies behind the object's own bytes does not count.
        let data = ObjectData::of_open_size(0xAA55_FC18);
        assert_eq!(i16::from_data(data), Ok(-1000));
        assert_eq!(u8::from_data(data), Ok(0x18));
        assert_eq!(u32::from_data(data), Ok(0xAA55_FC18));
        assert_eq!(DataType::I16.value(data), Ok(-1000));
        assert!(data.has_open_size() && !0_u32.to_data().has_open_size());
    }

    #[test]
    fn only_one_to_four_bytes_are_data() {
        assert_eq!(ObjectData::from_bytes(&[]), None);
        assert_eq!(ObjectData::from_bytes(&[0; 5]), None);
        assert_eq!(
            ObjectData::from_bytes(&[1, 2, 3]).map(ObjectData::raw),
            Some(0x0003_0201)
        );
    }

    #[test]
    fn objects_and_types_print_as_in_the_guide() {
        let address = ObjectAddress::new(0x6081, 0);
        assert_eq!(std::format!("{address}"), "6081h:00");
        let types = [
            DataType::I8,
            DataType::U8,
            DataType::I16,
            DataType::U16,
            DataType::I32,
            DataType::U32,
        ];
        let names = types.map(|data_type| std::format!("{data_type}"));
        assert_eq!(names.join(" "), "I8 U8 I16 U16 I32 U32");
        let error = WidthError {
            expected: 4,
            actual: 2,
        };
        assert_eq!(std::format!("{error}"), "the object has 4 bytes, got 2");
    }

    #[test]
    fn bytes_beyond_the_width_do_not_count() {
        let raw = [1, 2, 3, 4].map(|len| ObjectData::from_raw(0x8765_4321, len).raw());
        assert_eq!(raw, [0x21, 0x4321, 0x65_4321, 0x8765_4321]);
    }

    proptest! {
        #[test]
        fn every_value_comes_back(value in any::<i64>()) {
            for data_type in [DataType::I8, DataType::U8, DataType::I16, DataType::U16, DataType::I32, DataType::U32] {
                for value in [value, value & 0xFF, value & 0xFFFF, value & 0xFFFF_FFFF, -(value & 0xFF)] {
                    let fits = (data_type.min()..=data_type.max()).contains(&value);
                    let data = data_type.data(value);
                    prop_assert_eq!(data.is_some(), fits);
                    if let Some(data) = data {
                        prop_assert_eq!(data_type.value(data), Ok(value));
                    }
                }
            }
        }
    }
}
