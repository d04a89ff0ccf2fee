//! Requests: what a host sends, and what a simulated drive or a line monitor reads (manual sections 7.2.4 and 7.4).

mod decode;

use dyn_values::{
    Amplitude, Counts28, FrequencyHz, GearNumber, IntegrationGain, MainGain, MaxAcceleration,
    MaxSpeed, OnPosRange, Quantity, RangeError, SpeedGain, SpeedRpm, TorqueFilter,
};

use crate::address::{Address, DriveId};
use crate::config::ConfigByte;
use crate::dialect::{Dialect, GeneralId, ParameterForm};
use crate::error::EncodeError;
use crate::function::{ReplyFunction, RequestFunction};
use crate::groups::Groups;
use crate::packet::Packet;

/// What General_Read reads; the selector is the function code of the reply.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum ReadSelector {
    /// 1B: position.
    Position = ReplyFunction::IsAbsPos32 as u8,
    /// 1E: torque.
    Torque = ReplyFunction::IsTrqCurrent as u8,
}

impl ReadSelector {
    /// The selector of a data byte.
    #[must_use]
    pub const fn from_code(code: u8) -> Option<Self> {
        match ReplyFunction::from_code(code) {
            Some(ReplyFunction::IsAbsPos32) => Some(Self::Position),
            Some(ReplyFunction::IsTrqCurrent) => Some(Self::Torque),
            _ => None,
        }
    }
}

/// A request.
///
/// Nothing but a read is answered: a drive does not acknowledge (section 7.1). The discriminants are the function codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[repr(u8)]
pub enum Request {
    /// Makes the present position the absolute zero.
    #[doc(alias = "Set_Origin")]
    SetOrigin = 0x00,
    /// Moves to an absolute position with the built-in S-curve.
    #[doc(alias = "Go_Absolute_Pos")]
    GoAbsolutePos(Counts28) = 0x01,
    /// One word of a coordinated line; see [`LinearMove`](crate::LinearMove).
    #[doc(alias = "Make_LinearLine")]
    MakeLinearLine(Counts28) = 0x02,
    /// Moves by a distance with the built-in S-curve.
    #[doc(alias = "Go_Relative_Pos")]
    GoRelativePos(Counts28) = 0x03,
    /// One word of a coordinated arc; see [`CircularMove`](crate::CircularMove).
    #[doc(alias = "Make_CircularArc")]
    MakeCircularArc(Counts28) = 0x04,
    /// Stores a new drive id (EEPROM). Works only with one drive on the line (section 7.8).
    #[doc(alias = "Assign_Drive_ID")]
    AssignDriveId(DriveId) = 0x05,
    /// Reads the drive id.
    #[doc(alias = "Read_Drive_ID")]
    ReadDriveId = 0x06,
    /// Writes the configuration byte (EEPROM).
    #[doc(alias = "Set_Drive_Config")]
    SetDriveConfig(ConfigByte) = 0x07,
    /// Reads the configuration byte.
    #[doc(alias = "Read_Drive_Config")]
    ReadDriveConfig = 0x08,
    /// Reads the status byte.
    #[doc(alias = "Read_Drive_Status")]
    ReadDriveStatus = 0x09,
    /// Turns at constant speed, 0 stops.
    #[doc(alias = "Turn_ConstSpeed")]
    TurnConstSpeed(SpeedRpm) = 0x0A,
    /// Amplitude of the built-in square wave.
    #[doc(alias = "Square_Wave")]
    SquareWave(Amplitude) = 0x0B,
    /// Amplitude of the built-in sine wave.
    #[doc(alias = "Sin_Wave")]
    SinWave(Amplitude) = 0x0C,
    /// Frequency of the built-in waves.
    #[doc(alias = "SS_Frequency")]
    SsFrequency(FrequencyHz) = 0x0D,
    /// Reads position or torque; unlike on CAN the reply says which.
    #[doc(alias = "General_Read")]
    GeneralRead(ReadSelector) = 0x0E,
    /// Writes the main gain (EEPROM).
    #[doc(alias = "Set_MainGain")]
    SetMainGain(MainGain) = 0x10,
    /// Writes the speed gain (EEPROM).
    #[doc(alias = "Set_SpeedGain")]
    SetSpeedGain(SpeedGain) = 0x11,
    /// Writes the integration gain (EEPROM).
    #[doc(alias = "Set_IntGain")]
    SetIntGain(IntegrationGain) = 0x12,
    /// Writes the torque filter constant (EEPROM).
    #[doc(alias = "Set_TrqCons")]
    SetTrqCons(TorqueFilter) = 0x13,
    /// Writes the max speed parameter (EEPROM).
    #[doc(alias = "Set_HighSpeed")]
    SetHighSpeed(MaxSpeed) = 0x14,
    /// Writes the max acceleration parameter (EEPROM).
    #[doc(alias = "Set_HighAccel")]
    SetHighAccel(MaxAcceleration) = 0x15,
    /// Writes the on-position range (EEPROM); 127 also turns an output into the brake output (D54).
    #[doc(alias = "Set_Pos_OnRange")]
    SetPosOnRange(OnPosRange) = 0x16,
    /// Writes the gear number (EEPROM); 16384 fits only [`ParameterForm::ShortestSigned`] (M13).
    #[doc(alias = "Set_GearNumber")]
    SetGearNumber(GearNumber) = 0x17,
    /// Reads the main gain.
    #[doc(alias = "Read_MainGain")]
    ReadMainGain = 0x18,
    /// Reads the speed gain.
    #[doc(alias = "Read_SpeedGain")]
    ReadSpeedGain = 0x19,
    /// Reads the integration gain.
    #[doc(alias = "Read_IntGain")]
    ReadIntGain = 0x1A,
    /// Reads the torque filter constant.
    #[doc(alias = "Read_TrqCons")]
    ReadTrqCons = 0x1B,
    /// Reads the max speed parameter.
    #[doc(alias = "Read_HighSpeed")]
    ReadHighSpeed = 0x1C,
    /// Reads the max acceleration parameter.
    #[doc(alias = "Read_HighAccel")]
    ReadHighAccel = 0x1D,
    /// Reads the on-position range.
    #[doc(alias = "Read_Pos_OnRange")]
    ReadPosOnRange = 0x1E,
    /// Reads the gear number.
    #[doc(alias = "Read_GearNumber")]
    ReadGearNumber = 0x1F,
}

