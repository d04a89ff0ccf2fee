//! Identifier: `drive_id << 5 | function code` (1.6A section 4, 11-bit identifier structure).

use core::fmt;
use core::num::NonZeroU8;

use dyn_values::{Quantity, RangeError};

use crate::function::FunctionCode;

/// A drive on the bus, 1 ..= 63.
///
/// 0 is broadcast, 64 is printed in the documents but does not fit the 6-bit field (D1, D2). Drive 63 is legal, but
/// its identifiers from 0x7F0 on begin with seven recessive bits, which some old controllers cannot send (D4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DriveId(NonZeroU8);

impl DriveId {
    /// Drive 1.
    pub const MIN: Self = Self(NonZeroU8::MIN);
    /// Drive 63.
    pub const MAX: Self = Self(NonZeroU8::MIN.saturating_add(62));

    /// Checks a drive id.
    ///
    /// # Errors
    /// [`RangeError`] outside 1 ..= 63.
    pub const fn new(value: i32) -> Result<Self, RangeError> {
        let refused = Err(RangeError {
            quantity: Quantity::DriveId,
            actual: value,
        });
        if value < Self::MIN.get() as i32 || value > Self::MAX.get() as i32 {
            return refused;
        }
        match NonZeroU8::new(value as u8) {
            Some(id) => Ok(Self(id)),
            None => refused,
        }
    }

    /// The number, 1 ..= 63.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0.get()
    }

    /// The identifier of a function of this drive.
    #[must_use]
    pub const fn can_id(self, function: FunctionCode) -> u16 {
        (self.get() as u16) << 5 | function as u16
    }

    /// Every drive id in ascending order, for a scan.
    pub fn all() -> impl Iterator<Item = Self> {
        (Self::MIN.get()..=Self::MAX.get()).filter_map(|id| NonZeroU8::new(id).map(Self))
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

/// Whom a request is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Address {
    /// One drive.
    Drive(DriveId),
    /// Identifier 0: every drive on the bus, and a fresh drive that still has id 0 (D2, D7).
    Broadcast,
}

impl Address {
    /// The address in the upper six bits of an 11-bit identifier.
    #[must_use]
    pub const fn from_can_id(can_id: u16) -> Self {
        match NonZeroU8::new((can_id >> 5 & 0x3F) as u8) {
            None => Self::Broadcast,
            Some(id) => Self::Drive(DriveId(id)),
        }
    }

    /// The identifier of a function at this address.
    #[must_use]
    pub const fn can_id(self, function: FunctionCode) -> u16 {
        match self {
            Self::Drive(drive) => drive.can_id(function),
            Self::Broadcast => function as u16,
        }
    }

    /// The drive, unless this is the broadcast address.
    #[must_use]
    pub const fn drive(self) -> Option<DriveId> {
        match self {
            Self::Drive(drive) => Some(drive),
            Self::Broadcast => None,
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
            Self::Broadcast => f.write_str("all drives"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifier_is_drive_times_32_plus_function() {
        let drive = DriveId::new(4).unwrap();
        assert_eq!(drive.can_id(FunctionCode::TurnConstSpeed), 0x08A);
        assert_eq!(DriveId::MAX.can_id(FunctionCode::DiagnosticCounter), 0x7FF);
        assert_eq!(Address::Broadcast.can_id(FunctionCode::SyncTrigger), 0x018);
    }

    #[test]
    fn every_identifier_splits_and_joins() {
        for can_id in 0..=0x7FF_u16 {
            let address = Address::from_can_id(can_id);
            assert_eq!(address.can_id(FunctionCode::from_can_id(can_id)), can_id);
        }
    }

    #[test]
    fn drive_0_and_64_do_not_exist() {
        assert!(DriveId::new(0).is_err());
        assert!(DriveId::new(64).is_err());
        assert_eq!(DriveId::all().count(), 63);
    }

    #[test]
    fn an_address_is_a_drive_or_all_of_them() {
        let drive = DriveId::new(7).unwrap();
        let (one, all) = (Address::from(drive), Address::Broadcast);
        assert_eq!((one.drive(), all.drive()), (Some(drive), None));
        assert_eq!(
            std::format!("{drive}, {one}, {all}"),
            "7, drive 7, all drives"
        );
    }
}
