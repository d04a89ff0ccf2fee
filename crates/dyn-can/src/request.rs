//! Requests: what a master sends, and what a simulated drive or a bus monitor reads.

use can_frame::DataFrame;
use dyn_values::{Amplitude, Counts28, DriveConfig, FrequencyHz, PdStep, SpeedRpm};

use crate::byte_order::ByteOrder;
use crate::dialect::{Dialect, SetOriginData, ZeroAddress};
use crate::error::{DecodeError, EncodeError};
use crate::frame::{DynFrame, Payload, compose, expect_len, first_word};
use crate::function::{FunctionCode, Refusal, set_of};
use crate::id::{Address, DriveId};
use crate::number;
use crate::parameters::{SetParamGroup1, SetParamGroup2, SetParamGroup3};
use crate::reply::ReplyKind;
use crate::selectors::{DRIVE_RESET, ReadSelector, ServoSwitch, StoredDriveId, SyncKind};

/// A request of either revision (1.6A and 1.2A, sections 5 and 6).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Request {
    /// Makes the present position the absolute zero (EEPROM).
    #[doc(alias = "Set_Origin")]
    SetOrigin = FunctionCode::SetOrigin as u8,
    /// Moves to an absolute position with the built-in S-curve.
    #[doc(alias = "Go_Absolute_Pos_PTP")]
    GoAbsolutePosPtp(Counts28) = FunctionCode::GoAbsolutePosPtp as u8,
    /// One word of a coordinated line, 1.2A only; the sequence is not documented for CAN (D56).
    #[doc(alias = "Make_LinearLine")]
    MakeLinearLine(Counts28) = FunctionCode::MakeLinearLine as u8,
    /// Moves by a distance with the built-in S-curve.
    #[doc(alias = "Go_Relative_Pos_PTP")]
    GoRelativePosPtp(Counts28) = FunctionCode::GoRelativePosPtp as u8,
    /// One word of a coordinated arc, 1.2A only; the sequence is not documented for CAN (D56).
    #[doc(alias = "Make_CircularArc")]
    MakeCircularArc(Counts28) = FunctionCode::MakeCircularArc as u8,
    /// Stores a new drive id (EEPROM). 1.2A: active after 10 ms; 1.6A: after a power cycle (D33).
    #[doc(alias = "Assign_Drive_ID")]
    AssignDriveId(StoredDriveId) = FunctionCode::AssignDriveId as u8,
    /// Reads the drive id.
    #[doc(alias = "Read_Drive_ID")]
    ReadDriveId = FunctionCode::ReadDriveId as u8,
    /// Writes the configuration byte (EEPROM).
    #[doc(alias = "Set_Drive_Config")]
    SetDriveConfig(DriveConfig) = FunctionCode::SetDriveConfig as u8,
    /// Reads the configuration byte.
    #[doc(alias = "Read_Drive_Config")]
    ReadDriveConfig = FunctionCode::ReadDriveConfig as u8,
    /// Reads the status byte.
    #[doc(alias = "Read_Drive_Status")]
    ReadDriveStatus = FunctionCode::ReadDriveStatus as u8,
    /// Turns at constant speed. 1.6A: the drive switches itself to speed mode, and the way back is not stated (D41).
    #[doc(alias = "Turn_ConstSpeed")]
    TurnConstSpeed(SpeedRpm) = FunctionCode::TurnConstSpeed as u8,
    /// Amplitude of the built-in square wave.
    #[doc(alias = "Square_Wave")]
    SquareWave(Amplitude) = FunctionCode::SquareWave as u8,
    /// Amplitude of the built-in sine wave.
    #[doc(alias = "Sin_Wave")]
    SinWave(Amplitude) = FunctionCode::SinWave as u8,
    /// Frequency of the built-in waves.
    #[doc(alias = "SS_Frequency")]
    SsFrequency(FrequencyHz) = FunctionCode::SsFrequency as u8,
    /// Reads position or torque; the reply does not say which (D31).
    #[doc(alias = "General_Read")]
    GeneralRead(ReadSelector) = FunctionCode::GeneralRead as u8,
    /// Writes gains and torque filter (EEPROM).
    #[doc(alias = "Set_Param_Group1")]
    SetParamGroup1(SetParamGroup1) = FunctionCode::SetParamGroup1 as u8,
    /// Writes max speed and max acceleration.
    #[doc(alias = "Set_Param_Group2")]
    SetParamGroup2(SetParamGroup2) = FunctionCode::SetParamGroup2 as u8,
    /// Writes on-position range, gear and line number (EEPROM).
    #[doc(alias = "Set_Param_Group3")]
    SetParamGroup3(SetParamGroup3) = FunctionCode::SetParamGroup3 as u8,
    /// Reads gains and torque filter.
    #[doc(alias = "Read_Param_Group1")]
    ReadParamGroup1 = FunctionCode::ReadParamGroup1 as u8,
    /// Reads max speed and max acceleration.
    #[doc(alias = "Read_Param_Group2")]
    ReadParamGroup2 = FunctionCode::ReadParamGroup2 as u8,
    /// Reads on-position range, gear and line number; the length of the reply tells the revision (D62).
    #[doc(alias = "Read_Param_Group3")]
    ReadParamGroup3 = FunctionCode::ReadParamGroup3 as u8,
    /// Loads an absolute move for Sync_Trigger.
    #[doc(alias = "Go_Absolute_Pos_Sync")]
    GoAbsolutePosSync(Counts28) = FunctionCode::GoAbsolutePosSync as u8,
    /// Loads a relative move for Sync_Trigger.
    #[doc(alias = "Go_Relative_Pos_Sync")]
    GoRelativePosSync(Counts28) = FunctionCode::GoRelativePosSync as u8,
    /// Starts the loaded moves.
    #[doc(alias = "Sync_Trigger")]
    SyncTrigger(SyncKind) = FunctionCode::SyncTrigger as u8,
    /// Enables or disables the servo.
    #[doc(alias = "Servo_Disable")]
    ServoDisable(ServoSwitch) = FunctionCode::ServoDisable as u8,
    /// Reads the motor speed.
    #[doc(alias = "Read_Motor_Speed")]
    ReadMotorSpeed = FunctionCode::ReadMotorSpeed as u8,
    /// Clears a fault and resets the absolute position, 1.6A only (D36, D37).
    #[doc(alias = "Drive_Reset")]
    DriveReset = FunctionCode::DriveReset as u8,
    /// Moves by a step at once, without a speed profile: the streamed set-point.
    #[doc(alias = "Go_Relative_Pos_PD")]
    GoRelativePosPd(PdStep) = FunctionCode::GoRelativePosPd as u8,
    /// Asks for the same four bytes back.
    #[doc(alias = "Echo_Function")]
    EchoFunction([u8; 4]) = FunctionCode::EchoFunction as u8,
    /// Reads a counter that counts its own reads.
    #[doc(alias = "Diagnostic_counter")]
    DiagnosticCounter = FunctionCode::DiagnosticCounter as u8,
}

