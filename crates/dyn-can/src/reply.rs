//! Replies: what a drive sends, decoded against the outstanding request.

use can_frame::DataFrame;
use dyn_values::{ConfigByte, Counts28, DriveStatus};

use crate::byte_order::ByteOrder;
use crate::dialect::{Dialect, Rotation, TorqueFullScale};
use crate::error::DecodeError;
use crate::frame::{DynFrame, Payload, compose, expect_len, first_word};
use crate::function::FunctionCode;
use crate::id::Address;
use crate::number::{self, Form};
use crate::parameters::{ParamGroup1, ParamGroup2, ParamGroup3};
use crate::revision::Revision;
use crate::selectors::{DriveError, StoredDriveId};

/// The second message of General_Read: its function code in the lower five bits, as every message here has it, and a mark above them.
const SECOND_OF_GENERAL_READ: u8 = 0x20 | FunctionCode::GeneralRead as u8;

/// What is awaited: one kind for each request that is answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum ReplyKind {
    /// To Read_Drive_ID.
    DriveId = FunctionCode::ReadDriveId as u8,
    /// To Read_Drive_Config.
    DriveConfig = FunctionCode::ReadDriveConfig as u8,
    /// To Read_Drive_Status.
    DriveStatus = FunctionCode::ReadDriveStatus as u8,
    /// To General_Read with 1B.
    Position = FunctionCode::GeneralRead as u8,
    /// To General_Read with 1E.
    Torque = SECOND_OF_GENERAL_READ,
    /// To Read_Param_Group1.
    ParamGroup1 = FunctionCode::ReadParamGroup1 as u8,
    /// To Read_Param_Group2.
    ParamGroup2 = FunctionCode::ReadParamGroup2 as u8,
    /// To Read_Param_Group3.
    ParamGroup3 = FunctionCode::ReadParamGroup3 as u8,
    /// To Read_Motor_Speed.
    MotorSpeed = FunctionCode::ReadMotorSpeed as u8,
    /// To Drive_Reset.
    DriveReset = FunctionCode::DriveReset as u8,
    /// To Echo_Function.
    Echo = FunctionCode::EchoFunction as u8,
    /// To Diagnostic_counter.
    DiagnosticCounter = FunctionCode::DiagnosticCounter as u8,
}

