//! Numbers with a range: what a type holds can always be encoded.

use core::fmt;

use crate::error::RangeError;

/// A quantity of the protocol with the limits that the documents print for it.
///
/// Sources are sections of the CAN specification 1.6A; 1.2A prints the same ranges.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Quantity {
    /// Drive id for addressing (section 4). 0 is broadcast; 64 is printed but needs 7 bits (D1, D2).
    DriveId,
    /// Drive id as a drive reports or stores it: 0 on a drive that was never given one (D2).
    StoredDriveId,
    /// Position or distance in counts, 28 bit (section 4, data range).
    Counts28,
    /// Step of Go_Relative_Pos_PD in counts (section 6, #28).
    PdStep,
    /// Largest step of Go_Relative_Pos_PD that a master allows itself, in counts.
    StepLimit,
    /// Speed of Turn_ConstSpeed in rpm (section 6, #10).
    SpeedRpm,
    /// Amplitude of Square_Wave and Sin_Wave in counts; 1024 is 45 degrees (section 6, #11, #12).
    Amplitude,
    /// Frequency of Square_Wave and Sin_Wave in Hz (section 6, #13).
    FrequencyHz,
    /// Main gain (section 6, #16).
    MainGain,
    /// Speed gain (section 6, #16).
    SpeedGain,
    /// Integration gain (section 6, #16).
    IntegrationGain,
    /// Torque filter constant (section 6, #16).
    TorqueFilter,
    /// Max speed parameter (section 6, #17); `units` turns it into rpm.
    MaxSpeed,
    /// Max acceleration parameter (section 6, #17); `units` turns it into rpm/s.
    MaxAcceleration,
    /// On-position range (section 6, #18).
    OnPosRange,
    /// Gear number (section 6, #18).
    GearNumber,
    /// Line number (section 6, #18); not explained by any document (D24).
    LineNumber,
    /// Configuration byte: bits 7 and 6 must be 0 when written (section 6, #7).
    ConfigByte,
    /// Servo mode in the configuration byte: 3 is undefined (section 6, #7).
    ServoMode,
    /// Command input mode in the configuration byte (section 6, #7).
    CommandMode,
    /// Torque of revision 1.2A, full scale 700 (1.2A section 6, #14; D28).
    Torque700,
    /// Torque of revision 1.6A, full scale 981 (1.6A section 6, #14; D28).
    Torque981,
}