/// The frame of one streamed set-point; the hot path, which cannot fail.
///
/// The same frame as [`Request::GoRelativePosPd`] makes.
#[doc(alias = "Go_Relative_Pos_PD")]
#[must_use]
#[inline]
pub const fn go_relative_pos_pd(drive: DriveId, step: PdStep, order: ByteOrder) -> DataFrame {
    let payload = number::encode(step.get() as i32, order);
    compose(
        Address::Drive(drive),
        FunctionCode::GoRelativePosPd,
        payload,
    )
}

impl Request {
    /// The function code.
    #[must_use]
    pub const fn function(&self) -> FunctionCode {
        match self {
            Self::SetOrigin => FunctionCode::SetOrigin,
            Self::GoAbsolutePosPtp(_) => FunctionCode::GoAbsolutePosPtp,
            Self::MakeLinearLine(_) => FunctionCode::MakeLinearLine,
            Self::GoRelativePosPtp(_) => FunctionCode::GoRelativePosPtp,
            Self::MakeCircularArc(_) => FunctionCode::MakeCircularArc,
            Self::AssignDriveId(_) => FunctionCode::AssignDriveId,
            Self::ReadDriveId => FunctionCode::ReadDriveId,
            Self::SetDriveConfig(_) => FunctionCode::SetDriveConfig,
            Self::ReadDriveConfig => FunctionCode::ReadDriveConfig,
            Self::ReadDriveStatus => FunctionCode::ReadDriveStatus,
            Self::TurnConstSpeed(_) => FunctionCode::TurnConstSpeed,
            Self::SquareWave(_) => FunctionCode::SquareWave,
            Self::SinWave(_) => FunctionCode::SinWave,
            Self::SsFrequency(_) => FunctionCode::SsFrequency,
            Self::GeneralRead(_) => FunctionCode::GeneralRead,
            Self::SetParamGroup1(_) => FunctionCode::SetParamGroup1,
            Self::SetParamGroup2(_) => FunctionCode::SetParamGroup2,
            Self::SetParamGroup3(_) => FunctionCode::SetParamGroup3,
            Self::ReadParamGroup1 => FunctionCode::ReadParamGroup1,
            Self::ReadParamGroup2 => FunctionCode::ReadParamGroup2,
            Self::ReadParamGroup3 => FunctionCode::ReadParamGroup3,
            Self::GoAbsolutePosSync(_) => FunctionCode::GoAbsolutePosSync,
            Self::GoRelativePosSync(_) => FunctionCode::GoRelativePosSync,
            Self::SyncTrigger(_) => FunctionCode::SyncTrigger,
            Self::ServoDisable(_) => FunctionCode::ServoDisable,
            Self::ReadMotorSpeed => FunctionCode::ReadMotorSpeed,
            Self::DriveReset => FunctionCode::DriveReset,
            Self::GoRelativePosPd(_) => FunctionCode::GoRelativePosPd,
            Self::EchoFunction(_) => FunctionCode::EchoFunction,
            Self::DiagnosticCounter => FunctionCode::DiagnosticCounter,
        }
    }

