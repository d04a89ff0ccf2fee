//! Replies: what a drive sends, and what a simulated drive encodes (manual section 7.2.4).

use dyn_values::{
    Counts28, DriveStatus, GearNumber, IntegrationGain, MainGain, MaxAcceleration, MaxSpeed,
    OnPosRange, Quantity, SpeedGain, TorqueFilter,
};

use crate::address::{Address, DriveId};
use crate::config::ConfigByte;
use crate::error::DecodeError;
use crate::function::ReplyFunction;
use crate::groups::Groups;
use crate::packet::Packet;

/// The bits of a byte that a packet carries.
const SEVEN_BITS: u8 = 0x7F;

/// A message from a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Reply {
    /// The main gain.
    MainGain(MainGain),
    /// The speed gain.
    SpeedGain(SpeedGain),
    /// The integration gain.
    IntegrationGain(IntegrationGain),
    /// The torque filter constant.
    TorqueFilter(TorqueFilter),
    /// The max speed parameter.
    MaxSpeed(MaxSpeed),
    /// The max acceleration parameter.
    MaxAcceleration(MaxAcceleration),
    /// The drive id, 0 on a drive that was never given one.
    DriveId(DriveId),
    /// The on-position range.
    OnPosRange(OnPosRange),
    /// The gear number.
    GearNumber(GearNumber),
    /// The status byte, of which the packet carries seven bits.
    Status(DriveStatus),
    /// The configuration byte.
    Config(ConfigByte),
    /// The position; its scale against command counts is not stated (D44).
    Position(Counts28),
    /// The torque, positive clockwise; its full scale differs by drive (section 7.7, example 10).
    Torque(i16),
}

impl Reply {
    /// The function.
    #[must_use]
    pub const fn function(&self) -> ReplyFunction {
        match self {
            Self::MainGain(_) => ReplyFunction::IsMainGain,
            Self::SpeedGain(_) => ReplyFunction::IsSpeedGain,
            Self::IntegrationGain(_) => ReplyFunction::IsIntGain,
            Self::TorqueFilter(_) => ReplyFunction::IsTrqCons,
            Self::MaxSpeed(_) => ReplyFunction::IsHighSpeed,
            Self::MaxAcceleration(_) => ReplyFunction::IsHighAccel,
            Self::DriveId(_) => ReplyFunction::IsDriveId,
            Self::OnPosRange(_) => ReplyFunction::IsPosOnRange,
            Self::GearNumber(_) => ReplyFunction::IsGearNumber,
            Self::Status(_) => ReplyFunction::IsStatus,
            Self::Config(_) => ReplyFunction::IsConfig,
            Self::Position(_) => ReplyFunction::IsAbsPos32,
            Self::Torque(_) => ReplyFunction::IsTrqCurrent,
        }
    }

    /// The packet of this reply, for simulated drives.
    #[must_use]
    pub fn encode(&self, from: DriveId) -> Packet {
        Packet::compose(from.into(), self.function().code(), self.data())
    }

    fn data(&self) -> Groups {
        match *self {
            Self::MainGain(value) => Groups::one(value.get()),
            Self::SpeedGain(value) => Groups::one(value.get()),
            Self::IntegrationGain(value) => Groups::one(value.get()),
            Self::TorqueFilter(value) => Groups::one(value.get()),
            Self::MaxSpeed(value) => Groups::one(value.get()),
            Self::MaxAcceleration(value) => Groups::one(value.get()),
            Self::DriveId(drive) => Groups::one(drive.get()),
            Self::OnPosRange(value) => Groups::one(value.get()),
            // What a drive with the largest gear sends is not known; three bytes are the only form that holds it (M13).
            Self::GearNumber(GearNumber::MAX) => Groups::fixed(GearNumber::MAX.get() as i32, 3),
            Self::GearNumber(gear) => Groups::fixed(gear.get() as i32, 2),
            Self::Status(status) => Groups::one(status.to_byte() & SEVEN_BITS),
            Self::Config(config) => Groups::one(config.get()),
            Self::Position(counts) => Groups::signed(counts.get()),
            Self::Torque(torque) => Groups::signed(torque as i32),
        }
    }

    /// Reads a packet as a message from a drive. One-byte values are unsigned (M11).
    ///
    /// # Errors
    /// [`DecodeError`] for a code that no drive sends, a wrong length, a number out of range, and a reserved or the
    /// general id.
    pub fn decode(packet: &Packet) -> Result<(DriveId, Self), DecodeError> {
        let Address::Drive(from) = Address::from_start_byte(packet.start_byte())? else {
            return Err(DecodeError::ReplyFromAll);
        };
        Ok((from, Self::decode_data(packet)?))
    }

