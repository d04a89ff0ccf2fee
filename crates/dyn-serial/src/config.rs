//! Configuration byte of Set_Drive_Config and Is_Config (manual section 7.3).

use dyn_values::{DriveConfig, Quantity, RangeError};

/// The seven bits of the configuration byte, undefined ones included.
///
/// Make it from a [`DriveConfig`] where you can: this type also holds what the manual leaves undefined.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ConfigByte(u8);

impl ConfigByte {
    /// Checks that the byte has seven bits.
    ///
    /// # Errors
    /// [`RangeError`] outside 0 ..= 127.
    pub const fn new(value: i32) -> Result<Self, RangeError> {
        match Quantity::SerialConfigByte.check(value) {
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
        dyn_values::ConfigByte::from_byte(self.0).config()
    }
}

impl From<DriveConfig> for ConfigByte {
    /// The byte, with the undefined bit 6 clear.
    fn from(config: DriveConfig) -> Self {
        Self(config.to_byte())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dyn_values::{CommandMode, ServoMode};

    #[test]
    fn bits_as_printed() {
        let config = DriveConfig {
            command_mode: CommandMode::PulseDirection,
            absolute_mode: true,
            servo_mode: ServoMode::Torque,
            servo_free: true,
        };
        assert_eq!(ConfigByte::from(config).get(), 0x36);
        assert_eq!(ConfigByte::from(config).config(), Ok(config));
    }

    #[test]
    fn undefined_servo_mode_is_refused_and_bit_6_ignored() {
        assert!(ConfigByte::new(0x18).unwrap().config().is_err());
        let read = ConfigByte::new(0x48).unwrap().config();
        assert_eq!(read.map(|config| config.servo_mode), Ok(ServoMode::Speed));
        assert!(ConfigByte::new(0x80).is_err());
    }
}