impl Request {
    /// The function.
    #[must_use]
    pub const fn function(&self) -> RequestFunction {
        use RequestFunction as F;
        match self {
            Self::SetOrigin => F::SetOrigin,
            Self::GoAbsolutePos(_) => F::GoAbsolutePos,
            Self::MakeLinearLine(_) => F::MakeLinearLine,
            Self::GoRelativePos(_) => F::GoRelativePos,
            Self::MakeCircularArc(_) => F::MakeCircularArc,
            Self::AssignDriveId(_) => F::AssignDriveId,
            Self::ReadDriveId => F::ReadDriveId,
            Self::SetDriveConfig(_) => F::SetDriveConfig,
            Self::ReadDriveConfig => F::ReadDriveConfig,
            Self::ReadDriveStatus => F::ReadDriveStatus,
            Self::TurnConstSpeed(_) => F::TurnConstSpeed,
            Self::SquareWave(_) => F::SquareWave,
            Self::SinWave(_) => F::SinWave,
            Self::SsFrequency(_) => F::SsFrequency,
            Self::GeneralRead(_) => F::GeneralRead,
            Self::SetMainGain(_) => F::SetMainGain,
            Self::SetSpeedGain(_) => F::SetSpeedGain,
            Self::SetIntGain(_) => F::SetIntGain,
            Self::SetTrqCons(_) => F::SetTrqCons,
            Self::SetHighSpeed(_) => F::SetHighSpeed,
            Self::SetHighAccel(_) => F::SetHighAccel,
            Self::SetPosOnRange(_) => F::SetPosOnRange,
            Self::SetGearNumber(_) => F::SetGearNumber,
            Self::ReadMainGain => F::ReadMainGain,
            Self::ReadSpeedGain => F::ReadSpeedGain,
            Self::ReadIntGain => F::ReadIntGain,
            Self::ReadTrqCons => F::ReadTrqCons,
            Self::ReadHighSpeed => F::ReadHighSpeed,
            Self::ReadHighAccel => F::ReadHighAccel,
            Self::ReadPosOnRange => F::ReadPosOnRange,
            Self::ReadGearNumber => F::ReadGearNumber,
        }
    }