    fn decode_data(packet: &Packet) -> Result<Self, DecodeError> {
        use ReplyFunction as F;
        let code = packet.code();
        let function = F::from_code(code).ok_or(DecodeError::UnknownReply { code })?;
        expect_len(packet, function)?;
        let unsigned = packet.unsigned() as i32;
        Ok(match function {
            F::IsMainGain => Self::MainGain(MainGain::new(unsigned)?),
            F::IsSpeedGain => Self::SpeedGain(SpeedGain::new(unsigned)?),
            F::IsIntGain => Self::IntegrationGain(IntegrationGain::new(unsigned)?),
            F::IsTrqCons => Self::TorqueFilter(TorqueFilter::new(unsigned)?),
            F::IsHighSpeed => Self::MaxSpeed(MaxSpeed::new(unsigned)?),
            F::IsHighAccel => Self::MaxAcceleration(MaxAcceleration::new(unsigned)?),
            F::IsDriveId => Self::DriveId(DriveId::new(unsigned)?),
            F::IsPosOnRange => Self::OnPosRange(OnPosRange::new(unsigned)?),
            F::IsGearNumber => Self::GearNumber(GearNumber::new(unsigned)?),
            F::IsStatus => Self::Status(DriveStatus::from_byte(unsigned as u8)),
            F::IsConfig => Self::Config(ConfigByte::new(unsigned)?),
            F::IsAbsPos32 => Self::Position(Counts28::new(packet.signed())?),
            F::IsTrqCurrent => Self::Torque(Quantity::SerialTorque.check(packet.signed())? as i16),
        })
    }
}

fn expect_len(packet: &Packet, function: ReplyFunction) -> Result<(), DecodeError> {
    let (min, max) = match function {
        ReplyFunction::IsAbsPos32 | ReplyFunction::IsTrqCurrent => (1, 4),
        ReplyFunction::IsGearNumber => (2, 3),
        _ => (1, 1),
    };
    let actual = packet.data_len();
    if actual < min || actual > max {
        return Err(DecodeError::Length {
            function: function.into(),
            min,
            max,
            actual,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use dyn_values::RangeError;

    fn decode(bytes: &[u8]) -> Result<(DriveId, Reply), DecodeError> {
        Reply::decode(&Packet::parse(bytes).unwrap())
    }

    #[test]
    fn a_gain_above_63_is_not_negative() {
        let gain = Reply::MainGain(MainGain::new(100).unwrap());
        let packet = gain.encode(DriveId::FRESH);
        assert_eq!(packet.as_bytes(), [0x00, 0x90, 0xE4, 0xF4]);
        assert_eq!(Reply::decode(&packet), Ok((DriveId::FRESH, gain)));
    }

    #[test]
    fn the_largest_gear_number_survives() {
        let gear = Reply::GearNumber(GearNumber::MAX);
        let packet = gear.encode(DriveId::MAX);
        assert_eq!(Reply::decode(&packet), Ok((DriveId::MAX, gear)));
    }

    #[test]
    fn what_no_drive_sends_is_refused() {
        // Turn_ConstSpeed is a request; 64 is reserved; 127 is every drive.
        assert_eq!(
            decode(&[0x03, 0x8A, 0x85, 0x92]),
            Err(DecodeError::UnknownReply { code: 0x0A })
        );
        let reserved = RangeError {
            quantity: Quantity::SerialDriveId,
            actual: 64,
        };
        assert_eq!(
            decode(&[0x40, 0x99, 0x80, 0xD9]),
            Err(DecodeError::Range(reserved))
        );
        assert_eq!(
            decode(&[0x7F, 0x99, 0x80, 0x98]),
            Err(DecodeError::ReplyFromAll)
        );
    }

    #[test]
    fn a_status_is_sent_as_seven_bits() {
        let from = DriveId::new(3).unwrap();
        let packet = Reply::Status(DriveStatus::from_byte(0xA1)).encode(from);
        let received = Reply::Status(DriveStatus::from_byte(0x21));
        assert_eq!(Reply::decode(&packet), Ok((from, received)));
    }

    #[test]
    fn a_torque_beyond_16_bit_is_refused() {
        // 32768 in three bytes.
        assert!(decode(&[0x01, 0xDE, 0x82, 0x80, 0x80, 0xE1]).is_err());
    }
}
