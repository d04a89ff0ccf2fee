//! Configuration byte of Set_Drive_Config and Is_Config (manual section 7.3).

use crate::error::RangeError;
use crate::values::Quantity;

/// Bits 1..0: command input mode.
const COMMAND_MODE: u8 = 0b11;
/// Bit 2: absolute mode.
const ABSOLUTE: u8 = 1 << 2;
/// Bits 4..3: servo mode.
const SERVO_MODE_SHIFT: u8 = 3;
/// Bit 5: servo free.
const SERVO_FREE: u8 = 1 << 5;

/// Where the drive takes motion commands from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum CommandMode {
    /// 0: RS232, the only mode in which this port may move the motor (section 4.4).
    Rs232 = 0,
    /// 1: CW and CCW pulses.
    CwCcw = 1,
    /// 2: pulse and direction.
    PulseDirection = 2,
    /// 3: analog.
    Analog = 3,
}

/// What the servo loop controls.
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

/// A configuration that the manual defines.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct DriveConfig {
    /// Bits 1..0.
    pub command_mode: CommandMode,
    /// Bit 2: at power-up the motor moves to the stored zero.
    pub absolute_mode: bool,
    /// Bits 4..3.
    pub servo_mode: ServoMode,
    /// Bit 5: servo free. Serial has no other way to disable the servo, and each write wears the EEPROM.
    pub servo_free: bool,
}

impl DriveConfig {
    /// The byte, with the undefined bit 6 clear.
    #[must_use]
    pub const fn byte(self) -> ConfigByte {
        let mut byte = self.command_mode as u8 | (self.servo_mode as u8) << SERVO_MODE_SHIFT;
        if self.absolute_mode {
            byte |= ABSOLUTE;
        }
        if self.servo_free {
            byte |= SERVO_FREE;
        }
        ConfigByte(byte)
    }
}

/// The seven bits of the configuration byte, undefined ones included.
///
/// Write a [`DriveConfig`] where you can: this type also holds what the manual leaves undefined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ConfigByte(u8);

impl ConfigByte {
    /// Checks that the byte has seven bits.
    ///
    /// # Errors
    /// [`RangeError`] outside 0 ..= 127.
    pub const fn new(value: i32) -> Result<Self, RangeError> {
        match Quantity::ConfigByte.check(value) {
            Ok(value) => Ok(Self(value as u8)),
            Err(error) => Err(error),
        }
    }

    /// The number, 0 ..= 127.
    #[must_use]
    pub const fn get(self) -> u8 {
        self.0
    }

    /// The configuration without the undefined bit 6.
    ///
    /// # Errors
    /// [`RangeError`] when the servo mode is 3, which is undefined.
    pub const fn config(self) -> Result<DriveConfig, RangeError> {
        let servo_mode = match self.0 >> SERVO_MODE_SHIFT & 0b11 {
            0 => ServoMode::Position,
            1 => ServoMode::Speed,
            2 => ServoMode::Torque,
            code => {
                return Err(RangeError {
                    quantity: Quantity::ServoMode,
                    actual: code as i32,
                });
            }
        };
        Ok(DriveConfig {
            command_mode: match self.0 & COMMAND_MODE {
                0 => CommandMode::Rs232,
                1 => CommandMode::CwCcw,
                2 => CommandMode::PulseDirection,
                _ => CommandMode::Analog,
            },
            absolute_mode: self.0 & ABSOLUTE != 0,
            servo_mode,
            servo_free: self.0 & SERVO_FREE != 0,
        })
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
        assert_eq!(config.byte().get(), 0x36);
        assert_eq!(config.byte().config(), Ok(config));
    }

    #[test]
    fn undefined_servo_mode_is_refused_and_bit_6_ignored() {
        assert!(ConfigByte::new(0x18).unwrap().config().is_err());
        let read = ConfigByte::new(0x48).unwrap().config();
        assert_eq!(read.map(|config| config.servo_mode), Ok(ServoMode::Speed));
        assert!(ConfigByte::new(0x80).is_err());
    }
}