    /// The reply that the drive sends, `None` where it sends nothing.
    #[must_use]
    #[inline(always)]
    pub const fn reply_kind(&self) -> Option<ReplyKind> {
        Some(match self {
            Self::ReadDriveId => ReplyKind::DriveId,
            Self::ReadDriveConfig => ReplyKind::DriveConfig,
            Self::ReadDriveStatus => ReplyKind::DriveStatus,
            Self::GeneralRead(ReadSelector::Position) => ReplyKind::Position,
            Self::GeneralRead(ReadSelector::Torque) => ReplyKind::Torque,
            Self::ReadParamGroup1 => ReplyKind::ParamGroup1,
            Self::ReadParamGroup2 => ReplyKind::ParamGroup2,
            Self::ReadParamGroup3 => ReplyKind::ParamGroup3,
            Self::ReadMotorSpeed => ReplyKind::MotorSpeed,
            Self::DriveReset => ReplyKind::DriveReset,
            Self::EchoFunction(_) => ReplyKind::Echo,
            Self::DiagnosticCounter => ReplyKind::DiagnosticCounter,
            _ => return None,
        })
    }

    /// Whether the request may go to identifier 0 (D2, D7).
    #[must_use]
    pub const fn may_be_broadcast(&self, permission: ZeroAddress) -> bool {
        match (permission, self) {
            (ZeroAddress::LoneFreshDrive, _) | (_, Self::SyncTrigger(_)) => true,
            (
                ZeroAddress::Disable | ZeroAddress::DisableAndSpeedZero,
                Self::ServoDisable(ServoSwitch::Disable),
            ) => true,
            (ZeroAddress::DisableAndSpeedZero, Self::TurnConstSpeed(speed)) => speed.get() == 0,
            _ => false,
        }
    }

    /// The frame of this request.
    ///
    /// # Errors
    /// [`EncodeError`] when the revision lacks the function, when it may not be broadcast, or when
    /// Assign_Drive_ID would store 0 without permission.
    pub fn encode(&self, to: Address, dialect: &Dialect) -> Result<DataFrame, EncodeError> {
        let function = self.function();
        function.admit_request(dialect.revision)?;
        if to == Address::Broadcast && !self.may_be_broadcast(dialect.zero_address) {
            return Err(EncodeError::Broadcast { function });
        }
        if let Self::AssignDriveId(id) = self
            && !dialect.allow_assign_zero
        {
            DriveId::new(i32::from(id.get()))?;
        }
        Ok(compose(to, function, self.payload(dialect)))
    }

