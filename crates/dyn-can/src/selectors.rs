//! One-byte arguments: selectors, switches, magic bytes and drive ids as data.

use core::fmt;

use dyn_values::{Quantity, RangeError};

use crate::id::DriveId;

/// Data byte of Drive_Reset (1.6A section 6, #27).
pub(crate) const DRIVE_RESET: u8 = 0xFE;

macro_rules! selector {
    ($(#[$doc:meta])* $name:ident { $(#[$first_doc:meta])* $first:ident = $first_byte:literal,
        $(#[$second_doc:meta])* $second:ident = $second_byte:literal, }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[repr(u8)]
        pub enum $name {
            $(#[$first_doc])*
            $first = $first_byte,
            $(#[$second_doc])*
            $second = $second_byte,
        }

        impl $name {
            /// The meaning of the data byte; an error has the two bytes that mean something.
            pub(crate) const fn from_byte(byte: u8) -> Result<Self, [u8; 2]> {
                match byte {
                    $first_byte => Ok(Self::$first),
                    $second_byte => Ok(Self::$second),
                    _ => Err([$first_byte, $second_byte]),
                }
            }
        }
    };
}

selector! {
    /// What General_Read reads (section 6, #14). The torque example prints function code 0x03: on the wire that is a
    /// move (D27).
    ReadSelector {
        /// 1B: position.
        Position = 0x1B,
        /// 1E: torque.
        Torque = 0x1E,
    }
}
selector! {
    /// Which loaded moves Sync_Trigger starts (section 6, #24).
    SyncKind {
        /// FF: Go_Absolute_Pos_Sync.
        Absolute = 0xFF,
        /// EE: Go_Relative_Pos_Sync.
        Relative = 0xEE,
    }
}
selector! {
    /// The two arguments of Servo_Disable (section 6, #25). Mind that zero ENABLES the servo.
    ServoSwitch {
        /// 00: enable the servo.
        Enable = 0x00,
        /// FF: disable the servo, the motor coasts.
        Disable = 0xFF,
    }
}

/// A drive id that Assign_Drive_ID may store.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StoredDriveId(u8);

impl StoredDriveId {
    /// No id: the drive then answers on the broadcast identifiers only, as a fresh one does (D2).
    ///
    /// [`Dialect::allow_assign_zero`](crate::Dialect::allow_assign_zero) decides whether such a request decodes.
    pub const NONE: Self = Self(0);

    /// A drive id as stored in a drive.
    ///
    /// # Errors
    /// [`RangeError`] outside 0 ..= 63; 64 is printed but does not fit the identifier (D1).
    pub const fn new(value: i32) -> Result<Self, RangeError> {
        match Quantity::StoredDriveId.check(value) {
            Ok(value) => Ok(Self(value as u8)),
            Err(error) => Err(error),
        }
    }

    /// The number, 0 ..= 63.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }

    /// The drive id, `None` for 0.
    #[must_use]
    pub fn drive_id(self) -> Option<DriveId> {
        DriveId::new(i32::from(self.0)).ok()
    }
}

impl fmt::Display for StoredDriveId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl From<DriveId> for StoredDriveId {
    fn from(id: DriveId) -> Self {
        Self(id.get())
    }
}

/// What a drive says unasked on 0x1D (section 6, #29).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DriveError {
    /// FF: a command had data out of range; it does not say which command.
    DataError,
    /// EE: the drive is in alarm. Stop the whole group at once.
    Alarm,
    /// A byte that the documents do not list: treat it as a fault.
    Unknown(u8),
}

impl DriveError {
    /// The meaning of the data byte.
    #[must_use]
    pub const fn from_byte(byte: u8) -> Self {
        match byte {
            0xFF => Self::DataError,
            0xEE => Self::Alarm,
            other => Self::Unknown(other),
        }
    }

    /// The data byte.
    #[must_use]
    pub const fn to_byte(self) -> u8 {
        match self {
            Self::DataError => 0xFF,
            Self::Alarm => 0xEE,
            Self::Unknown(byte) => byte,
        }
    }
}

impl fmt::Display for DriveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DataError => f.write_str("data error"),
            Self::Alarm => f.write_str("alarm"),
            Self::Unknown(byte) => write!(f, "undocumented error 0x{byte:02X}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_enables_and_is_never_a_default() {
        assert_eq!(ServoSwitch::from_byte(0x00), Ok(ServoSwitch::Enable));
        assert_eq!(ServoSwitch::Enable as u8, 0x00);
        assert_eq!(ServoSwitch::Disable as u8, 0xFF);
    }

    #[test]
    fn an_unknown_selector_carries_what_was_expected() {
        assert_eq!(ReadSelector::from_byte(0x1C), Err([0x1B, 0x1E]));
    }

    #[test]
    fn undocumented_errors_survive() {
        for byte in 0..=255 {
            assert_eq!(DriveError::from_byte(byte).to_byte(), byte);
        }
    }
}
