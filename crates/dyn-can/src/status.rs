//! Status byte of Read_Drive_Status (1.6A section 6, #9).

use core::fmt;

/// Bit 0: outside the on-position range, or busy.
const OFF_POSITION: u8 = 1 << 0;
/// Bit 1: servo disabled, motor free.
const SERVO_DISABLED: u8 = 1 << 1;
/// Bits 4..2: alarm code.
const ALARM_SHIFT: u8 = 2;
/// Bit 5: a built-in motion runs.
const MOTION_BUSY: u8 = 1 << 5;

/// The status byte as the drive sent it; bits 7 and 6 mean nothing and are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DriveStatus(u8);

impl DriveStatus {
    /// A status byte as received.
    #[must_use]
    pub const fn from_byte(byte: u8) -> Self {
        Self(byte)
    }

    /// A status byte made of its parts, for a simulated drive.
    #[must_use]
    pub const fn new(on_position: bool, disabled: bool, alarm: Alarm, motion_busy: bool) -> Self {
        let mut byte = alarm.code() << ALARM_SHIFT;
        if !on_position {
            byte |= OFF_POSITION;
        }
        if disabled {
            byte |= SERVO_DISABLED;
        }
        if motion_busy {
            byte |= MOTION_BUSY;
        }
        Self(byte)
    }

    /// The byte on the wire.
    #[must_use]
    pub const fn to_byte(self) -> u8 {
        self.0
    }

    /// The position error is within the on-position range (absolute value, D46).
    #[must_use]
    pub const fn on_position(self) -> bool {
        self.0 & OFF_POSITION == 0
    }

    /// The servo is disabled and the motor is free.
    #[must_use]
    pub const fn is_disabled(self) -> bool {
        self.0 & SERVO_DISABLED != 0
    }

    /// The alarm; anything but [`Alarm::None`] is a fault, documented or not (D48).
    #[must_use]
    pub const fn alarm(self) -> Alarm {
        Alarm::from_code(self.0 >> ALARM_SHIFT)
    }

    /// A built-in S-curve motion runs (in 1.2A also a linear or circular one).
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
    /// 1: the motor lost phase, the position error is too large (D47).
    LostPhase,
    /// 2: over-current.
    OverCurrent,
    /// 3: overheat or over-power.
    OverheatOrOverpower,
    /// 4: a command was refused; called a CRC error in the documents (D49).
    CommandRefused,
    /// 5 ..= 7: not documented; 5 is probably over-voltage (D48).
    Unknown(UnknownAlarm),
}

/// An alarm code that the documents do not list: 5, 6 or 7.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum UnknownAlarm {
    /// Code 5.
    Code5,
    /// Code 6.
    Code6,
    /// Code 7.
    Code7,
}

impl Alarm {
    /// The alarm in the lower three bits.
    #[must_use]
    pub const fn from_code(code: u8) -> Self {
        match code & 0b111 {
            0 => Self::None,
            1 => Self::LostPhase,
            2 => Self::OverCurrent,
            3 => Self::OverheatOrOverpower,
            4 => Self::CommandRefused,
            5 => Self::Unknown(UnknownAlarm::Code5),
            6 => Self::Unknown(UnknownAlarm::Code6),
            _ => Self::Unknown(UnknownAlarm::Code7),
        }
    }

    /// The code, 0 ..= 7.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::None => 0,
            Self::LostPhase => 1,
            Self::OverCurrent => 2,
            Self::OverheatOrOverpower => 3,
            Self::CommandRefused => 4,
            Self::Unknown(UnknownAlarm::Code5) => 5,
            Self::Unknown(UnknownAlarm::Code6) => 6,
            Self::Unknown(UnknownAlarm::Code7) => 7,
        }
    }

    /// Any code but 0.
    #[must_use]
    pub const fn is_alarm(self) -> bool {
        !matches!(self, Self::None)
    }
}

impl fmt::Display for Alarm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::None => "no alarm",
            Self::LostPhase => "lost phase",
            Self::OverCurrent => "over-current",
            Self::OverheatOrOverpower => "overheat or over-power",
            Self::CommandRefused => "command refused",
            Self::Unknown(_) => return write!(f, "undocumented alarm {}", self.code()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_as_printed() {
        let status = DriveStatus::from_byte(0x21);
        assert!(!status.on_position());
        assert!(!status.is_disabled());
        assert_eq!(status.alarm(), Alarm::None);
        assert!(status.motion_busy());

        let status = DriveStatus::from_byte(0x0B);
        assert!(status.is_disabled());
        assert_eq!(status.alarm(), Alarm::OverCurrent);
    }

    #[test]
    fn undocumented_alarm_codes_survive() {
        for code in 0..8 {
            assert_eq!(Alarm::from_code(code).code(), code);
        }
        assert!(Alarm::from_code(7).is_alarm());
    }

    #[test]
    fn parts_make_the_byte() {
        let status = DriveStatus::new(false, true, Alarm::LostPhase, false);
        assert_eq!(status.to_byte(), 0x07);
    }
}