    fn payload(&self, dialect: &Dialect) -> Payload {
        let number = match *self {
            Self::GoAbsolutePosPtp(counts)
            | Self::MakeLinearLine(counts)
            | Self::GoRelativePosPtp(counts)
            | Self::MakeCircularArc(counts)
            | Self::GoAbsolutePosSync(counts)
            | Self::GoRelativePosSync(counts) => counts.get(),
            Self::TurnConstSpeed(speed) => i32::from(speed.get()),
            Self::SquareWave(amplitude) | Self::SinWave(amplitude) => i32::from(amplitude.get()),
            Self::GoRelativePosPd(step) => i32::from(step.get()),
            _ => return self.payload_of_bytes(dialect),
        };
        number::encode(number, dialect.number_order)
    }

    /// The data of a request that carries no number of variable length.
    fn payload_of_bytes(&self, dialect: &Dialect) -> Payload {
        let byte = match *self {
            Self::SetOrigin => match dialect.set_origin {
                SetOriginData::Magic(magic) => magic,
                SetOriginData::Empty => return Payload::EMPTY,
            },
            Self::AssignDriveId(id) => id.get(),
            Self::SetDriveConfig(config) => config.to_byte(),
            Self::SsFrequency(frequency) => frequency.get(),
            Self::GeneralRead(selector) => selector as u8,
            Self::SyncTrigger(kind) => kind as u8,
            Self::ServoDisable(switch) => switch as u8,
            Self::DriveReset => DRIVE_RESET,
            Self::SetParamGroup1(group) => return group.payload(),
            Self::SetParamGroup2(group) => return group.payload(),
            Self::SetParamGroup3(group) => return group.payload(dialect.group3_request_order),
            Self::EchoFunction(bytes) => return Payload::from_word(bytes, 4),
            _ => match dialect.read_dummy {
                Some(dummy) => dummy,
                None => return Payload::EMPTY,
            },
        };
        Payload::one(byte)
    }

    /// Reads a frame as a request.
    ///
    /// Requests and replies share identifiers (D6): which of the two a frame is, only its sender or the conversation
    /// tells.
    ///
    /// # Errors
    /// [`DecodeError`] for everything that this dialect does not allow as a request.
    pub fn decode(frame: &DataFrame, dialect: &Dialect) -> Result<(Address, Self), DecodeError> {
        let function = frame.function();
        function.admit_request(dialect.revision)?;
        let request = Self::decode_function(function, frame, dialect)?;
        let address = frame.address();
        if address == Address::Broadcast && !request.may_be_broadcast(dialect.zero_address) {
            return Err(DecodeError::Broadcast { function });
        }
        Ok((address, request))
    }

