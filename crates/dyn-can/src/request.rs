//! Requests: what a master sends, and what a simulated drive or a bus monitor reads.

use can_frame::DataFrame;
use dyn_values::{Amplitude, Counts28, DriveConfig, FrequencyHz, PdStep, SpeedRpm};

use crate::byte_order::ByteOrder;
use crate::dialect::{Dialect, SetOriginData, ZeroAddress};
use crate::error::{DecodeError, EncodeError};
use crate::frame::{DynFrame, Payload, compose, expect_len, first_word, one_byte};
use crate::function::{FunctionCode, Refusal};
use crate::id::{Address, DriveId};
use crate::number;
use crate::parameters::{SetParamGroup1, SetParamGroup2, SetParamGroup3};
use crate::reply::ReplyKind;
use crate::selectors::{
    self, ReadSelector, ServoSwitch, StoredDriveId, SyncKind, decode_drive_reset,
};

/// A request of either revision (1.6A and 1.2A, sections 5 and 6).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Request {
    /// Makes the present position the absolute zero (EEPROM).
    #[doc(alias = "Set_Origin")]
    SetOrigin,
    /// Moves to an absolute position with the built-in S-curve.
    #[doc(alias = "Go_Absolute_Pos_PTP")]
    GoAbsolutePosPtp(Counts28),
    /// One word of a coordinated line, 1.2A only; the sequence is not documented for CAN (D56).
    #[doc(alias = "Make_LinearLine")]
    MakeLinearLine(Counts28),
    /// Moves by a distance with the built-in S-curve.
    #[doc(alias = "Go_Relative_Pos_PTP")]
    GoRelativePosPtp(Counts28),
    /// One word of a coordinated arc, 1.2A only; the sequence is not documented for CAN (D56).
    #[doc(alias = "Make_CircularArc")]
    MakeCircularArc(Counts28),
    /// Stores a new drive id (EEPROM). 1.2A: active after 10 ms; 1.6A: after a power cycle (D33).
    #[doc(alias = "Assign_Drive_ID")]
    AssignDriveId(StoredDriveId),
    /// Reads the drive id.
    #[doc(alias = "Read_Drive_ID")]
    ReadDriveId,
    /// Writes the configuration byte (EEPROM).
    #[doc(alias = "Set_Drive_Config")]
    SetDriveConfig(DriveConfig),
    /// Reads the configuration byte.
    #[doc(alias = "Read_Drive_Config")]
    ReadDriveConfig,
    /// Reads the status byte.
    #[doc(alias = "Read_Drive_Status")]
    ReadDriveStatus,
    /// Turns at constant speed. 1.6A: the drive switches itself to speed mode, and the way back is not stated (D41).
    #[doc(alias = "Turn_ConstSpeed")]
    TurnConstSpeed(SpeedRpm),
    /// Amplitude of the built-in square wave.
    #[doc(alias = "Square_Wave")]
    SquareWave(Amplitude),
    /// Amplitude of the built-in sine wave.
    #[doc(alias = "Sin_Wave")]
    SinWave(Amplitude),
    /// Frequency of the built-in waves.
    #[doc(alias = "SS_Frequency")]
    SsFrequency(FrequencyHz),
    /// Reads position or torque; the reply does not say which (D31).
    #[doc(alias = "General_Read")]
    GeneralRead(ReadSelector),
    /// Writes gains and torque filter (EEPROM).
    #[doc(alias = "Set_Param_Group1")]
    SetParamGroup1(SetParamGroup1),
    /// Writes max speed and max acceleration.
    #[doc(alias = "Set_Param_Group2")]
    SetParamGroup2(SetParamGroup2),
    /// Writes on-position range, gear and line number (EEPROM).
    #[doc(alias = "Set_Param_Group3")]
    SetParamGroup3(SetParamGroup3),
    /// Reads gains and torque filter.
    #[doc(alias = "Read_Param_Group1")]
    ReadParamGroup1,
    /// Reads max speed and max acceleration.
    #[doc(alias = "Read_Param_Group2")]
    ReadParamGroup2,
    /// Reads on-position range, gear and line number; the length of the reply tells the revision (D62).
    #[doc(alias = "Read_Param_Group3")]
    ReadParamGroup3,
    /// Loads an absolute move for Sync_Trigger.
    #[doc(alias = "Go_Absolute_Pos_Sync")]
    GoAbsolutePosSync(Counts28),
    /// Loads a relative move for Sync_Trigger.
    #[doc(alias = "Go_Relative_Pos_Sync")]
    GoRelativePosSync(Counts28),
    /// Starts the loaded moves.
    #[doc(alias = "Sync_Trigger")]
    SyncTrigger(SyncKind),
    /// Enables or disables the servo.
    #[doc(alias = "Servo_Disable")]
    ServoDisable(ServoSwitch),
    /// Reads the motor speed.
    #[doc(alias = "Read_Motor_Speed")]
    ReadMotorSpeed,
    /// Clears a fault and resets the absolute position, 1.6A only (D36, D37).
    #[doc(alias = "Drive_Reset")]
    DriveReset,
    /// Moves by a step at once, without a speed profile: the streamed set-point.
    #[doc(alias = "Go_Relative_Pos_PD")]
    GoRelativePosPd(PdStep),
    /// Asks for the same four bytes back.
    #[doc(alias = "Echo_Function")]
    EchoFunction([u8; 4]),
    /// Reads a counter that counts its own reads.
    #[doc(alias = "Diagnostic_counter")]
    DiagnosticCounter,
}

