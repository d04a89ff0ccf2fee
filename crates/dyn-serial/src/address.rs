//! Start byte: which drive a packet is for, or from (manual section 7.2.3).

use core::fmt;
use dyn_values::{Quantity, RangeError};

/// The general id, which every drive hears.
const ALL: u8 = 127;

/// A drive on the line, 0 ..= 63.
///
/// 0 is an ordinary id and the one of a fresh drive. 64 ..= 126 are reserved; the manual prints other ranges in other
/// places (D3).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DriveId(u8);

impl DriveId {
    /// The id of a drive that was never given one.
    pub const FRESH: Self = Self(0);
    /// Drive 63.
    pub const MAX: Self = Self(63);

    /// Checks a drive id.
    ///
    /// # Errors
    /// [`RangeError`] outside 0 ..= 63.
    pub const fn new(value: i32) -> Result<Self, RangeError> {
        match Quantity::SerialDriveId.check(value) {
            Ok(value) => Ok(Self(value as u8)),
            Err(error) => Err(error),
        }
    }

    /// The number, 0 ..= 63.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }

    /// Every drive id in ascending order, for a scan.
    pub fn all() -> impl Iterator<Item = Self> {
        (Self::FRESH.0..=Self::MAX.0).map(Self)
    }
}

impl TryFrom<i32> for DriveId {
    type Error = RangeError;

    fn try_from(value: i32) -> Result<Self, RangeError> {
        Self::new(value)
    }
}

impl fmt::Display for DriveId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Whom a packet is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Address {
    /// One drive.
    Drive(DriveId),
    /// The general id 127: every drive on the line.
    All,
}

impl Address {
    /// The address in a start byte.
    ///
    /// # Errors
    /// [`RangeError`] for the reserved ids 64 ..= 126 and for a byte with bit 7 set.
    pub const fn from_start_byte(byte: u8) -> Result<Self, RangeError> {
        if byte == ALL {
            return Ok(Self::All);
        }
        match DriveId::new(byte as i32) {
            Ok(drive) => Ok(Self::Drive(drive)),
            Err(error) => Err(error),
        }
    }

    /// The start byte.
    #[must_use]
    pub const fn start_byte(self) -> u8 {
        match self {
            Self::Drive(drive) => drive.0,
            Self::All => ALL,
        }
    }
}

impl From<DriveId> for Address {
    fn from(drive: DriveId) -> Self {
        Self::Drive(drive)
    }
}

impl fmt::Display for Address {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Drive(drive) => write!(f, "drive {drive}"),
            Self::All => f.write_str("all drives"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn start_byte_is_a_drive_every_drive_or_reserved() {
        for byte in 0..=u8::MAX {
            match Address::from_start_byte(byte) {
                Ok(address) => assert_eq!(address.start_byte(), byte),
                Err(_) => assert!((64..=126).contains(&byte) || byte > 127, "{byte}"),
            }
        }
        assert_eq!(Address::from_start_byte(127), Ok(Address::All));
        assert_eq!(DriveId::all().count(), 64);
    }

    #[test]
    fn an_id_is_its_number_and_an_address_names_it() {
        let drive = DriveId::new(7).unwrap();
        assert_eq!((drive.get(), DriveId::FRESH.get()), (7, 0));
        let (one, all) = (Address::from(drive), Address::All);
        assert_eq!(
            std::format!("{drive}, {one}, {all}"),
            "7, drive 7, all drives"
        );
    }
}
