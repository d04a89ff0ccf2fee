//! Replies: what a drive sends, decoded against the outstanding request.

use can_frame::DataFrame;
use dyn_values::{ConfigByte, Counts28, DriveStatus};

use crate::dialect::{Dialect, Rotation, TorqueFullScale};
use crate::error::DecodeError;
use crate::frame::{DynFrame, Payload, compose, expect_len, first_word, one_byte};
use crate::function::FunctionCode;
use crate::id::Address;
use crate::number;
use crate::parameters::{ParamGroup1, ParamGroup2, ParamGroup3};
use crate::selectors::{DriveError, StoredDriveId};

/// What is awaited: one kind for each request that is answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ReplyKind {
    /// To Read_Drive_ID.
    DriveId,
    /// To Read_Drive_Config.
    DriveConfig,
    /// To Read_Drive_Status.
    DriveStatus,
    /// To General_Read with 1B.
    Position,
    /// To General_Read with 1E.
    Torque,
    /// To Read_Param_Group1.
    ParamGroup1,
    /// To Read_Param_Group2.
    ParamGroup2,
    /// To Read_Param_Group3.
    ParamGroup3,
    /// To Read_Motor_Speed.
    MotorSpeed,
    /// To Drive_Reset.
    DriveReset,
    /// To Echo_Function.
    Echo,
    /// To Diagnostic_counter.
    DiagnosticCounter,
}

impl ReplyKind {
    /// The function code of the request, which the reply repeats (D5).
    #[must_use]
    pub const fn function(self) -> FunctionCode {
        match self {
            Self::DriveId => FunctionCode::ReadDriveId,
            Self::DriveConfig => FunctionCode::ReadDriveConfig,
            Self::DriveStatus => FunctionCode::ReadDriveStatus,
            Self::Position | Self::Torque => FunctionCode::GeneralRead,
            Self::ParamGroup1 => FunctionCode::ReadParamGroup1,
            Self::ParamGroup2 => FunctionCode::ReadParamGroup2,
            Self::ParamGroup3 => FunctionCode::ReadParamGroup3,
            Self::MotorSpeed => FunctionCode::ReadMotorSpeed,
            Self::DriveReset => FunctionCode::DriveReset,
            Self::Echo => FunctionCode::EchoFunction,
            Self::DiagnosticCounter => FunctionCode::DiagnosticCounter,
        }
    }

    /// The kind of a function's reply when the outstanding request is not known.
    const fn of_function(function: FunctionCode) -> Result<Self, DecodeError> {
        Ok(match function {
            FunctionCode::ReadDriveId => Self::DriveId,
            FunctionCode::ReadDriveConfig => Self::DriveConfig,
            FunctionCode::ReadDriveStatus => Self::DriveStatus,
            FunctionCode::ReadParamGroup1 => Self::ParamGroup1,
            FunctionCode::ReadParamGroup2 => Self::ParamGroup2,
            FunctionCode::ReadParamGroup3 => Self::ParamGroup3,
            FunctionCode::ReadMotorSpeed => Self::MotorSpeed,
            FunctionCode::DriveReset => Self::DriveReset,
            FunctionCode::EchoFunction => Self::Echo,
            FunctionCode::DiagnosticCounter => Self::DiagnosticCounter,
            _ => return Err(DecodeError::SelectorUnknown),
        })
    }
}

/// Torque as a drive reports it. [`Torque::of_peak`] has its share of the peak current, positive clockwise.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Torque {
    /// The number on the wire.
    pub raw: i16,
    /// The number that stands for the drive's peak current (D28).
    pub full_scale: TorqueFullScale,
    /// The direction in which a positive number turns the shaft (D30).
    pub positive: Rotation,
}

/// A message from a drive (1.6A and 1.2A, section 6).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reply {
    /// The drive id, 0 on a drive that was never given one.
    DriveId(StoredDriveId),
    /// The configuration byte.
    DriveConfig(ConfigByte),
    /// The status byte.
    DriveStatus(DriveStatus),
    /// The position in the drive's read-back unit, 28 bit unless [`Dialect::accept_beyond_28_bit`]; its scale
    /// against command counts is not stated (D44).
    Position(i32),
    /// The torque.
    Torque(Torque),
    /// Gains and torque filter.
    ParamGroup1(ParamGroup1),
    /// Max speed and max acceleration.
    ParamGroup2(ParamGroup2),
    /// On-position range, gear and line number.
    ParamGroup3(ParamGroup3),
    /// The motor speed in rpm (D26).
    MotorSpeed(i16),
    /// One byte that no document explains (D35).
    DriveReset(u8),
    /// The four bytes of the request.
    Echo([u8; 4]),
    /// Counts its own reads, 255 is followed by 0.
    DiagnosticCounter(u8),
    /// Sent unasked: alarm or data error.
    DriveError(DriveError),
}

