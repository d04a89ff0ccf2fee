//! Identifier: `drive_id << 5 | function code` (1.6A section 4, 11-bit identifier structure).

use core::fmt;

use dyn_values::{Quantity, RangeError};

use crate::Revision;
use crate::error::Refusal;

/// A drive on the bus, 1 ..= 63.
///
/// 0 is broadcast, 64 is printed in the documents but does not fit the 6-bit field (D1, D2). Drive 63 is legal, but
/// its identifiers from 0x7F0 on begin with seven recessive bits, which some old controllers cannot send (D4).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DriveId(u8);

impl DriveId {
    /// Drive 1.
    pub const MIN: Self = Self(1);
    /// Drive 63.
    pub const MAX: Self = Self(63);

    /// Checks a drive id.
    ///
    /// # Errors
    /// [`RangeError`] outside 1 ..= 63.
    pub const fn new(value: i32) -> Result<Self, RangeError> {
        match Quantity::DriveId.check(value) {
            Ok(value) => Ok(Self(value as u8)),
            Err(error) => Err(error),
        }
    }

    /// The number, 1 ..= 63.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }

    /// The identifier of a function of this drive.
    #[must_use]
    pub const fn can_id(self, function: FunctionCode) -> u16 {
        (self.0 as u16) << 5 | function as u16
    }