/// The frame of one streamed set-point; the hot path, which cannot fail.
///
/// The same frame as [`Request::GoRelativePosPd`] makes.
#[doc(alias = "Go_Relative_Pos_PD")]
#[must_use]
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
        let number = |value: i32| number::encode(value, dialect.number_order);
        match *self {
            Self::SetOrigin => match dialect.set_origin {
                SetOriginData::Magic(magic) => Payload::one(magic),
                SetOriginData::Empty => Payload::EMPTY,
            },
            Self::GoAbsolutePosPtp(counts)
            | Self::MakeLinearLine(counts)
            | Self::GoRelativePosPtp(counts)
            | Self::MakeCircularArc(counts)
            | Self::GoAbsolutePosSync(counts)
            | Self::GoRelativePosSync(counts) => number(counts.get()),
            Self::TurnConstSpeed(speed) => number(i32::from(speed.get())),
            Self::SquareWave(amplitude) | Self::SinWave(amplitude) => {
                number(i32::from(amplitude.get()))
            }
            Self::GoRelativePosPd(step) => number(i32::from(step.get())),
            Self::AssignDriveId(id) => Payload::one(id.get()),
            Self::SetDriveConfig(config) => Payload::one(config.to_byte()),
            Self::SsFrequency(frequency) => Payload::one(frequency.get()),
            Self::GeneralRead(selector) => selector.payload(),
            Self::SetParamGroup1(group) => group.payload(),
            Self::SetParamGroup2(group) => group.payload(),
            Self::SetParamGroup3(group) => group.payload(dialect.group3_request_order),
            Self::SyncTrigger(kind) => kind.payload(),
            Self::ServoDisable(switch) => switch.payload(),
            Self::DriveReset => selectors::drive_reset_payload(),
            Self::EchoFunction(bytes) => Payload::from_word(bytes, 4),
            Self::ReadDriveId
            | Self::ReadDriveConfig
            | Self::ReadDriveStatus
            | Self::ReadParamGroup1
            | Self::ReadParamGroup2
            | Self::ReadParamGroup3
            | Self::ReadMotorSpeed
            | Self::DiagnosticCounter => dialect.read_dummy.map_or(Payload::EMPTY, Payload::one),
        }
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
        let number = |max_len| {
            number::decode_checked(
                frame,
                (1, max_len),
                dialect.number_order,
                dialect.strict_minimal,
            )
        };
        let read = |request| expect_read(frame, dialect).map(|()| request);
        match function {
            FunctionCode::SetOrigin => decode_set_origin(frame, dialect),
            FunctionCode::GoAbsolutePosPtp => {
                Ok(Self::GoAbsolutePosPtp(Counts28::new(number(4)?)?))
            }
            FunctionCode::MakeLinearLine => Ok(Self::MakeLinearLine(Counts28::new(number(4)?)?)),
            FunctionCode::GoRelativePosPtp => {
                Ok(Self::GoRelativePosPtp(Counts28::new(number(4)?)?))
            }
            FunctionCode::MakeCircularArc => Ok(Self::MakeCircularArc(Counts28::new(number(4)?)?)),
            FunctionCode::AssignDriveId => Ok(Self::AssignDriveId(StoredDriveId::decode_assigned(
                frame, dialect,
            )?)),
            FunctionCode::ReadDriveId => read(Self::ReadDriveId),
            FunctionCode::SetDriveConfig => Ok(Self::SetDriveConfig(DriveConfig::from_byte(
                one_byte(frame)?,
            )?)),
            FunctionCode::ReadDriveConfig => read(Self::ReadDriveConfig),
            FunctionCode::ReadDriveStatus => read(Self::ReadDriveStatus),
            FunctionCode::TurnConstSpeed => Ok(Self::TurnConstSpeed(SpeedRpm::new(number(2)?)?)),
            FunctionCode::SquareWave => Ok(Self::SquareWave(Amplitude::new(number(3)?)?)),
            FunctionCode::SinWave => Ok(Self::SinWave(Amplitude::new(number(3)?)?)),
            FunctionCode::SsFrequency => Ok(Self::SsFrequency(FrequencyHz::new(i32::from(
                one_byte(frame)?,
            ))?)),
            FunctionCode::GeneralRead => Ok(Self::GeneralRead(ReadSelector::decode(frame)?)),
            FunctionCode::SetParamGroup1 => {
                Ok(Self::SetParamGroup1(SetParamGroup1::decode(frame)?))
            }
            FunctionCode::SetParamGroup2 => {
                Ok(Self::SetParamGroup2(SetParamGroup2::decode(frame)?))
            }
            FunctionCode::SetParamGroup3 => {
                let order = dialect.group3_request_order;
                Ok(Self::SetParamGroup3(SetParamGroup3::decode(frame, order)?))
            }
            FunctionCode::ReadParamGroup1 => read(Self::ReadParamGroup1),
            FunctionCode::ReadParamGroup2 => read(Self::ReadParamGroup2),
            FunctionCode::ReadParamGroup3 => read(Self::ReadParamGroup3),
            FunctionCode::GoAbsolutePosSync => {
                Ok(Self::GoAbsolutePosSync(Counts28::new(number(4)?)?))
            }
            FunctionCode::GoRelativePosSync => {
                Ok(Self::GoRelativePosSync(Counts28::new(number(4)?)?))
            }
            FunctionCode::SyncTrigger => Ok(Self::SyncTrigger(SyncKind::decode(frame)?)),
            FunctionCode::ServoDisable => Ok(Self::ServoDisable(ServoSwitch::decode(frame)?)),
            FunctionCode::ReadMotorSpeed => read(Self::ReadMotorSpeed),
            FunctionCode::DriveReset => decode_drive_reset(frame).map(|()| Self::DriveReset),
            FunctionCode::GoRelativePosPd => Ok(Self::GoRelativePosPd(PdStep::new(number(2)?)?)),
            FunctionCode::EchoFunction => {
                expect_len(frame, 4, 4)?;
                Ok(Self::EchoFunction(first_word(frame)))
            }
            FunctionCode::DiagnosticCounter => read(Self::DiagnosticCounter),
            FunctionCode::ForMotorDefine => Err(Refusal::Factory.into()),
            FunctionCode::DriveError => Err(Refusal::DriveOnly.into()),
        }
    }
}

fn decode_set_origin(frame: &DataFrame, dialect: &Dialect) -> Result<Request, DecodeError> {
    match dialect.set_origin {
        SetOriginData::Magic(magic) => selectors::expect_magic(frame, magic)?,
        SetOriginData::Empty => expect_len(frame, 0, 0)?,
    }
    Ok(Request::SetOrigin)
}

/// A request without arguments: no data, or one byte of any value where the dialect has a dummy (D11).
fn expect_read(frame: &DataFrame, dialect: &Dialect) -> Result<(), DecodeError> {
    expect_len(frame, 0, u8::from(dialect.read_dummy.is_some()))
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