impl ReplyKind {
    /// The function code of the request, which the reply repeats (D5).
    #[must_use]
    pub const fn function(self) -> FunctionCode {
        FunctionCode::from_can_id(self as u16)
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
#[repr(u8)]
pub enum Reply {
    /// The drive id, 0 on a drive that was never given one.
    DriveId(StoredDriveId) = FunctionCode::ReadDriveId as u8,
    /// The configuration byte.
    DriveConfig(ConfigByte) = FunctionCode::ReadDriveConfig as u8,
    /// The status byte.
    DriveStatus(DriveStatus) = FunctionCode::ReadDriveStatus as u8,
    /// The position in the drive's read-back unit, 28 bit unless [`Dialect::accept_beyond_28_bit`]; its scale
    /// against command counts is not stated (D44).
    Position(i32) = FunctionCode::GeneralRead as u8,
    /// The torque.
    Torque(Torque) = SECOND_OF_GENERAL_READ,
    /// Gains and torque filter.
    ParamGroup1(ParamGroup1) = FunctionCode::ReadParamGroup1 as u8,
    /// Max speed and max acceleration.
    ParamGroup2(ParamGroup2) = FunctionCode::ReadParamGroup2 as u8,
    /// On-position range, gear and line number.
    ParamGroup3(ParamGroup3) = FunctionCode::ReadParamGroup3 as u8,
    /// The motor speed in rpm (D26).
    MotorSpeed(i16) = FunctionCode::ReadMotorSpeed as u8,
    /// One byte that no document explains (D35).
    DriveReset(u8) = FunctionCode::DriveReset as u8,
    /// The four bytes of the request.
    Echo([u8; 4]) = FunctionCode::EchoFunction as u8,
    /// Counts its own reads, 255 is followed by 0.
    DiagnosticCounter(u8) = FunctionCode::DiagnosticCounter as u8,
    /// Sent unasked: alarm or data error.
    DriveError(DriveError) = FunctionCode::DriveError as u8,
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
            Self::MotorSpeed(speed_rpm) => {
                number::encode_in(i32::from(speed_rpm), Form::TWO, order)
            }
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
    #[inline]
    pub fn decode(
        frame: &DataFrame,
        outstanding: Option<ReplyKind>,
        dialect: &Dialect,
    ) -> Result<(Address, Self), DecodeError> {
        if outstanding != Some(ReplyKind::Position) {
            return Self::decode_any(frame, outstanding, dialect);
        }
        // The message of every cycle: what is in order is read at once, and what is not is looked at anew for the reason.
        match position_in_order(frame, dialect) {
            Some(counts) => Ok((frame.address(), Self::Position(counts))),
            None => Self::decode_position(frame, dialect),
        }
    }

    /// A frame that may be the position that is awaited, with every check.
    #[cold]
    #[inline(never)]
    fn decode_position(
        frame: &DataFrame,
        dialect: &Dialect,
    ) -> Result<(Address, Self), DecodeError> {
        let function = frame.function();
        let is_position = function == FunctionCode::GeneralRead;
        if !is_position && function != FunctionCode::DriveError {
            function.admit_reply(dialect.revision)?;
            return Err(DecodeError::Unexpected {
                expected: FunctionCode::GeneralRead,
                actual: function,
            });
        }
        expect_len(frame, (1, if is_position { 4 } else { 1 }))?;
        let reply = if is_position {
            Self::Position(position(frame, dialect)?)
        } else {
            Self::drive_error(frame)
        };
        Ok((frame.address(), reply))
    }

    #[inline(never)]
    fn decode_any(
        frame: &DataFrame,
        outstanding: Option<ReplyKind>,
        dialect: &Dialect,
    ) -> Result<(Address, Self), DecodeError> {
        let reply = match kind_of(frame, outstanding, dialect)? {
            Some(kind) => Self::decode_kind(frame, kind, dialect)?,
            None => {
                expect_len(frame, (1, 1))?;
                Self::drive_error(frame)
            }
        };
        Ok((frame.address(), reply))
    }

    /// The first data byte as Drive_Error.
    fn drive_error(frame: &DataFrame) -> Self {
        let [byte, ..] = *frame.bytes();
        Self::DriveError(DriveError::from_byte(byte))
    }

    fn decode_kind(
        frame: &DataFrame,
        kind: ReplyKind,
        dialect: &Dialect,
    ) -> Result<Self, DecodeError> {
        expect_len(frame, lengths(kind, dialect))?;
        let word @ [byte, ..] = first_word(frame);
        Ok(match kind {
            ReplyKind::DriveId => Self::DriveId(StoredDriveId::new(i32::from(byte))?),
            ReplyKind::DriveConfig => Self::DriveConfig(ConfigByte::from_byte(byte)),
            ReplyKind::DriveStatus => Self::DriveStatus(DriveStatus::from_byte(byte)),
            ReplyKind::Position => Self::Position(position(frame, dialect)?),
            // Two bytes at most were checked; a number beyond the scale is a value in doubt and no lost reply.
            ReplyKind::Torque => Self::Torque(Torque {
                raw: number::decode_checked(frame, dialect)? as i16,
                full_scale: dialect.torque_full_scale,
                positive: dialect.positive_torque,
            }),
            ReplyKind::ParamGroup1 => Self::ParamGroup1(ParamGroup1::decode(word)?),
            ReplyKind::ParamGroup2 => Self::ParamGroup2(ParamGroup2::decode(word)?),
            ReplyKind::ParamGroup3 => Self::ParamGroup3(ParamGroup3::decode(frame, dialect)?),
            ReplyKind::MotorSpeed => {
                Self::MotorSpeed(number::decode(frame, dialect.number_order) as i16)
            }
            ReplyKind::DriveReset => Self::DriveReset(byte),
            ReplyKind::Echo => Self::Echo(word),
            ReplyKind::DiagnosticCounter => Self::DiagnosticCounter(byte),
        })
    }
}

/// The kind as which a frame is to be read, `None` for Drive_Error.
fn kind_of(
    frame: &DataFrame,
    outstanding: Option<ReplyKind>,
    dialect: &Dialect,
) -> Result<Option<ReplyKind>, DecodeError> {
    let function = frame.function();
    function.admit_reply(dialect.revision)?;
    if function == FunctionCode::DriveError {
        return Ok(None);
    }
    match outstanding {
        None => ReplyKind::of_function(function).map(Some),
        Some(kind) if kind.function() == function => Ok(Some(kind)),
        Some(kind) => Err(DecodeError::Unexpected {
            expected: kind.function(),
            actual: function,
        }),
    }
}

/// The fewest and the most data bytes of a reply.
const fn lengths(kind: ReplyKind, dialect: &Dialect) -> (u8, u8) {
    match kind {
        ReplyKind::Position => (1, 4),
        ReplyKind::Torque => (1, 2),
        ReplyKind::MotorSpeed | ReplyKind::ParamGroup2 => (2, 2),
        ReplyKind::ParamGroup1 | ReplyKind::Echo => (4, 4),
        ReplyKind::ParamGroup3 => match dialect.revision {
            Revision::V1_2A => (5, 5),
            Revision::V1_6A => (6, 6),
        },
        ReplyKind::DriveId
        | ReplyKind::DriveConfig
        | ReplyKind::DriveStatus
        | ReplyKind::DriveReset
        | ReplyKind::DiagnosticCounter => (1, 1),
    }
}

/// The position of a frame that is a reply to General_Read, of 1 to 4 bytes and within 28 bit, where numbers come in the usual order and
/// of any length; everything else is left to [`Reply::decode_position`].
#[inline]
const fn position_in_order(frame: &DataFrame, dialect: &Dialect) -> Option<i32> {
    // Each is 0 where it is as usual, so that one branch is enough for all.
    let function = (frame.id() ^ FunctionCode::GeneralRead as u16) as u32 & 0x1F;
    let length = (frame.len() as u32).wrapping_sub(1) >> 2;
    let reading = dialect.number_order as u32 | dialect.strict_minimal as u32;
    const { assert!(ByteOrder::MsbFirst as u32 == 0) };
    let counts = number::decode_msb_first(frame);
    let is_in_order = function | length | reading == 0 && counts << 4 >> 4 == counts;
    if is_in_order { Some(counts) } else { None }
}

/// The position in a frame of 1 to 4 bytes.
fn position(frame: &DataFrame, dialect: &Dialect) -> Result<i32, DecodeError> {
    let counts = number::decode_checked(frame, dialect)?;
    if !dialect.accept_beyond_28_bit {
        Counts28::new(counts)?;
    }
    Ok(counts)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

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

    proptest! {
        #[test]
        fn what_is_read_at_once_is_what_every_check_reads(
            drive in 0..0x40_u16,
            other in any::<Option<u8>>(),
            data in prop::collection::vec(any::<u8>(), 0..=8),
            small in any::<bool>(),
            (lsb_first, strict_minimal, accept_beyond_28_bit) in any::<(bool, bool, bool)>(),
        ) {
            let dialect = Dialect {
                number_order: if lsb_first { ByteOrder::LsbFirst } else { ByteOrder::MsbFirst },
                strict_minimal,
                accept_beyond_28_bit,
                ..Dialect::V1_6A
            };
            let function = other.map_or(0x0E, |other| u16::from(other) & 0x1F);
            let mut data = data;
            if let Some(first) = data.first_mut().filter(|_| small) {
                *first = (*first as i8 >> 4) as u8;
            }
            let frame = DataFrame::new(drive << 5 | function, &data).unwrap();
            let checked = Reply::decode_position(&frame, &dialect);
            let at_once = position_in_order(&frame, &dialect).map(Reply::Position);
            if let Some(reply) = at_once {
                prop_assert_eq!(checked, Ok((frame.address(), reply)));
            } else if !lsb_first && !strict_minimal && !accept_beyond_28_bit {
                prop_assert!(!matches!(checked, Ok((_, Reply::Position(_)))));
            }
            let kind = Some(ReplyKind::Position);
            prop_assert_eq!(Reply::decode(&frame, kind, &dialect), checked);
            prop_assert_eq!(Reply::decode_any(&frame, kind, &dialect), checked);
        }
    }
}
