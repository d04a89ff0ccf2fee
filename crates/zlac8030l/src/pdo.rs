//! PDO mapping: which objects travel in a PDO, and their values in its bytes (guide section 6).

use core::fmt;

use can_frame::DataFrame;

use crate::error::DecodeError;
use crate::frame::{compose, exactly};
use crate::node::{NodeId, PdoNumber, Service};
use crate::object::{DataType, ObjectAddress, ObjectData, ObjectValue};
use crate::typed_object::Object;

/// The most objects that one PDO of this drive can hold (1600h..1603h, 1A00h..1A03h: entries 1 to 4).
pub const MAX_ENTRIES: usize = 4;

/// One mapped object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MappingEntry {
    /// The object.
    pub address: ObjectAddress,
    /// Its length in bits: 8, 16 or 32 on this drive.
    pub bits: u8,
}

impl MappingEntry {
    /// An object of a type.
    #[must_use]
    pub const fn new(address: ObjectAddress, data_type: DataType) -> Self {
        Self {
            address,
            bits: data_type.bytes() * 8,
        }
    }

    /// A typed object.
    #[must_use]
    pub const fn of<T: ObjectValue>(object: Object<T>) -> Self {
        Self::new(object.address(), T::DATA_TYPE)
    }

    /// The mapping word: index, sub-index, bits from the highest byte down. 606C0020h is the speed.
    #[must_use]
    pub const fn to_word(self) -> u32 {
        (self.address.index as u32) << 16 | (self.address.sub as u32) << 8 | self.bits as u32
    }

    /// From a mapping word.
    #[must_use]
    pub const fn from_word(word: u32) -> Self {
        let [bits, sub, index_low, index_high] = word.to_le_bytes();
        Self {
            address: ObjectAddress::new(u16::from_le_bytes([index_low, index_high]), sub),
            bits,
        }
    }
}

/// A mapping that no PDO of this drive can hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum MappingError {
    /// More than 4 objects.
    Entries {
        /// The number given.
        actual: usize,
    },
    /// A length that is not 8, 16 or 32 bits.
    Bits {
        /// The object.
        address: ObjectAddress,
        /// The length given.
        actual: u8,
    },
    /// More than 8 bytes together.
    Length {
        /// The bits of all objects.
        bits: u16,
    },
}

impl fmt::Display for MappingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Entries { actual } => write!(f, "a PDO holds at most 4 objects, got {actual}"),
            Self::Bits { address, actual } => {
                write!(f, "{address} must have 8, 16 or 32 bits, got {actual}")
            }
            Self::Length { bits } => write!(f, "a PDO holds at most 64 bits, got {bits}"),
        }
    }
}

impl core::error::Error for MappingError {}

/// The objects of one PDO, in the order of their bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PdoMapping {
    entries: [Option<MappingEntry>; MAX_ENTRIES],
}

impl PdoMapping {
    /// No object: the PDO is off.
    pub const EMPTY: Self = Self {
        entries: [None; MAX_ENTRIES],
    };

    /// A mapping of these objects.
    ///
    /// # Errors
    /// [`MappingError`] when they do not fit.
    pub fn new(entries: &[MappingEntry]) -> Result<Self, MappingError> {
        let mut mapping = Self::EMPTY;
        let actual = entries.len();
        let Some(places) = mapping.entries.get_mut(..actual) else {
            return Err(MappingError::Entries { actual });
        };
        let mut bits = 0;
        for (place, entry) in places.iter_mut().zip(entries) {
            if !matches!(entry.bits, 8 | 16 | 32) {
                return Err(MappingError::Bits {
                    address: entry.address,
                    actual: entry.bits,
                });
            }
            bits += u16::from(entry.bits);
            *place = Some(*entry);
        }
        if bits > 64 {
            return Err(MappingError::Length { bits });
        }
        Ok(mapping)
    }

    /// The mapped objects, in order.
    pub fn entries(&self) -> impl Iterator<Item = MappingEntry> {
        self.entries.iter().flatten().copied()
    }

