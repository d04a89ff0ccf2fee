//! Configuration byte: Set_Drive_Config and Read_Drive_Config (1.6A section 6, #7 and #8), Is_Config (DYN2 manual A1.8 section 7.3).

use crate::quantity::{Quantity, RangeError};

/// Bits 1..0: command input mode.
const COMMAND_MODE: u8 = 0b11;
/// Bit 2: absolute mode.
const ABSOLUTE: u8 = 1 << 2;
/// Bits 4..3: servo mode.
const SERVO_MODE_SHIFT: u8 = 3;
/// Bit 5: servo free.
const SERVO_FREE: u8 = 1 << 5;

/// Where the drive takes motion commands from. There is no value for CAN: motion over CAN needs RS232 mode (D45).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CommandMode {
    /// 0: RS232, the only mode in which commands over a link move the motor (manual section 4.4).
    Rs232 = 0,
    /// 1: CW and CCW pulses.
    CwCcw = 1,
    /// 2: pulse and direction.
    PulseDirection = 2,
    /// 3: analog.
    Analog = 3,
}

impl CommandMode {
    /// The mode of a code.
    ///
    /// # Errors
    /// [`RangeError`] outside 0 ..= 3.
    pub const fn new(code: i32) -> Result<Self, RangeError> {
        match Quantity::CommandMode.check(code) {
            Ok(code) => Ok(Self::from_bits(code as u8)),
            Err(error) => Err(error),
        }
    }

    const fn from_bits(bits: u8) -> Self {
        match bits & COMMAND_MODE {
            0 => Self::Rs232,
            1 => Self::CwCcw,
            2 => Self::PulseDirection,
            _ => Self::Analog,
        }
    }
}

/// What the servo loop controls. Set-points by Go_Relative_Pos_PD need position mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ServoMode {
    /// 0: position.
    Position = 0,
    /// 1: speed.
    Speed = 1,
    /// 2: torque.
    Torque = 2,
}

impl ServoMode {
    /// The mode of a code.
    ///
    /// # Errors
    /// [`RangeError`] outside 0 ..= 2; 3 is undefined (DYN2 manual A1.8 section 7).
    pub const fn new(code: i32) -> Result<Self, RangeError> {
        match code {
            0 => Ok(Self::Position),
            1 => Ok(Self::Speed),
            2 => Ok(Self::Torque),
            _ => Err(RangeError {
                quantity: Quantity::ServoMode,
                actual: code,
            }),
        }
    }
}

/// A configuration that may be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DriveConfig {
    /// Bits 1..0.
    pub command_mode: CommandMode,
    /// Bit 2: at power-up the motor moves to the stored zero.
    pub absolute_mode: bool,
    /// Bits 4..3.
    pub servo_mode: ServoMode,
    /// Bit 5: servo free; each write wears the EEPROM. CAN has Servo_Disable instead, the serial line has no other way.
    pub servo_free: bool,
}

impl DriveConfig {
    /// The byte on the wire.
    #[must_use]
    pub const fn to_byte(self) -> u8 {
        let mut byte = self.command_mode as u8 | (self.servo_mode as u8) << SERVO_MODE_SHIFT;
        if self.absolute_mode {
            byte |= ABSOLUTE;
        }
        if self.servo_free {
            byte |= SERVO_FREE;
        }
        byte
    }

    /// The configuration that a byte asks a drive to store.
    ///
    /// # Errors
    /// [`RangeError`] when bit 7 or 6 is set or the servo mode is undefined.
    pub const fn from_byte(byte: u8) -> Result<Self, RangeError> {
        if let Err(error) = Quantity::ConfigByte.check(byte as i32) {
            return Err(error);
        }
        ConfigByte::from_byte(byte).config()
    }
}

/// The configuration byte as a drive reports it; bits 7 and 6 mean nothing and are kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ConfigByte(u8);