    /// Every drive id in ascending order, for a scan.
    pub fn all() -> impl Iterator<Item = Self> {
        (Self::MIN.0..=Self::MAX.0).map(Self)
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
        match (can_id >> 5 & 0x3F) as u8 {
            0 => Self::Broadcast,
            id => Self::Drive(DriveId(id)),
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

macro_rules! function_codes {
    ($($(#[$doc:meta])* $code:literal $variant:ident $name:literal,)*) => {
        /// The 32 function codes of both revisions (section 5). RS232 codes differ from 0x10 on (M22).
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[repr(u8)]
        pub enum FunctionCode {
            $($(#[$doc])* $variant = $code,)*
        }

        impl FunctionCode {
            /// Every function code in ascending order.
            pub const ALL: [Self; 32] = [$(Self::$variant,)*];

            /// The name that the documents print.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

function_codes! {
    /// Makes the present position the absolute zero.
    0x00 SetOrigin "Set_Origin",
    /// Point-to-point move to an absolute position.
    0x01 GoAbsolutePosPtp "Go_Absolute_Pos_PTP",
    /// Coordinated line, 1.2A only.
    0x02 MakeLinearLine "Make_LinearLine",
    /// Point-to-point move by a distance.
    0x03 GoRelativePosPtp "Go_Relative_Pos_PTP",
    /// Coordinated arc, 1.2A only.
    0x04 MakeCircularArc "Make_CircularArc",
    /// Stores a new drive id.
    0x05 AssignDriveId "Assign_Drive_ID",
    /// Reads the drive id.
    0x06 ReadDriveId "Read_Drive_ID",
    /// Writes the configuration byte (EEPROM).
    0x07 SetDriveConfig "Set_Drive_Config",
    /// Reads the configuration byte.
    0x08 ReadDriveConfig "Read_Drive_Config",
    /// Reads the status byte.
    0x09 ReadDriveStatus "Read_Drive_Status",
    /// Turns at constant speed.
    0x0A TurnConstSpeed "Turn_ConstSpeed",
    /// Amplitude of the built-in square wave.
    0x0B SquareWave "Square_Wave",
    /// Amplitude of the built-in sine wave.
    0x0C SinWave "Sin_Wave",
    /// Frequency of the built-in waves.
    0x0D SsFrequency "SS_Frequency",
    /// Reads position or torque.
    0x0E GeneralRead "General_Read",
    /// Reserved for the factory.
    0x0F ForMotorDefine "ForMotorDefine",
    /// Writes gains and torque filter (EEPROM).
    0x10 SetParamGroup1 "Set_Param_Group1",
    /// Writes max speed and max acceleration.
    0x11 SetParamGroup2 "Set_Param_Group2",
    /// Writes on-position range, gear number and line number (EEPROM).
    0x12 SetParamGroup3 "Set_Param_Group3",
    /// Reads gains and torque filter.
    0x13 ReadParamGroup1 "Read_Param_Group1",
    /// Reads max speed and max acceleration.
    0x14 ReadParamGroup2 "Read_Param_Group2",
    /// Reads on-position range, gear number and line number.
    0x15 ReadParamGroup3 "Read_Param_Group3",
    /// Loads an absolute move for Sync_Trigger.
    0x16 GoAbsolutePosSync "Go_Absolute_Pos_Sync",
    /// Loads a relative move for Sync_Trigger.
    0x17 GoRelativePosSync "Go_Relative_Pos_Sync",
    /// Starts the loaded moves.
    0x18 SyncTrigger "Sync_Trigger",
    /// Enables (data 00) or disables (data FF) the servo.
    0x19 ServoDisable "Servo_Disable",
    /// Reads the motor speed.
    0x1A ReadMotorSpeed "Read_Motor_Speed",
    /// Resets the drive, 1.6A only.
    0x1B DriveReset "Drive_Reset",
    /// Streamed relative set-point, position direct.
    0x1C GoRelativePosPd "Go_Relative_Pos_PD",
    /// Sent by a drive unasked: alarm or data error.
    0x1D DriveError "Drive_Error",
    /// Returns four bytes as they came.
    0x1E EchoFunction "Echo_Function",
    /// Reads a counter that counts its own reads.
    0x1F DiagnosticCounter "Diagnostic_counter",
}

impl FunctionCode {
    /// The function code in the lower five bits of an identifier.
    #[must_use]
    pub const fn from_can_id(can_id: u16) -> Self {
        Self::ALL[(can_id & 0x1F) as usize]
    }

    /// Whether a master may send this function in this revision.
    ///
    /// # Errors
    /// [`Refusal`] with the reason for 0x0F, 0x1D and the codes missing in the revision.
    pub const fn admit_request(self, revision: Revision) -> Result<(), Refusal> {
        match (self, revision) {
            (Self::ForMotorDefine, _) => Err(Refusal::Factory),
            (Self::DriveError, _) => Err(Refusal::DriveOnly),
            (Self::MakeLinearLine | Self::MakeCircularArc, Revision::V1_6A)
            | (Self::DriveReset, Revision::V1_2A) => Err(Refusal::Revision {
                function: self,
                revision,
            }),
            _ => Ok(()),
        }
    }

    /// Whether a drive sends this function in this revision, as a reply or by itself.
    ///
    /// # Errors
    /// [`Refusal`] with the reason for functions without a reply.
    pub const fn admit_reply(self, revision: Revision) -> Result<(), Refusal> {
        match self {
            Self::DriveError => return Ok(()),
            Self::ReadDriveId
            | Self::ReadDriveConfig
            | Self::ReadDriveStatus
            | Self::GeneralRead
            | Self::ReadParamGroup1
            | Self::ReadParamGroup2
            | Self::ReadParamGroup3
            | Self::ReadMotorSpeed
            | Self::DriveReset
            | Self::EchoFunction
            | Self::DiagnosticCounter => {}
            Self::ForMotorDefine => return Err(Refusal::Factory),
            _ => return Err(Refusal::NoReply { function: self }),
        }
        self.admit_request(revision)
    }
}

impl fmt::Display for FunctionCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (0x{:02X})", self.name(), *self as u8)
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
    fn reserved_codes_are_refused_with_their_reason() {
        use FunctionCode as F;
        use Revision::{V1_2A, V1_6A};
        assert_eq!(
            F::ForMotorDefine.admit_request(V1_2A),
            Err(Refusal::Factory)
        );
        assert_eq!(F::DriveError.admit_request(V1_6A), Err(Refusal::DriveOnly));
        for function in [F::MakeLinearLine, F::MakeCircularArc] {
            assert_eq!(function.admit_request(V1_2A), Ok(()));
            assert_eq!(
                function.admit_request(V1_6A),
                Err(Refusal::Revision {
                    function,
                    revision: V1_6A
                })
            );
        }
        assert_eq!(
            F::DriveReset.admit_reply(V1_2A),
            Err(Refusal::Revision {
                function: F::DriveReset,
                revision: V1_2A
            })
        );
        assert_eq!(F::DriveReset.admit_request(V1_6A), Ok(()));
        assert_eq!(
            F::SetOrigin.admit_reply(V1_6A),
            Err(Refusal::NoReply {
                function: F::SetOrigin
            })
        );
    }
}