    /// Data bytes of the PDO, 0 ..= 8.
    #[must_use]
    pub fn len(&self) -> u8 {
        self.entries().map(|entry| entry.bits / 8).sum()
    }

    /// No object is mapped.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The frame to a drive, with one value for each mapped object; missing values are 0, surplus ones are not sent.
    #[must_use]
    pub fn rpdo(&self, node: NodeId, number: PdoNumber, values: &[ObjectData]) -> DataFrame {
        self.pack(Service::Rpdo(number, node), values)
    }

    /// The frame of a drive.
    #[must_use]
    pub fn tpdo(&self, node: NodeId, number: PdoNumber, values: &[ObjectData]) -> DataFrame {
        self.pack(Service::Tpdo(number, node), values)
    }

    fn pack(&self, service: Service, values: &[ObjectData]) -> DataFrame {
        let mut word = 0_u64;
        let mut at = 0;
        for (entry, value) in self.entries().zip(values) {
            let mask = u64::MAX >> (64 - u32::from(entry.bits));
            word |= (u64::from(value.raw()) & mask) << at;
            at += u32::from(entry.bits);
        }
        compose(service, self.len(), word.to_le_bytes())
    }

    /// The values in a PDO, in the order of the objects.
    ///
    /// # Errors
    /// [`DecodeError::Length`] when the PDO is shorter or longer than the mapping: the drive was set up in another way.
    pub fn values(
        &self,
        frame: &DataFrame,
    ) -> Result<[Option<ObjectData>; MAX_ENTRIES], DecodeError> {
        let mut word = u64::from_le_bytes(exactly(frame, self.len())?);
        Ok(self.entries.map(|entry| {
            let entry = entry?;
            let value = ObjectData::from_raw(word as u32, entry.bits / 8);
            word >>= entry.bits;
            Some(value)
        }))
    }
}

/// Where the drive keeps one PDO in its dictionary.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PdoDirection {
    /// From the drive: 1800h.. and 1A00h...
    Transmit,
    /// To the drive: 1400h.. and 1600h...
    Receive,
}

/// The objects that describe one PDO.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PdoObjects {
    communication: u16,
    mapping: u16,
}

impl PdoObjects {
    /// The objects of one PDO.
    #[must_use]
    pub const fn new(direction: PdoDirection, number: PdoNumber) -> Self {
        let number = number as u16;
        match direction {
            PdoDirection::Transmit => Self {
                communication: 0x1800 + number,
                mapping: 0x1A00 + number,
            },
            PdoDirection::Receive => Self {
                communication: 0x1400 + number,
                mapping: 0x1600 + number,
            },
        }
    }

    /// Transmission type: 254 event or 255 timer in the guide's words (Z12), 1..=240 every so many SYNCs, 0 with SYNC on change.
    #[must_use]
    pub const fn transmission_type(self) -> Object<u8> {
        Object::new(self.communication, 2)
    }

    /// Inhibit time; the guide says 0.5 ms a unit, CiA 301 100 us (Z11).
    #[must_use]
    pub const fn inhibit_time(self) -> Object<u16> {
        Object::new(self.communication, 3)
    }

    /// Event timer; the guide says 0.5 ms a unit, CiA 301 1 ms (Z11).
    #[must_use]
    pub const fn event_timer(self) -> Object<u16> {
        Object::new(self.communication, 5)
    }

    /// Number of mapped objects; printed read-only and written by every printed sequence (Z18).
    #[must_use]
    pub const fn count(self) -> Object<u8> {
        Object::new(self.mapping, 0)
    }