impl Quantity {
    /// Smallest and largest value, both allowed.
    #[must_use]
    pub const fn limits(self) -> (i32, i32) {
        match self {
            Self::DriveId => (1, 63),
            Self::StoredDriveId => (0, 63),
            Self::Counts28 => (-(1 << 27), (1 << 27) - 1),
            Self::PdStep => (-16_384, 16_384),
            Self::StepLimit => (1, 16_384),
            Self::SpeedRpm => (-20_000, 20_000),
            Self::Amplitude => (0, 4_096),
            Self::FrequencyHz => (0, 50),
            Self::MainGain
            | Self::SpeedGain
            | Self::IntegrationGain
            | Self::TorqueFilter
            | Self::MaxSpeed
            | Self::MaxAcceleration
            | Self::OnPosRange => (1, 127),
            Self::GearNumber => (500, 16_384),
            Self::LineNumber => (500, 4_095),
            Self::ConfigByte => (0, 0x3F),
            Self::ServoMode => (0, 2),
            Self::CommandMode => (0, 3),
            Self::Torque700 => (-700, 700),
            Self::Torque981 => (-981, 981),
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

    const fn name(self) -> &'static str {
        match self {
            Self::DriveId => "drive id",
            Self::StoredDriveId => "stored drive id",
            Self::Counts28 => "position or distance in counts",
            Self::PdStep => "PD step in counts",
            Self::StepLimit => "step limit in counts",
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
            Self::LineNumber => "line number",
            Self::ConfigByte => "configuration byte",
            Self::ServoMode => "servo mode",
            Self::CommandMode => "command input mode",
            Self::Torque700 | Self::Torque981 => "torque",
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

macro_rules! bounded {
    ($(#[$doc:meta])* $name:ident($repr:ty), $quantity:ident) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub struct $name($repr);

        impl $name {
            /// The smallest value.
            pub const MIN: Self = Self(Quantity::$quantity.limits().0 as $repr);
            /// The largest value.
            pub const MAX: Self = Self(Quantity::$quantity.limits().1 as $repr);

            /// Checks the number against the limits of its quantity.
            ///
            /// # Errors
            /// [`RangeError`] when the number lies outside.
            pub const fn new(value: i32) -> Result<Self, RangeError> {
                match Quantity::$quantity.check(value) {
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
    };
}

bounded! {
    /// A position or a distance in command counts, -2^27 ..= 2^27 - 1; positive turns clockwise.
    Counts28(i32), Counts28
}
bounded! {
    /// One step of Go_Relative_Pos_PD in command counts, -16384 ..= 16384.
    PdStep(i16), PdStep
}
bounded! {
    /// The largest step that an axis may take at once, in command counts, 1 ..= 16384.
    StepLimit(u16), StepLimit
}
bounded! {
    /// A speed in rpm, -20000 ..= 20000; positive turns clockwise.
    SpeedRpm(i16), SpeedRpm
}
bounded! {
    /// Amplitude of a built-in wave in counts, 0 ..= 4096; 1024 is 45 degrees.
    Amplitude(u16), Amplitude
}
bounded! {
    /// Frequency of a built-in wave in Hz, 0 ..= 50; 0 stops it.
    FrequencyHz(u8), FrequencyHz
}
bounded! {
    /// Main gain, 1 ..= 127.
    MainGain(u8), MainGain
}
bounded! {
    /// Speed gain, 1 ..= 127.
    SpeedGain(u8), SpeedGain
}
bounded! {
    /// Integration gain, 1 ..= 127.
    IntegrationGain(u8), IntegrationGain
}
bounded! {
    /// Torque filter constant, 1 ..= 127.
    TorqueFilter(u8), TorqueFilter
}
bounded! {
    /// Max speed parameter, 1 ..= 127; not rpm, see [`crate::units::max_speed_rpm`].
    MaxSpeed(u8), MaxSpeed
}
bounded! {
    /// Max acceleration parameter, 1 ..= 127; not rpm/s, see [`crate::units::max_acceleration_rpm_s`].
    MaxAcceleration(u8), MaxAcceleration
}
bounded! {
    /// On-position range, 1 ..= 127. 127 also turns JP3-9 into the brake output (D54).
    OnPosRange(u8), OnPosRange
}
bounded! {
    /// Gear number, 500 ..= 16384; 4096 is gear ratio 1.
    GearNumber(u16), GearNumber
}
bounded! {
    /// Line number, 500 ..= 4095; not explained by any document (D24).
    LineNumber(u16), LineNumber
}

impl PdStep {
    /// No motion.
    pub const ZERO: Self = Self(0);

    /// The step towards a distance in counts, not longer than `limit`; the caller carries the rest.
    #[must_use]
    pub const fn toward(distance_counts: i32, limit: StepLimit) -> Self {
        let limit = limit.0 as i16;
        if distance_counts > limit as i32 {
            Self(limit)
        } else if distance_counts < -(limit as i32) {
            Self(-limit)
        } else {
            Self(distance_counts as i16)
        }
    }
}

impl SpeedRpm {
    /// Standstill.
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
        assert_eq!(PdStep::new(-16_384).map(PdStep::get), Ok(-16_384));
        assert_eq!(
            PdStep::new(-16_385),
            Err(RangeError {
                quantity: Quantity::PdStep,
                actual: -16_385
            })
        );
        assert_eq!(Counts28::MAX.get(), 134_217_727);
        assert!(Counts28::new(134_217_728).is_err());
        assert!(GearNumber::new(499).is_err());
        assert_eq!(GearNumber::new(500), Ok(GearNumber::MIN));
    }

    #[test]
    fn numbers_that_would_wrap_into_the_range_are_refused() {
        // 65_536 + 1 is 1 in sixteen bits, 256 + 5 is 5 in eight.
        assert!(PdStep::new(65_537).is_err());
        assert!(MainGain::new(261).is_err());
        assert!(Counts28::new(i32::MIN).is_err());
    }

    #[test]
    fn a_step_goes_toward_its_distance_within_the_limit() {
        let limit = StepLimit::new(100).unwrap();
        let toward = |distance| PdStep::toward(distance, limit).get();
        assert_eq!(
            [-101, -100, 0, 99, 100, 101].map(toward),
            [-100, -100, 0, 99, 100, 100]
        );
        assert_eq!(PdStep::toward(i32::MIN, StepLimit::MAX), PdStep::MIN);
        assert_eq!(PdStep::toward(i32::MAX, StepLimit::MAX), PdStep::MAX);
    }

    #[test]
    fn a_constant_is_checked_at_compile_time() {
        const STEP: Result<PdStep, RangeError> = PdStep::new(250);
        assert_eq!(STEP.map(PdStep::get), Ok(250));
    }
}
