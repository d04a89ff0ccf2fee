//! Numbers with a range: what a type holds can always be encoded.

use core::fmt;

use crate::error::RangeError;

/// A quantity of the protocol with its limits.
///
/// Sources are sections of the DYN2 manual A1.8. Where the manual prints no range (M23) the limit is that of the CAN
/// specification 1.6A, section 6.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Quantity {
    /// Drive id: 64 ..= 126 are reserved and 127 is every drive (section 7.2.3; D3).
    DriveId,
    /// Position or distance in counts, 28 bit (section 7.2.5).
    Counts28,
    /// Speed of Turn_ConstSpeed in rpm (no range in the manual, M23).
    SpeedRpm,
    /// Amplitude of Square_Wave and Sin_Wave in counts (no range in the manual, M23).
    Amplitude,
    /// Frequency of Square_Wave and Sin_Wave in Hz (no range in the manual, M23).
    FrequencyHz,
    /// Main gain (section 5.1).
    MainGain,
    /// Speed gain (section 5.1).
    SpeedGain,
    /// Integration gain (section 5.1).
    IntegrationGain,
    /// Torque filter constant, printed as torque constant (section 5.1).
    TorqueFilter,
    /// Max speed parameter (section 5.1).
    MaxSpeed,
    /// Max acceleration parameter (section 5.1).
    MaxAcceleration,
    /// On-position range (section 5.1).
    OnPosRange,
    /// Gear number (section 5.1).
    GearNumber,
    /// Gear number as two 7-bit bytes can carry it: 16384 does not fit (M13).
    GearNumberInTwoBytes,
    /// Feed rate of a coordinated move (section 7.7, examples 7 and 8).
    FeedRate,
    /// The byte that a function without data sends (section 7.2.1).
    Dummy,
    /// Configuration byte, 7 bits (section 7.3).
    ConfigByte,
    /// Servo mode in the configuration byte: 3 is undefined (section 7.3).
    ServoMode,
    /// Torque as a drive reports it, 16 bit (section 7.7, example 10; M14).
    Torque,
}

impl Quantity {
    /// Smallest and largest value, both allowed.
    #[must_use]
    pub const fn limits(self) -> (i32, i32) {
        match self {
            Self::DriveId => (0, 63),
            Self::Counts28 => (-(1 << 27), (1 << 27) - 1),
            Self::SpeedRpm => (-20_000, 20_000),
            Self::Amplitude => (0, 4_096),
            Self::FrequencyHz => (0, 50),
            Self::MainGain
            | Self::SpeedGain
            | Self::IntegrationGain
            | Self::TorqueFilter
            | Self::MaxSpeed
            | Self::MaxAcceleration
            | Self::OnPosRange
            | Self::FeedRate => (1, 127),
            Self::GearNumber => (500, 16_384),
            Self::GearNumberInTwoBytes => (500, 16_383),
            Self::Dummy | Self::ConfigByte => (0, 127),
            Self::ServoMode => (0, 2),
            Self::Torque => (-32_768, 32_767),
        }
    }

    /// The value itself when it lies within the limits.
    ///
    /// # Errors
    /// [`RangeError`] with this quantity and the value when it does not.
    pub const fn check(self, actual: i32) -> Result<i32, RangeError> {
        let (min, max) = self.limits();
        if actual < min || actual > max {
            return Err(RangeError {
                quantity: self,
                actual,
            });
        }
        Ok(actual)
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::DriveId => "drive id",
            Self::Counts28 => "position or distance in counts",
            Self::SpeedRpm => "speed in rpm",
            Self::Amplitude => "wave amplitude in counts",
            Self::FrequencyHz => "wave frequency in Hz",
            Self::MainGain => "main gain",
            Self::SpeedGain => "speed gain",
            Self::IntegrationGain => "integration gain",
            Self::TorqueFilter => "torque filter constant",
            Self::MaxSpeed => "max speed parameter",
            Self::MaxAcceleration => "max acceleration parameter",
            Self::OnPosRange => "on-position range",
            Self::GearNumber => "gear number",
            Self::GearNumberInTwoBytes => "gear number in two 7-bit bytes",
            Self::FeedRate => "feed rate",
            Self::Dummy => "dummy byte",
            Self::ConfigByte => "configuration byte",
            Self::ServoMode => "servo mode",
            Self::Torque => "torque",
        })
    }
}