impl ConfigByte {
    /// A configuration byte as received.
    #[must_use]
    pub const fn from_byte(byte: u8) -> Self {
        Self(byte)
    }

    /// The byte on the wire.
    #[must_use]
    pub const fn to_byte(self) -> u8 {
        self.0
    }

    /// Bits 1..0.
    #[must_use]
    pub const fn command_mode(self) -> CommandMode {
        CommandMode::from_bits(self.0)
    }

    /// Bit 2.
    #[must_use]
    pub const fn absolute_mode(self) -> bool {
        self.0 & ABSOLUTE != 0
    }

    /// Bits 4..3 as a number, 0 ..= 3; 3 is undefined.
    #[must_use]
    pub const fn servo_mode_code(self) -> u8 {
        self.0 >> SERVO_MODE_SHIFT & 0b11
    }

    /// Bit 5.
    #[must_use]
    pub const fn servo_free(self) -> bool {
        self.0 & SERVO_FREE != 0
    }

    /// The configuration without the meaningless bits.
    ///
    /// # Errors
    /// [`RangeError`] when the servo mode is 3.
    pub const fn config(self) -> Result<DriveConfig, RangeError> {
        match ServoMode::new(self.servo_mode_code() as i32) {
            Ok(servo_mode) => Ok(DriveConfig {
                command_mode: self.command_mode(),
                absolute_mode: self.absolute_mode(),
                servo_mode,
                servo_free: self.servo_free(),
            }),
            Err(error) => Err(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_as_printed() {
        let config = DriveConfig {
            command_mode: CommandMode::PulseDirection,
            absolute_mode: true,
            servo_mode: ServoMode::Torque,
            servo_free: true,
        };
        assert_eq!(config.to_byte(), 0x36);
        assert_eq!(DriveConfig::from_byte(0x36), Ok(config));
    }

    #[test]
    fn undefined_bits_are_refused_on_write_and_ignored_on_read() {
        assert!(DriveConfig::from_byte(0x40).is_err());
        assert!(DriveConfig::from_byte(0x18).is_err());
        let read = ConfigByte::from_byte(0xC8);
        assert_eq!(
            read.config().map(|config| config.servo_mode),
            Ok(ServoMode::Speed)
        );
        assert_eq!(ConfigByte::from_byte(0xD8).servo_mode_code(), 3);
        assert!(ConfigByte::from_byte(0xD8).config().is_err());
    }

    #[test]
    fn each_mode_has_its_code() {
        use CommandMode::{Analog, CwCcw, PulseDirection, Rs232};
        for (code, mode) in (0..).zip([Rs232, CwCcw, PulseDirection, Analog]) {
            assert_eq!(CommandMode::new(code), Ok(mode));
        }
        assert!(CommandMode::new(4).is_err());
        for (code, mode) in (0..).zip([ServoMode::Position, ServoMode::Speed, ServoMode::Torque]) {
            assert_eq!(ServoMode::new(code), Ok(mode));
        }
        assert!(ServoMode::new(3).is_err());
    }

    #[test]
    fn each_bit_is_read_for_itself() {
        let read = |byte| {
            let read = ConfigByte::from_byte(byte);
            assert_eq!(read.to_byte(), byte);
            (read.absolute_mode(), read.servo_free())
        };
        assert_eq!(read(0x04), (true, false));
        assert_eq!(read(0x20), (false, true));
        // All others are none of them.
        assert_eq!(read(0xDB), (false, false));
    }

    #[test]
    fn what_may_be_written_is_read_back_as_it_was() {
        let bytes =
            (0..=u8::MAX).filter_map(|byte| DriveConfig::from_byte(byte).ok().zip(Some(byte)));
        // Four command modes, three servo modes, two bits.
        assert_eq!(bytes.clone().count(), 4 * 3 * 4);
        for (config, byte) in bytes {
            assert_eq!(config.to_byte(), byte);
        }
    }
}