impl Reply {
    /// The function code.
    #[must_use]
    pub const fn function(&self) -> FunctionCode {
        match self {
            Self::DriveId(_) => FunctionCode::ReadDriveId,
            Self::DriveConfig(_) => FunctionCode::ReadDriveConfig,
            Self::DriveStatus(_) => FunctionCode::ReadDriveStatus,
            Self::Position(_) | Self::Torque(_) => FunctionCode::GeneralRead,
            Self::ParamGroup1(_) => FunctionCode::ReadParamGroup1,
            Self::ParamGroup2(_) => FunctionCode::ReadParamGroup2,
            Self::ParamGroup3(_) => FunctionCode::ReadParamGroup3,
            Self::MotorSpeed(_) => FunctionCode::ReadMotorSpeed,
            Self::DriveReset(_) => FunctionCode::DriveReset,
            Self::Echo(_) => FunctionCode::EchoFunction,
            Self::DiagnosticCounter(_) => FunctionCode::DiagnosticCounter,
            Self::DriveError(_) => FunctionCode::DriveError,
        }
    }

    /// The frame of this reply, for simulated drives. A fresh drive answers on the broadcast identifiers (D2).
    #[must_use]
    pub fn encode(&self, from: Address, dialect: &Dialect) -> DataFrame {
        compose(from, self.function(), self.payload(dialect))
    }

    fn payload(&self, dialect: &Dialect) -> Payload {
        let order = dialect.number_order;
        match *self {
            Self::DriveId(id) => Payload::one(id.get()),
            Self::DriveConfig(config) => Payload::one(config.to_byte()),
            Self::DriveStatus(status) => Payload::one(status.to_byte()),
            Self::Position(counts) => number::encode(counts, order),
            Self::Torque(torque) => number::encode(i32::from(torque.raw), order),
            Self::ParamGroup1(group) => group.payload(),
            Self::ParamGroup2(group) => group.payload(),
            Self::ParamGroup3(group) => group.payload(dialect),
            Self::MotorSpeed(speed_rpm) => number::encode_in(i32::from(speed_rpm), 2, order),
            Self::DriveReset(byte) | Self::DiagnosticCounter(byte) => Payload::one(byte),
            Self::Echo(bytes) => Payload::from_word(bytes, 4),
            Self::DriveError(error) => Payload::one(error.to_byte()),
        }
    }

    /// Reads a frame as a message from a drive.
    ///
    /// With an outstanding request only its reply decodes; Drive_Error decodes at any time. Without one (a bus
    /// monitor that missed the request) everything decodes that does not depend on it.
    ///
    /// # Errors
    /// [`DecodeError`] for everything that this dialect does not allow as a reply, [`DecodeError::Unexpected`] for a
    /// reply to another request, [`DecodeError::SelectorUnknown`] for General_Read without its request (D31).
    pub fn decode(
        frame: &DataFrame,
        outstanding: Option<ReplyKind>,
        dialect: &Dialect,
    ) -> Result<(Address, Self), DecodeError> {
        let function = frame.function();
        function.admit_reply(dialect.revision)?;
        let reply = if function == FunctionCode::DriveError {
            Self::DriveError(DriveError::from_byte(one_byte(frame)?))
        } else {
            Self::decode_kind(frame, awaited(function, outstanding)?, dialect)?
        };
        Ok((frame.address(), reply))
    }

    fn decode_kind(
        frame: &DataFrame,
        kind: ReplyKind,
        dialect: &Dialect,
    ) -> Result<Self, DecodeError> {
        match kind {
            ReplyKind::DriveId => Ok(Self::DriveId(StoredDriveId::decode(frame)?)),
            ReplyKind::DriveConfig => {
                Ok(Self::DriveConfig(ConfigByte::from_byte(one_byte(frame)?)))
            }
            ReplyKind::DriveStatus => {
                Ok(Self::DriveStatus(DriveStatus::from_byte(one_byte(frame)?)))
            }
            ReplyKind::Position => decode_position(frame, dialect).map(Self::Position),
            ReplyKind::Torque => decode_torque(frame, dialect).map(Self::Torque),
            ReplyKind::ParamGroup1 => Ok(Self::ParamGroup1(ParamGroup1::decode(frame)?)),
            ReplyKind::ParamGroup2 => Ok(Self::ParamGroup2(ParamGroup2::decode(frame)?)),
            ReplyKind::ParamGroup3 => Ok(Self::ParamGroup3(ParamGroup3::decode(frame, dialect)?)),
            ReplyKind::MotorSpeed => {
                expect_len(frame, 2, 2)?;
                Ok(Self::MotorSpeed(
                    number::decode(frame, dialect.number_order) as i16,
                ))
            }
            ReplyKind::DriveReset => Ok(Self::DriveReset(one_byte(frame)?)),
            ReplyKind::Echo => {
                expect_len(frame, 4, 4)?;
                Ok(Self::Echo(first_word(frame)))
            }
            ReplyKind::DiagnosticCounter => Ok(Self::DiagnosticCounter(one_byte(frame)?)),
        }
    }
}

fn awaited(
    function: FunctionCode,
    outstanding: Option<ReplyKind>,
) -> Result<ReplyKind, DecodeError> {
    match outstanding {
        None => ReplyKind::of_function(function),
        Some(kind) if kind.function() == function => Ok(kind),
        Some(kind) => Err(DecodeError::Unexpected {
            expected: kind.function(),
            actual: function,
        }),
    }
}