macro_rules! bounded {
    ($($(#[$doc:meta])* $name:ident($repr:ty),)*) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub struct $name($repr);

        impl $name {
            /// The smallest value.
            pub const MIN: Self = Self(Quantity::$name.limits().0 as $repr);
            /// The largest value.
            pub const MAX: Self = Self(Quantity::$name.limits().1 as $repr);

            /// Checks the number against the limits of its quantity.
            ///
            /// # Errors
            /// [`RangeError`] when the number lies outside.
            pub const fn new(value: i32) -> Result<Self, RangeError> {
                match Quantity::$name.check(value) {
                    Ok(value) => Ok(Self(value as $repr)),
                    Err(error) => Err(error),
                }
            }

            /// The number.
            #[must_use]
            pub const fn get(self) -> $repr {
                self.0
            }
        }

        impl TryFrom<i32> for $name {
            type Error = RangeError;

            fn try_from(value: i32) -> Result<Self, RangeError> {
                Self::new(value)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }
    )*};
}

bounded! {
    /// A position or a distance in command counts, -2^27 ..= 2^27 - 1; positive turns clockwise.
    Counts28(i32),
    /// A speed in rpm, -20000 ..= 20000; positive turns clockwise.
    SpeedRpm(i16),
    /// Amplitude of a built-in wave in counts, 0 ..= 4096.
    Amplitude(u16),
    /// Frequency of a built-in wave in Hz, 0 ..= 50; 0 stops it.
    FrequencyHz(u8),
    /// Main gain, 1 ..= 127.
    MainGain(u8),
    /// Speed gain, 1 ..= 127.
    SpeedGain(u8),
    /// Integration gain, 1 ..= 127.
    IntegrationGain(u8),
    /// Torque filter constant, 1 ..= 127.
    TorqueFilter(u8),
    /// Max speed parameter, 1 ..= 127; not rpm.
    MaxSpeed(u8),
    /// Max acceleration parameter, 1 ..= 127; not rpm/s.
    MaxAcceleration(u8),
    /// On-position range, 1 ..= 127. 127 also turns JP3-9 into the brake output (D54).
    OnPosRange(u8),
    /// Gear number, 500 ..= 16384; 4096 is gear ratio 1. 16384 does not fit the two bytes of the table (M13).
    GearNumber(u16),
    /// Feed rate of a coordinated move, 1 ..= 127; its unit is not stated.
    FeedRate(u8),
    /// The byte that a function without data sends, 0 ..= 127.
    Dummy(u8),
}

impl SpeedRpm {
    /// Standstill.
    pub const ZERO: Self = Self(0);
}

impl Amplitude {
    /// No wave.
    pub const ZERO: Self = Self(0);
}

impl OnPosRange {
    /// True for 127, the value that also makes JP3-9 the brake output after the next power cycle (D54).
    #[must_use]
    pub const fn enables_brake_output(self) -> bool {
        self.0 == 127
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_belong_to_the_type_and_the_next_number_does_not() {
        assert_eq!(Counts28::new(-(1 << 27)), Ok(Counts28::MIN));
        assert_eq!(
            Counts28::new(1 << 27),
            Err(RangeError {
                quantity: Quantity::Counts28,
                actual: 1 << 27
            })
        );
        assert!(GearNumber::new(499).is_err() && GearNumber::new(16_385).is_err());
        assert!(FeedRate::new(0).is_err());
    }

    #[test]
    fn numbers_that_would_wrap_into_the_range_are_refused() {
        // 256 + 5 is 5 in eight bits, 65_536 + 1 is 1 in sixteen.
        assert!(MainGain::new(261).is_err());
        assert!(SpeedRpm::new(65_537).is_err());
        assert!(Dummy::new(-1).is_err());
    }
}