    fn decode_function(
        function: FunctionCode,
        frame: &DataFrame,
        dialect: &Dialect,
    ) -> Result<Self, DecodeError> {
        expect_len(frame, lengths(function, dialect))?;
        let word @ [byte, ..] = first_word(frame);
        let value = if function.is_one_of(NUMBERS) {
            number::decode_checked(frame, dialect)?
        } else {
            i32::from(byte)
        };
        let magic = |expected| DecodeError::Magic {
            function,
            expected,
            actual: byte,
        };
        Ok(match function {
            FunctionCode::SetOrigin => match dialect.set_origin {
                SetOriginData::Magic(expected) if expected != byte => {
                    return Err(magic([expected; 2]));
                }
                _ => Self::SetOrigin,
            },
            FunctionCode::GoAbsolutePosPtp => Self::GoAbsolutePosPtp(Counts28::new(value)?),
            FunctionCode::MakeLinearLine => Self::MakeLinearLine(Counts28::new(value)?),
            FunctionCode::GoRelativePosPtp => Self::GoRelativePosPtp(Counts28::new(value)?),
            FunctionCode::MakeCircularArc => Self::MakeCircularArc(Counts28::new(value)?),
            FunctionCode::AssignDriveId => {
                let id = StoredDriveId::new(value)?;
                if !dialect.allow_assign_zero {
                    DriveId::new(value)?;
                }
                Self::AssignDriveId(id)
            }
            FunctionCode::ReadDriveId => Self::ReadDriveId,
            FunctionCode::SetDriveConfig => Self::SetDriveConfig(DriveConfig::from_byte(byte)?),
            FunctionCode::ReadDriveConfig => Self::ReadDriveConfig,
            FunctionCode::ReadDriveStatus => Self::ReadDriveStatus,
            FunctionCode::TurnConstSpeed => Self::TurnConstSpeed(SpeedRpm::new(value)?),
            FunctionCode::SquareWave => Self::SquareWave(Amplitude::new(value)?),
            FunctionCode::SinWave => Self::SinWave(Amplitude::new(value)?),
            FunctionCode::SsFrequency => Self::SsFrequency(FrequencyHz::new(value)?),
            FunctionCode::GeneralRead => {
                Self::GeneralRead(ReadSelector::from_byte(byte).map_err(magic)?)
            }
            FunctionCode::SetParamGroup1 => Self::SetParamGroup1(SetParamGroup1::decode(word)?),
            FunctionCode::SetParamGroup2 => Self::SetParamGroup2(SetParamGroup2::decode(word)?),
            FunctionCode::SetParamGroup3 => {
                let order = dialect.group3_request_order;
                Self::SetParamGroup3(SetParamGroup3::decode(frame, order)?)
            }
            FunctionCode::ReadParamGroup1 => Self::ReadParamGroup1,
            FunctionCode::ReadParamGroup2 => Self::ReadParamGroup2,
            FunctionCode::ReadParamGroup3 => Self::ReadParamGroup3,
            FunctionCode::GoAbsolutePosSync => Self::GoAbsolutePosSync(Counts28::new(value)?),
            FunctionCode::GoRelativePosSync => Self::GoRelativePosSync(Counts28::new(value)?),
            FunctionCode::SyncTrigger => {
                Self::SyncTrigger(SyncKind::from_byte(byte).map_err(magic)?)
            }
            FunctionCode::ServoDisable => {
                Self::ServoDisable(ServoSwitch::from_byte(byte).map_err(magic)?)
            }
            FunctionCode::ReadMotorSpeed => Self::ReadMotorSpeed,
            FunctionCode::DriveReset if byte != DRIVE_RESET => {
                return Err(magic([DRIVE_RESET; 2]));
            }
            FunctionCode::DriveReset => Self::DriveReset,
            FunctionCode::GoRelativePosPd => Self::GoRelativePosPd(PdStep::new(value)?),
            FunctionCode::EchoFunction => Self::EchoFunction(word),
            FunctionCode::DiagnosticCounter => Self::DiagnosticCounter,
            FunctionCode::ForMotorDefine => return Err(Refusal::Factory.into()),
            FunctionCode::DriveError => return Err(Refusal::DriveOnly.into()),
        })
    }
}

/// The functions whose data is one number of variable length.
const NUMBERS: u32 = set_of(&[
    FunctionCode::GoAbsolutePosPtp,
    FunctionCode::MakeLinearLine,
    FunctionCode::GoRelativePosPtp,
    FunctionCode::MakeCircularArc,
    FunctionCode::TurnConstSpeed,
    FunctionCode::SquareWave,
    FunctionCode::SinWave,
    FunctionCode::GoAbsolutePosSync,
    FunctionCode::GoRelativePosSync,
    FunctionCode::GoRelativePosPd,
]);

