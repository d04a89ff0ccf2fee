//! Status byte of Is_Status (manual section 7.3).

use core::fmt;

/// Bit 0: outside the on-position range, or busy.
const OFF_POSITION: u8 = 1 << 0;
/// Bit 1: servo disabled, motor free.
const SERVO_FREE: u8 = 1 << 1;
/// Bits 4..2: alarm code.
const ALARM_SHIFT: u8 = 2;
/// Bit 5: a built-in motion runs.
const MOTION_BUSY: u8 = 1 << 5;
/// All bits of the byte.
const SEVEN_BITS: u8 = 0x7F;

/// The seven bits of the status byte; bit 6 is the level of a pin that the manual describes in two ways (D50).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DriveStatus(u8);

impl DriveStatus {
    /// The lower seven bits of a byte as a status.
    #[must_use]
    pub const fn from_byte(byte: u8) -> Self {
        Self(byte & SEVEN_BITS)
    }

    /// The number, 0 ..= 127.
    #[must_use]
    pub const fn to_byte(self) -> u8 {
        self.0
    }

    /// The position error is within the on-position range.
    #[must_use]
    pub const fn on_position(self) -> bool {
        self.0 & OFF_POSITION == 0
    }

    /// The servo is disabled and the motor is free.
    #[must_use]
    pub const fn is_free(self) -> bool {
        self.0 & SERVO_FREE != 0
    }

    /// The alarm; anything but [`Alarm::None`] is a fault, documented or not (D48).
    #[must_use]
    pub const fn alarm(self) -> Alarm {
        match self.0 >> ALARM_SHIFT & 0b111 {
            0 => Alarm::None,
            1 => Alarm::LostPhase,
            2 => Alarm::OverCurrent,
            3 => Alarm::OverheatOrOverpower,
            4 => Alarm::Checksum,
            code => Alarm::Unknown(code),
        }
    }

    /// A built-in S-curve, linear or circular motion runs.
    #[must_use]
    pub const fn motion_busy(self) -> bool {
        self.0 & MOTION_BUSY != 0
    }
}

/// Alarm code in bits 4..2 of the status byte.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Alarm {
    /// No alarm.
    None,
    /// 1: the motor lost phase, the position error is too large.
    LostPhase,
    /// 2: over-current.
    OverCurrent,
    /// 3: overheat or over-power.
    OverheatOrOverpower,
    /// 4: wrong checksum, the command was refused.
    Checksum,
    /// 5 ..= 7: not documented; 5 is probably over-voltage (D48).
    Unknown(u8),
}

impl fmt::Display for Alarm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "no alarm",
            Self::LostPhase => "lost phase",
            Self::OverCurrent => "over-current",
            Self::OverheatOrOverpower => "overheat or over-power",
            Self::Checksum => "wrong checksum, command refused",
            Self::Unknown(code) => return write!(f, "undocumented alarm {code}"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_as_printed() {
        let status = DriveStatus::from_byte(0xA1);
        assert_eq!(status.to_byte(), 0x21);
        assert!(!status.on_position() && !status.is_free() && status.motion_busy());
        assert_eq!(status.alarm(), Alarm::None);
        let status = DriveStatus::from_byte(0x4A);
        assert!(status.on_position() && status.is_free());
        assert_eq!(status.alarm(), Alarm::OverCurrent);
    }

    #[test]
    fn undocumented_alarms_survive() {
        assert_eq!(DriveStatus::from_byte(5 << 2).alarm(), Alarm::Unknown(5));
        assert_eq!(DriveStatus::from_byte(7 << 2).alarm(), Alarm::Unknown(7));
    }
}