fn decode_position(frame: &DataFrame, dialect: &Dialect) -> Result<i32, DecodeError> {
    let counts =
        number::decode_checked(frame, (1, 4), dialect.number_order, dialect.strict_minimal)?;
    if dialect.accept_beyond_28_bit {
        return Ok(counts);
    }
    Ok(Counts28::new(counts)?.get())
}

fn decode_torque(frame: &DataFrame, dialect: &Dialect) -> Result<Torque, DecodeError> {
    let raw = number::decode_checked(frame, (1, 2), dialect.number_order, dialect.strict_minimal)?;
    // Two bytes at most were checked; a number beyond the scale is a value in doubt and no lost reply.
    Ok(Torque {
        raw: raw as i16,
        full_scale: dialect.torque_full_scale,
        positive: dialect.positive_torque,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::function::Refusal;

    fn decode(data: &[u8], id: u16, kind: Option<ReplyKind>) -> Result<Reply, DecodeError> {
        let frame = DataFrame::new(id, data).unwrap();
        Reply::decode(&frame, kind, &Dialect::V1_6A).map(|(_, reply)| reply)
    }

    #[test]
    fn position_and_torque_share_one_code() {
        // 1.6A section 6, #14: FF63 is -157.
        let torque = Torque {
            raw: -157,
            full_scale: TorqueFullScale::Raw981,
            positive: Rotation::Clockwise,
        };
        assert_eq!(
            decode(&[0xFF, 0x63], 0x0AE, Some(ReplyKind::Torque)),
            Ok(Reply::Torque(torque))
        );
        assert_eq!(
            decode(&[0xFF, 0x63], 0x0AE, Some(ReplyKind::Position)),
            Ok(Reply::Position(-157))
        );
        assert_eq!(
            decode(&[0xFF, 0x63], 0x0AE, None),
            Err(DecodeError::SelectorUnknown)
        );
    }

    #[test]
    fn the_same_torque_turns_the_other_way_in_the_other_revision() {
        // FF63 of 1.6A section 6, #14 is counter-clockwise, and of 1.2A clockwise.
        let frame = DataFrame::new(0x0AE, &[0xFF, 0x63]).unwrap();
        let share = |dialect| match Reply::decode(&frame, Some(ReplyKind::Torque), dialect) {
            Ok((_, Reply::Torque(torque))) => torque.of_peak(),
            other => panic!("{other:?}"),
        };
        assert!((share(&Dialect::V1_6A) + 157.0 / 981.0).abs() < 1e-12);
        assert!((share(&Dialect::V1_2A) - 157.0 / 700.0).abs() < 1e-12);
    }

    #[test]
    fn a_torque_beyond_its_scale_is_a_value_in_doubt() {
        for (data, raw, beyond) in [
            ([0x03, 0xD5], 981, false),
            ([0x03, 0xD6], 982, true),
            ([0xFC, 0x2B], -981, false),
            ([0xFC, 0x2A], -982, true),
            ([0x80, 0x00], i16::MIN, true),
        ] {
            match decode(&data, 0x0AE, Some(ReplyKind::Torque)) {
                Ok(Reply::Torque(torque)) => {
                    assert_eq!((torque.raw, torque.is_beyond_scale()), (raw, beyond));
                }
                other => panic!("{other:?}"),
            }
        }
        assert!(decode(&[0, 0, 0], 0x0AE, Some(ReplyKind::Torque)).is_err());
    }

    #[test]
    fn an_alarm_is_heard_whatever_is_outstanding() {
        let alarm = Ok(Reply::DriveError(DriveError::Alarm));
        assert_eq!(decode(&[0xEE], 0x03D, None), alarm);
        assert_eq!(decode(&[0xEE], 0x03D, Some(ReplyKind::DriveStatus)), alarm);
    }

    #[test]
    fn a_reply_to_another_request_is_not_believed() {
        assert_eq!(
            decode(&[0x01], 0x029, Some(ReplyKind::DiagnosticCounter)),
            Err(DecodeError::Unexpected {
                expected: FunctionCode::DiagnosticCounter,
                actual: FunctionCode::ReadDriveStatus
            })
        );
    }

    #[test]
    fn a_position_beyond_28_bit_needs_permission() {
        let frame = DataFrame::new(0x0AE, &[0x0F, 0xFF, 0xFF, 0xFF]).unwrap();
        let kind = Some(ReplyKind::Position);
        assert!(Reply::decode(&frame, kind, &Dialect::V1_6A).is_err());
        let wide = Dialect {
            accept_beyond_28_bit: true,
            ..Dialect::V1_6A
        };
        let (_, reply) = Reply::decode(&frame, kind, &wide).unwrap();
        assert_eq!(reply, Reply::Position(0x0FFF_FFFF));
    }

    #[test]
    fn functions_without_a_reply_say_so() {
        let function = FunctionCode::SyncTrigger;
        assert_eq!(
            decode(&[0xFF], 0x0B8, None),
            Err(DecodeError::Refused(Refusal::NoReply { function }))
        );
    }
}
