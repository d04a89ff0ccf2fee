//! Function codes: one table for each direction (manual section 7.2.4).
//!
//! The same five bits mean different things from host to drive and from drive to host, and from 0x10 on both differ from
//! CAN, where 0x16 starts loading a move (M22). So each table is a type of its own, and none converts into another.

use core::fmt;

macro_rules! function_codes {
    ($(#[$doc:meta])* $type:ident: $($(#[$variant_doc:meta])* $code:literal $variant:ident $name:literal,)*) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        #[repr(u8)]
        pub enum $type {
            $($(#[$variant_doc])* $variant = $code,)*
        }

        impl $type {
            /// Every function of this direction in ascending order.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// The function of a code, `None` where this direction has none.
            #[must_use]
            pub const fn from_code(code: u8) -> Option<Self> {
                match code {
                    $($code => Some(Self::$variant),)*
                    _ => None,
                }
            }

            /// The code, 0 ..= 0x1F.
            #[must_use]
            pub const fn code(self) -> u8 {
                self as u8
            }

            /// The name that the manual prints.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }

        impl fmt::Display for $type {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{} (0x{:02X})", self.name(), *self as u8)
            }
        }
    };
}

function_codes! {
    /// What a host sends.
    RequestFunction:
    /// Makes the present position the absolute zero.
    0x00 SetOrigin "Set_Origin",
    /// Moves to an absolute position.
    0x01 GoAbsolutePos "Go_Absolute_Pos",
    /// One word of a coordinated line.
    0x02 MakeLinearLine "Make_LinearLine",
    /// Moves by a distance.
    0x03 GoRelativePos "Go_Relative_Pos",
    /// One word of a coordinated arc.
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
    /// Writes the main gain (EEPROM).
    0x10 SetMainGain "Set_MainGain",
    /// Writes the speed gain (EEPROM).
    0x11 SetSpeedGain "Set_SpeedGain",
    /// Writes the integration gain (EEPROM).
    0x12 SetIntGain "Set_IntGain",
    /// Writes the torque filter constant (EEPROM).
    0x13 SetTrqCons "Set_TrqCons",
    /// Writes the max speed parameter.
    0x14 SetHighSpeed "Set_HighSpeed",
    /// Writes the max acceleration parameter.
    0x15 SetHighAccel "Set_HighAccel",
    /// Writes the on-position range (EEPROM).
    0x16 SetPosOnRange "Set_Pos_OnRange",
    /// Writes the gear number (EEPROM).
    0x17 SetGearNumber "Set_GearNumber",
    /// Reads the main gain.
    0x18 ReadMainGain "Read_MainGain",
    /// Reads the speed gain.
    0x19 ReadSpeedGain "Read_SpeedGain",
    /// Reads the integration gain.
    0x1A ReadIntGain "Read_IntGain",
    /// Reads the torque filter constant.
    0x1B ReadTrqCons "Read_TrqCons",
    /// Reads the max speed parameter.
    0x1C ReadHighSpeed "Read_HighSpeed",
    /// Reads the max acceleration parameter.
    0x1D ReadHighAccel "Read_HighAccel",
    /// Reads the on-position range.
    0x1E ReadPosOnRange "Read_Pos_OnRange",
    /// Reads the gear number.
    0x1F ReadGearNumber "Read_GearNumber",
}

function_codes! {
    /// What a drive sends. The other codes are not used (M18).
    ReplyFunction:
    /// Main gain.
    0x10 IsMainGain "Is_MainGain",
    /// Speed gain.
    0x11 IsSpeedGain "Is_SpeedGain",
    /// Integration gain.
    0x12 IsIntGain "Is_IntGain",
    /// Torque filter constant.
    0x13 IsTrqCons "Is_TrqCons",
    /// Max speed parameter.
    0x14 IsHighSpeed "Is_HighSpeed",
    /// Max acceleration parameter.
    0x15 IsHighAccel "Is_HighAccel",
    /// Drive id.
    0x16 IsDriveId "Is_Drive_ID",
    /// On-position range.
    0x17 IsPosOnRange "Is_PosOn_Range",
    /// Gear number.
    0x18 IsGearNumber "Is_GearNumber",
    /// Status byte.
    0x19 IsStatus "Is_Status",
    /// Configuration byte.
    0x1A IsConfig "Is_Config",
    /// Absolute position.
    0x1B IsAbsPos32 "Is_AbsPos32",
    /// Torque current.
    0x1E IsTrqCurrent "Is_TrqCurrent",
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_from_host_to_drive_is_a_function() {
        for code in 0..32 {
            assert_eq!(
                RequestFunction::from_code(code).map(RequestFunction::code),
                Some(code)
            );
        }
        assert_eq!(RequestFunction::from_code(32), None);
    }

    #[test]
    fn a_drive_uses_thirteen_codes() {
        let used = (0..32).filter_map(ReplyFunction::from_code);
        assert!(used.eq(ReplyFunction::ALL.iter().copied()));
        assert_eq!(ReplyFunction::ALL.len(), 13);
    }
}