    /// Mapping entry, counted from 1 as in the dictionary.
    #[must_use]
    pub const fn entry(self, sub: u8) -> Object<u32> {
        Object::new(self.mapping, sub)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects;

    fn mapping(entries: &[MappingEntry]) -> PdoMapping {
        PdoMapping::new(entries).unwrap()
    }

    #[test]
    fn mapping_word_as_printed() {
        // Guide section 6.1: 23 00 1A 01 20 00 6C 60.
        let entry = MappingEntry::of(objects::ACTUAL_SPEED);
        assert_eq!(entry.to_word(), 0x606C_0020);
        assert_eq!(MappingEntry::from_word(0x606C_0020), entry);
    }

    #[test]
    fn control_word_and_speed_share_a_pdo() {
        let mapping = mapping(&[
            MappingEntry::of(objects::CONTROL_WORD),
            MappingEntry::of(objects::TARGET_SPEED),
        ]);
        let values = [15_u16.to_data(), (-1000_i32).to_data()];
        let frame = mapping.rpdo(NodeId::MAX, PdoNumber::Pdo0, &values);
        let expected = DataFrame::new(0x27F, &[0x0F, 0, 0x18, 0xFC, 0xFF, 0xFF]).unwrap();
        assert_eq!(frame, expected);
        let [first, second, third, _] = mapping.values(&frame).unwrap();
        assert_eq!(
            (first, second, third),
            (Some(values[0]), Some(values[1]), None)
        );
    }

    #[test]
    fn a_pdo_of_another_length_is_refused() {
        let mapping = mapping(&[MappingEntry::of(objects::ACTUAL_SPEED)]);
        let short = DataFrame::new(0x184, &[1, 2, 3]).unwrap();
        let error = DecodeError::Length {
            can_id: 0x184,
            expected: 4,
            actual: 3,
        };
        assert_eq!(mapping.values(&short), Err(error));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let speed = MappingEntry::of(objects::ACTUAL_SPEED);
        assert_eq!(
            PdoMapping::new(&[speed; 3]),
            Err(MappingError::Length { bits: 96 })
        );
        assert_eq!(
            PdoMapping::new(&[speed; 5]),
            Err(MappingError::Entries { actual: 5 })
        );
        let odd = MappingEntry { bits: 24, ..speed };
        assert!(matches!(
            PdoMapping::new(&[odd]),
            Err(MappingError::Bits { actual: 24, .. })
        ));
    }

    #[test]
    fn a_sub_index_stands_between_index_and_length() {
        let entry = MappingEntry::new(crate::object::ObjectAddress::new(0x1018, 4), DataType::U8);
        assert_eq!(entry.to_word(), 0x1018_0408);
        assert_eq!(MappingEntry::from_word(0x1018_0408), entry);
    }

    #[test]
    fn a_mapping_without_objects_is_empty() {
        assert!(PdoMapping::EMPTY.is_empty());
        assert!(!mapping(&[MappingEntry::of(objects::ACTUAL_SPEED)]).is_empty());
    }

    #[test]
    fn a_value_takes_its_own_bits_alone() {
        let address = crate::object::ObjectAddress::new(0x2000, 1);
        let entry = |data_type| MappingEntry::new(address, data_type);
        let mapping = mapping(&[
            entry(DataType::I8),
            entry(DataType::U16),
            entry(DataType::U32),
        ]);
        let all = ObjectData::from_raw(u32::MAX, 4);
        let none = ObjectData::from_raw(0, 4);
        let frame = |values: [ObjectData; 3]| {
            let frame = mapping.tpdo(NodeId::FACTORY, PdoNumber::Pdo0, &values);
            *frame.bytes()
        };
        assert_eq!(frame([all, none, none]), [0xFF, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(frame([none, all, none]), [0, 0xFF, 0xFF, 0, 0, 0, 0, 0]);
        assert_eq!(
            frame([none, none, all]),
            [0, 0, 0, 0xFF, 0xFF, 0xFF, 0xFF, 0]
        );
    }

    #[test]
    fn a_refused_mapping_says_why() {
        let address = crate::object::ObjectAddress::new(0x2000, 1);
        let golden = [
            (
                MappingError::Entries { actual: 5 },
                "a PDO holds at most 4 objects, got 5",
            ),
            (
                MappingError::Bits { address, actual: 7 },
                "2000h:01 must have 8, 16 or 32 bits, got 7",
            ),
            (
                MappingError::Length { bits: 72 },
                "a PDO holds at most 64 bits, got 72",
            ),
        ];
        for (error, text) in golden {
            assert_eq!(std::format!("{error}"), text);
        }
    }
}
