//! Function codes, and which of them are requests and replies (1.6A and 1.2A, section 5).

use core::fmt;

use crate::revision::Revision;

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

            /// The function code in the lower five bits of an identifier.
            #[must_use]
            pub const fn from_can_id(can_id: u16) -> Self {
                match can_id & 0x1F {
                    $($code => Self::$variant,)*
                    // Five bits have no other value.
                    _ => Self::SetOrigin,
                }
            }

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
    /// Whether a master may send this function in this revision.
    ///
    /// # Errors
    /// [`Refusal`] with the reason for 0x0F, 0x1D and the codes missing in the revision.
    pub const fn admit_request(self, revision: Revision) -> Result<(), Refusal> {
        if !self.is_one_of(NO_REQUEST | missing(revision)) {
            return Ok(());
        }
        Err(match self {
            Self::ForMotorDefine => Refusal::Factory,
            Self::DriveError => Refusal::DriveOnly,
            function => Refusal::Revision { function, revision },
        })
    }

    /// Whether a drive sends this function in this revision, as a reply or by itself.
    ///
    /// # Errors
    /// [`Refusal`] with the reason for functions without a reply.
    pub const fn admit_reply(self, revision: Revision) -> Result<(), Refusal> {
        if self.is_one_of(REPLIES & !missing(revision)) {
            return Ok(());
        }
        Err(match self {
            Self::ForMotorDefine => Refusal::Factory,
            function if self.is_one_of(REPLIES) => Refusal::Revision { function, revision },
            function => Refusal::NoReply { function },
        })
    }

    /// Whether it is in a set, one bit a function.
    pub(crate) const fn is_one_of(self, set: u32) -> bool {
        set >> self as u32 & 1 != 0
    }
}

/// A set of functions, one bit each.
pub(crate) const fn set_of(functions: &[FunctionCode]) -> u32 {
    let (mut set, mut index) = (0, 0);
    while index < functions.len() {
        set |= 1 << functions[index] as u32;
        index += 1;
    }
    set
}

/// What no master may send in any revision.
const NO_REQUEST: u32 = set_of(&[FunctionCode::ForMotorDefine, FunctionCode::DriveError]);

/// What a drive sends.
const REPLIES: u32 = set_of(&[
    FunctionCode::ReadDriveId,
    FunctionCode::ReadDriveConfig,
    FunctionCode::ReadDriveStatus,
    FunctionCode::GeneralRead,
    FunctionCode::ReadParamGroup1,
    FunctionCode::ReadParamGroup2,
    FunctionCode::ReadParamGroup3,
    FunctionCode::ReadMotorSpeed,
    FunctionCode::DriveReset,
    FunctionCode::DriveError,
    FunctionCode::EchoFunction,
    FunctionCode::DiagnosticCounter,
]);

/// The functions that a revision lacks.
const fn missing(revision: Revision) -> u32 {
    match revision {
        Revision::V1_2A => set_of(&[FunctionCode::DriveReset]),
        Revision::V1_6A => set_of(&[FunctionCode::MakeLinearLine, FunctionCode::MakeCircularArc]),
    }
}

impl fmt::Display for FunctionCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (0x{:02X})", self.name(), *self as u8)
    }
}

/// Why a function code is not a request, or not a reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Refusal {
    /// 0x0F, reserved for the factory in both revisions (section 6, ForMotorDefine).
    Factory,
    /// 0x1D, which only a drive sends (section 6, Drive Error; D38).
    DriveOnly,
    /// The drive sends no reply to this function (column "Return Data" of section 5).
    NoReply {
        /// The function without a reply.
        function: FunctionCode,
    },
    /// The function does not exist in this revision: 0x02 and 0x04 in 1.6A, 0x1B in 1.2A.
    Revision {
        /// The function that is missing.
        function: FunctionCode,
        /// The revision in which it is missing.
        revision: Revision,
    },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Factory => {
                f.write_str("function code 0x0F is reserved for the factory: never send it")
            }
            Self::DriveOnly => f.write_str("Drive_Error (0x1D) is sent by drives only"),
            Self::NoReply { function } => write!(f, "{function} has no reply"),
            Self::Revision { function, revision } => {
                write!(f, "{function} does not exist in revision {revision}")
            }
        }
    }
}

impl core::error::Error for Refusal {}

#[cfg(test)]
mod tests {
    use super::*;

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

    #[test]
    fn functions_and_refusals_are_named_as_in_the_documents() {
        let function = FunctionCode::GoRelativePosPd;
        let revision = Revision::V1_6A;
        let text = |refusal: Refusal| std::format!("{refusal}");
        assert_eq!(std::format!("{function}"), "Go_Relative_Pos_PD (0x1C)");
        assert_eq!(
            text(Refusal::Factory),
            "function code 0x0F is reserved for the factory: never send it"
        );
        assert_eq!(
            text(Refusal::DriveOnly),
            "Drive_Error (0x1D) is sent by drives only"
        );
        assert_eq!(
            text(Refusal::NoReply { function }),
            "Go_Relative_Pos_PD (0x1C) has no reply"
        );
        assert_eq!(
            text(Refusal::Revision { function, revision }),
            "Go_Relative_Pos_PD (0x1C) does not exist in revision 1.6A"
        );
    }
}