/// The fewest and the most data bytes of a request.
const fn lengths(function: FunctionCode, dialect: &Dialect) -> (u8, u8) {
    match function {
        FunctionCode::GoAbsolutePosPtp
        | FunctionCode::MakeLinearLine
        | FunctionCode::GoRelativePosPtp
        | FunctionCode::MakeCircularArc
        | FunctionCode::GoAbsolutePosSync
        | FunctionCode::GoRelativePosSync => (1, 4),
        FunctionCode::SquareWave | FunctionCode::SinWave => (1, 3),
        FunctionCode::TurnConstSpeed | FunctionCode::GoRelativePosPd => (1, 2),
        FunctionCode::SetParamGroup1 | FunctionCode::EchoFunction => (4, 4),
        FunctionCode::SetParamGroup2 => (2, 2),
        FunctionCode::SetParamGroup3 => (5, 5),
        FunctionCode::SetOrigin => match dialect.set_origin {
            SetOriginData::Magic(_) => (1, 1),
            SetOriginData::Empty => (0, 0),
        },
        // No arguments: no data, or one byte of any value where the dialect has a dummy (D11).
        FunctionCode::ReadDriveId
        | FunctionCode::ReadDriveConfig
        | FunctionCode::ReadDriveStatus
        | FunctionCode::ReadParamGroup1
        | FunctionCode::ReadParamGroup2
        | FunctionCode::ReadParamGroup3
        | FunctionCode::ReadMotorSpeed
        | FunctionCode::DiagnosticCounter => (0, dialect.read_dummy.is_some() as u8),
        _ => (1, 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DRIVE_1: Address = Address::Drive(DriveId::MIN);

    #[test]
    fn a_set_point_by_hand() {
        let step = PdStep::new(-120).unwrap();
        let frame = go_relative_pos_pd(DriveId::MIN, step, ByteOrder::MsbFirst);
        assert_eq!((frame.id(), frame.data()), (0x03C, &[0x88][..]));
        let encoded = Request::GoRelativePosPd(step).encode(DRIVE_1, &Dialect::V1_6A);
        assert_eq!(encoded, Ok(frame));
    }

    #[test]
    fn the_origin_byte_follows_the_revision() {
        let data = |dialect| {
            Request::SetOrigin
                .encode(DRIVE_1, dialect)
                .unwrap()
                .data()
                .to_vec()
        };
        assert_eq!(data(&Dialect::V1_2A), [0xFF]);
        assert_eq!(data(&Dialect::V1_6A), [0xAB]);
        let empty = Dialect {
            set_origin: SetOriginData::Empty,
            ..Dialect::V1_6A
        };
        assert!(data(&empty).is_empty());
    }

    #[test]
    fn only_what_stops_may_be_broadcast_on_request() {
        let disable = Request::ServoDisable(ServoSwitch::Disable);
        let enable = Request::ServoDisable(ServoSwitch::Enable);
        let refused = |request: Request, dialect: &Dialect| {
            request.encode(Address::Broadcast, dialect)
                == Err(EncodeError::Broadcast {
                    function: request.function(),
                })
        };
        assert!(refused(disable, &Dialect::V1_6A));
        let only_disable = Dialect {
            zero_address: ZeroAddress::Disable,
            ..Dialect::V1_6A
        };
        assert!(!refused(disable, &only_disable));
        assert!(refused(
            Request::TurnConstSpeed(SpeedRpm::ZERO),
            &only_disable
        ));
        let stop = Dialect {
            zero_address: ZeroAddress::DisableAndSpeedZero,
            ..Dialect::V1_6A
        };
        assert!(!refused(disable, &stop));
        assert!(refused(enable, &stop));
        assert!(!refused(Request::TurnConstSpeed(SpeedRpm::ZERO), &stop));
        assert!(refused(Request::TurnConstSpeed(SpeedRpm::MAX), &stop));
        assert!(refused(Request::ReadDriveId, &stop));
        assert!(!refused(
            Request::SyncTrigger(SyncKind::Relative),
            &Dialect::V1_6A
        ));
    }

    #[test]
    fn storing_the_broadcast_address_needs_permission() {
        let request = Request::AssignDriveId(StoredDriveId::NONE);
        assert!(matches!(
            request.encode(DRIVE_1, &Dialect::V1_6A),
            Err(EncodeError::Range(_))
        ));
        let allowed = Dialect {
            allow_assign_zero: true,
            ..Dialect::V1_6A
        };
        let frame = request.encode(DRIVE_1, &allowed).unwrap();
        assert_eq!(frame.data(), [0x00]);
        assert_eq!(Request::decode(&frame, &allowed), Ok((DRIVE_1, request)));
        assert!(Request::decode(&frame, &Dialect::V1_6A).is_err());
    }

    #[test]
    fn a_dummy_byte_on_reads_is_a_choice() {
        let dummy = Dialect {
            read_dummy: Some(0),
            ..Dialect::V1_6A
        };
        let frame = Request::ReadDriveStatus.encode(DRIVE_1, &dummy).unwrap();
        assert_eq!(frame.data(), [0x00]);
        assert!(Request::decode(&frame, &dummy).is_ok());
        assert!(Request::decode(&frame, &Dialect::V1_6A).is_err());
    }
}