    /// The function of the reply, `None` for a command, which is not acknowledged.
    #[must_use]
    pub const fn reply_function(&self) -> Option<ReplyFunction> {
        use ReplyFunction as R;
        Some(match self {
            Self::ReadDriveId => R::IsDriveId,
            Self::ReadDriveConfig => R::IsConfig,
            Self::ReadDriveStatus => R::IsStatus,
            Self::GeneralRead(ReadSelector::Position) => R::IsAbsPos32,
            Self::GeneralRead(ReadSelector::Torque) => R::IsTrqCurrent,
            Self::ReadMainGain => R::IsMainGain,
            Self::ReadSpeedGain => R::IsSpeedGain,
            Self::ReadIntGain => R::IsIntGain,
            Self::ReadTrqCons => R::IsTrqCons,
            Self::ReadHighSpeed => R::IsHighSpeed,
            Self::ReadHighAccel => R::IsHighAccel,
            Self::ReadPosOnRange => R::IsPosOnRange,
            Self::ReadGearNumber => R::IsGearNumber,
            _ => return None,
        })
    }

    /// The packet of this request.
    ///
    /// # Errors
    /// [`EncodeError`] for what may not go to every drive, and for a gear number that two bytes cannot carry.
    pub fn encode(&self, to: Address, dialect: &Dialect) -> Result<Packet, EncodeError> {
        if to == Address::All && !self.may_go_to_all(dialect.general_id) {
            let function = self.function();
            return Err(EncodeError::Broadcast { function });
        }
        let data = self.data(dialect).map_err(EncodeError::Range)?;
        Ok(Packet::compose(to, self.function().code(), data))
    }

    fn may_go_to_all(&self, scope: GeneralId) -> bool {
        match self {
            Self::MakeLinearLine(_) | Self::MakeCircularArc(_) => true,
            Self::TurnConstSpeed(SpeedRpm::ZERO)
            | Self::SquareWave(Amplitude::ZERO)
            | Self::SinWave(Amplitude::ZERO) => scope != GeneralId::CoordinatedMoves,
            _ => scope == GeneralId::LoneDrive,
        }
    }

