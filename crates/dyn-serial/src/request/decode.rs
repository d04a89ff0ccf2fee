//! Reading a packet as a request, for simulated drives and line monitors.

use dyn_values::{
    Amplitude, Counts28, FrequencyHz, GearNumber, IntegrationGain, MainGain, MaxAcceleration,
    MaxSpeed, OnPosRange, SpeedGain, SpeedRpm, TorqueFilter,
};

use super::{ReadSelector, Request};
use crate::address::{Address, DriveId};
use crate::config::ConfigByte;
use crate::dialect::{Dialect, ParameterForm};
use crate::error::DecodeError;
use crate::function::RequestFunction;
use crate::packet::Packet;

impl Request {
    /// Reads a packet as a request.
    ///
    /// # Errors
    /// [`DecodeError`] for everything that this dialect does not allow as a request.
    pub fn decode(packet: &Packet, dialect: &Dialect) -> Result<(Address, Self), DecodeError> {
        let to = Address::from_start_byte(packet.start_byte())?;
        let request = Self::decode_data(packet, dialect)?;
        if to == Address::All && !request.may_go_to_all(dialect.general_id) {
            let function = request.function();
            return Err(DecodeError::Broadcast { function });
        }
        Ok((to, request))
    }

    fn decode_data(packet: &Packet, dialect: &Dialect) -> Result<Self, DecodeError> {
        use RequestFunction as F;
        // Five bits always are a function.
        let function = F::from_code(packet.code()).unwrap_or(F::ForMotorDefine);
        let numbers = Numbers { packet, function };
        let parameter = |table_len| numbers.parameter(table_len, dialect);
        Ok(match function {
            F::ForMotorDefine => return Err(DecodeError::Factory),
            F::GoAbsolutePos => Self::GoAbsolutePos(numbers.counts()?),
            F::MakeLinearLine => Self::MakeLinearLine(numbers.counts()?),
            F::GoRelativePos => Self::GoRelativePos(numbers.counts()?),
            F::MakeCircularArc => Self::MakeCircularArc(numbers.counts()?),
            F::AssignDriveId => Self::AssignDriveId(DriveId::new(numbers.one_byte()?)?),
            F::SetDriveConfig => Self::SetDriveConfig(ConfigByte::new(numbers.one_byte()?)?),
            F::TurnConstSpeed => Self::TurnConstSpeed(SpeedRpm::new(numbers.signed(3)?)?),
            F::SquareWave => Self::SquareWave(Amplitude::new(numbers.signed(3)?)?),
            F::SinWave => Self::SinWave(Amplitude::new(numbers.signed(3)?)?),
            F::SsFrequency => Self::SsFrequency(FrequencyHz::new(numbers.signed(3)?)?),
            F::GeneralRead => Self::GeneralRead(numbers.selector()?),
            F::SetMainGain => Self::SetMainGain(MainGain::new(parameter(1)?)?),
            F::SetSpeedGain => Self::SetSpeedGain(SpeedGain::new(parameter(1)?)?),
            F::SetIntGain => Self::SetIntGain(IntegrationGain::new(parameter(1)?)?),
            F::SetTrqCons => Self::SetTrqCons(TorqueFilter::new(parameter(1)?)?),
            F::SetHighSpeed => Self::SetHighSpeed(MaxSpeed::new(parameter(1)?)?),
            F::SetHighAccel => Self::SetHighAccel(MaxAcceleration::new(parameter(1)?)?),
            F::SetPosOnRange => Self::SetPosOnRange(OnPosRange::new(parameter(1)?)?),
            F::SetGearNumber => Self::SetGearNumber(GearNumber::new(parameter(2)?)?),
            _ => {
                numbers.one_byte()?;
                Self::without_data(function)
            }
        })
    }

    /// The request of a function that has no data.
    const fn without_data(function: RequestFunction) -> Self {
        use RequestFunction as F;
        match function {
            F::SetOrigin => Self::SetOrigin,
            F::ReadDriveId => Self::ReadDriveId,
            F::ReadDriveConfig => Self::ReadDriveConfig,
            F::ReadMainGain => Self::ReadMainGain,
            F::ReadSpeedGain => Self::ReadSpeedGain,
            F::ReadIntGain => Self::ReadIntGain,
            F::ReadTrqCons => Self::ReadTrqCons,
            F::ReadHighSpeed => Self::ReadHighSpeed,
            F::ReadHighAccel => Self::ReadHighAccel,
            F::ReadPosOnRange => Self::ReadPosOnRange,
            F::ReadGearNumber => Self::ReadGearNumber,
            _ => Self::ReadDriveStatus,
        }
    }
}

/// The data of a request as numbers of the lengths that its function allows.
struct Numbers<'a> {
    packet: &'a Packet,
    function: RequestFunction,
}

impl Numbers<'_> {
    fn expect_len(&self, min: u8, max: u8) -> Result<(), DecodeError> {
        let actual = self.packet.data_len();
        if actual < min || actual > max {
            return Err(DecodeError::Length {
                function: self.function.into(),
                min,
                max,
                actual,
            });
        }
        Ok(())
    }

    fn one_byte(&self) -> Result<i32, DecodeError> {
        self.expect_len(1, 1)?;
        Ok(self.packet.unsigned() as i32)
    }

    fn signed(&self, max: u8) -> Result<i32, DecodeError> {
        self.expect_len(1, max)?;
        Ok(self.packet.signed())
    }

    fn counts(&self) -> Result<Counts28, DecodeError> {
        Ok(Counts28::new(self.packet.signed())?)
    }

    fn selector(&self) -> Result<ReadSelector, DecodeError> {
        let actual = self.one_byte()? as u8;
        ReadSelector::from_code(actual).ok_or(DecodeError::Selector { actual })
    }

    /// A parameter of `table_len` bytes in the table, one more at most where it is sent as a signed number.
    fn parameter(&self, table_len: u8, dialect: &Dialect) -> Result<i32, DecodeError> {
        match dialect.parameter_form {
            ParameterForm::Table => {
                self.expect_len(table_len, table_len)?;
                Ok(self.packet.unsigned() as i32)
            }
            ParameterForm::ShortestSigned => self.signed(table_len + 1),
        }
    }
}
