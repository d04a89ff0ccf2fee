//! Status byte of Read_Drive_Status (1.6A section 6, #9) and of Is_Status (DYN2 manual A1.8 section 7.3).

use crate::alarm::Alarm;

/// Bit 0: outside the on-position range, or busy.
const OFF_POSITION: u8 = 1;
/// Bit 1: servo disabled, motor free.
const SERVO_DISABLED: u8 = 1 << 1;
/// Bits 4..2: alarm code.
const ALARM_SHIFT: u8 = 2;
/// Bit 5: a built-in motion runs.
const MOTION_BUSY: u8 = 1 << 5;

/// The status byte as the drive sent it; bits 7 and 6 are kept.
///
/// On CAN they mean nothing. The serial protocol has seven bits, and bit 6 is the level of a pin that the manual describes in two
/// ways (D50).
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
    fn parts_make_the_byte() {
        let status = DriveStatus::new(false, true, Alarm::LostPhase, false);
        assert_eq!(status.to_byte(), 0x07);
    }

    #[test]
    fn each_bit_is_read_for_itself() {
        let read = |byte| {
            let status = DriveStatus::from_byte(byte);
            (
                status.on_position(),
                status.is_disabled(),
                status.motion_busy(),
            )
        };
        assert_eq!(read(0x00), (true, false, false));
        assert_eq!(read(0x01), (false, false, false));
        assert_eq!(read(0x02), (true, true, false));
        assert_eq!(read(0x20), (true, false, true));
        // All others are none of them.
        assert_eq!(read(0xDC), (true, false, false));
    }
}