    fn data(&self, dialect: &Dialect) -> Result<Groups, RangeError> {
        // Unsigned numbers have a length, signed ones take the shortest.
        let parameter_len = |table_len| match dialect.parameter_form {
            ParameterForm::Table => Some(table_len),
            ParameterForm::ShortestSigned => None,
        };
        let parameter = |value: u8| (value as i32, parameter_len(1));
        let (value, len) = match *self {
            Self::GoAbsolutePos(counts)
            | Self::MakeLinearLine(counts)
            | Self::GoRelativePos(counts)
            | Self::MakeCircularArc(counts) => (counts.get(), None),
            Self::TurnConstSpeed(speed) => (speed.get() as i32, None),
            Self::SquareWave(amplitude) | Self::SinWave(amplitude) => {
                (amplitude.get() as i32, None)
            }
            Self::SsFrequency(frequency) => (frequency.get() as i32, None),
            Self::AssignDriveId(drive) => (drive.get() as i32, Some(1)),
            Self::SetDriveConfig(config) => (config.get() as i32, Some(1)),
            Self::GeneralRead(selector) => (selector as i32, Some(1)),
            Self::SetMainGain(value) => parameter(value.get()),
            Self::SetSpeedGain(value) => parameter(value.get()),
            Self::SetIntGain(value) => parameter(value.get()),
            Self::SetTrqCons(value) => parameter(value.get()),
            Self::SetHighSpeed(value) => parameter(value.get()),
            Self::SetHighAccel(value) => parameter(value.get()),
            Self::SetPosOnRange(value) => parameter(value.get()),
            Self::SetGearNumber(gear) => {
                let len = parameter_len(2);
                let fits = len.is_none() || gear != GearNumber::MAX;
                if !fits {
                    return Err(RangeError {
                        quantity: Quantity::GearNumberInTwoBytes,
                        actual: gear.get() as i32,
                    });
                }
                (gear.get() as i32, len)
            }
            _ => (dialect.dummy.get() as i32, Some(1)),
        };
        Ok(match len {
            Some(len) => Groups::fixed(value, len),
            None => Groups::signed(value),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::DecodeError;

    const SAMPLE_CODE: Dialect = Dialect {
        parameter_form: ParameterForm::ShortestSigned,
        ..Dialect::MANUAL
    };

    fn drive(id: i32) -> Address {
        Address::Drive(DriveId::new(id).unwrap())
    }

    fn bytes(request: Request, dialect: &Dialect) -> std::vec::Vec<u8> {
        let packet = request.encode(drive(5), dialect).unwrap();
        assert_eq!(Request::decode(&packet, dialect), Ok((drive(5), request)));
        packet.as_bytes().to_vec()
    }

    #[test]
    fn gain_of_64_takes_one_byte_by_the_table_and_two_by_the_sample_code() {
        let gain = Request::SetMainGain(MainGain::new(64).unwrap());
        assert_eq!(bytes(gain, &Dialect::MANUAL), [0x05, 0x90, 0xC0, 0xD5]);
        assert_eq!(bytes(gain, &SAMPLE_CODE), [0x05, 0xB0, 0x80, 0xC0, 0xF5]);
    }

    #[test]
    fn largest_gear_number_fits_only_the_form_of_the_sample_code() {
        let gear = Request::SetGearNumber(GearNumber::MAX);
        assert_eq!(
            gear.encode(drive(1), &Dialect::MANUAL),
            Err(EncodeError::Range(RangeError {
                quantity: Quantity::GearNumberInTwoBytes,
                actual: 16_384
            }))
        );
        assert_eq!(
            bytes(gear, &SAMPLE_CODE),
            [0x05, 0xD7, 0x81, 0x80, 0x80, 0xDD]
        );
    }

    #[test]
    fn what_every_drive_may_hear_grows_with_the_permission() {
        let admitted = |request: Request| {
            [
                GeneralId::CoordinatedMoves,
                GeneralId::Stop,
                GeneralId::LoneDrive,
            ]
            .map(|general_id| {
                let dialect = Dialect {
                    general_id,
                    ..Dialect::MANUAL
                };
                request.encode(Address::All, &dialect).is_ok()
            })
        };
        let counts = Counts28::new(1).unwrap();
        assert_eq!(admitted(Request::MakeLinearLine(counts)), [true; 3]);
        let stop = Request::TurnConstSpeed(SpeedRpm::ZERO);
        assert_eq!(admitted(stop), [false, true, true]);
        let turn = Request::TurnConstSpeed(SpeedRpm::new(1).unwrap());
        assert_eq!(admitted(turn), [false, false, true]);
        assert_eq!(admitted(Request::ReadDriveId), [false, false, true]);
    }

    #[test]
    fn no_request_looks_like_its_own_reply() {
        // A line that carries both directions brings requests back, and a client must not take them for replies.
        for function in RequestFunction::ALL {
            let second = 0x80 | function.code();
            let sum = 0x80 | function.code();
            let Ok(packet) = Packet::parse(&[0, second, 0x80, sum]) else {
                panic!("{function}");
            };
            if let Ok((_, request)) = Request::decode(&packet, &Dialect::MANUAL) {
                let reply = request.reply_function().map(ReplyFunction::code);
                assert_ne!(reply, Some(function.code()), "{function}");
            }
        }
    }

    #[test]
    fn the_factory_code_is_never_a_request() {
        let packet = Packet::parse(&[0x01, 0x8F, 0x80, 0x90]).unwrap();
        assert_eq!(
            Request::decode(&packet, &Dialect::MANUAL),
            Err(DecodeError::Factory)
        );
    }
}
