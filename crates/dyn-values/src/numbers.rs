//! Numbers with a range: what a type holds can always be encoded.

use core::fmt;
use core::num::{NonZeroU8, NonZeroU16};

use crate::quantity::{Quantity, RangeError};

macro_rules! bounded {
    ($($(#[$doc:meta])* $name:ident($repr:ty),)*) => {$(
        bounded! { @type $(#[$doc])* $name($repr) }

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
    )*};

    (@type $(#[$doc:meta])* $name:ident($repr:ty)) => {
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[cfg_attr(feature = "defmt", derive(defmt::Format))]
        pub struct $name($repr);

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

/// Numbers of which none is 0: a value that is not there takes no room.
macro_rules! bounded_without_zero {
    ($($(#[$doc:meta])* $name:ident($repr:ty, $non_zero:ty),)*) => {$(
        bounded! { @type $(#[$doc])* $name($non_zero) }

        impl $name {
            /// The smallest value.
            pub const MIN: Self = Self::limit(Quantity::$name.limits().0);
            /// The largest value.
            pub const MAX: Self = Self::limit(Quantity::$name.limits().1);

            const fn limit(value: i32) -> Self {
                match Self::new(value) {
                    Ok(limit) => limit,
                    Err(_) => panic!("0 is not among the values of the quantity"),
                }
            }

            /// Checks the number against the limits of its quantity.
            ///
            /// # Errors
            /// [`RangeError`] when the number lies outside.
            pub const fn new(value: i32) -> Result<Self, RangeError> {
                match Quantity::$name.check(value) {
                    Ok(checked) => match <$non_zero>::new(checked as $repr) {
                        Some(number) => Ok(Self(number)),
                        None => Err(RangeError {
                            quantity: Quantity::$name,
                            actual: value,
                        }),
                    },
                    Err(error) => Err(error),
                }
            }

            /// The number.
            #[must_use]
            pub const fn get(self) -> $repr {
                self.0.get()
            }
        }
    )*};
}

bounded! {
    /// A position or a distance in command counts, -2^27 ..= 2^27 - 1; positive turns clockwise.
    Counts28(i32),
    /// One step of Go_Relative_Pos_PD in command counts, -16384 ..= 16384.
    PdStep(i16),
    /// A speed in rpm, -20000 ..= 20000; positive turns clockwise.
    SpeedRpm(i16),
    /// Amplitude of a built-in wave in counts, 0 ..= 4096; 1024 is 45 degrees.
    Amplitude(u16),
    /// Frequency of a built-in wave in Hz, 0 ..= 50; 0 stops it.
    FrequencyHz(u8),
    /// The byte that a function of the serial protocol without data sends, 0 ..= 127.
    Dummy(u8),
}

bounded_without_zero! {
    /// The largest step that an axis may take at once, in command counts, 1 ..= 16384.
    StepLimit(u16, NonZeroU16),
    /// Main gain, 1 ..= 127.
    MainGain(u8, NonZeroU8),
    /// Speed gain, 1 ..= 127.
    SpeedGain(u8, NonZeroU8),
    /// Integration gain, 1 ..= 127.
    IntegrationGain(u8, NonZeroU8),
    /// Torque filter constant, 1 ..= 127.
    TorqueFilter(u8, NonZeroU8),
    /// Max speed parameter, 1 ..= 127; not rpm.
    MaxSpeed(u8, NonZeroU8),
    /// Max acceleration parameter, 1 ..= 127; not rpm/s.
    MaxAcceleration(u8, NonZeroU8),
    /// On-position range, 1 ..= 127. 127 also turns JP3-9 into the brake output (D54).
    OnPosRange(u8, NonZeroU8),
    /// Gear number, 500 ..= 16384; 4096 is gear ratio 1. 16384 does not fit the two bytes of the serial protocol's table (M13).
    GearNumber(u16, NonZeroU16),
    /// Line number, 500 ..= 4095; not explained by any document (D24).
    LineNumber(u16, NonZeroU16),
    /// Feed rate of a coordinated move, 1 ..= 127; its unit is not stated. Serial only.
    FeedRate(u8, NonZeroU8),
}

impl PdStep {
    /// No motion.
    pub const ZERO: Self = Self(0);

    /// The step towards a distance in counts, not longer than `limit`; the caller carries the rest.
    #[must_use]
    pub const fn toward(distance_counts: i32, limit: StepLimit) -> Self {
        let limit = limit.get() as i16;
        if distance_counts > limit as i32 {
            Self(limit)
        } else if distance_counts < -(limit as i32) {
            Self(-limit)
        } else {
            Self(distance_counts as i16)
        }
    }
}

impl Amplitude {
    /// No wave.
    pub const ZERO: Self = Self(0);
}

impl SpeedRpm {
    /// Standstill.
    pub const ZERO: Self = Self(0);
}

impl OnPosRange {
    /// True for 127, the value that also makes JP3-9 the brake output after the next power cycle (D54).
    #[must_use]
    pub const fn enables_brake_output(self) -> bool {
        self.get() == 127
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
        assert!(GearNumber::new(16_385).is_err());
        assert_eq!(GearNumber::new(500), Ok(GearNumber::MIN));
        assert!(FeedRate::new(0).is_err());
    }

    #[test]
    fn numbers_that_would_wrap_into_the_range_are_refused() {
        // 65_536 + 1 is 1 in sixteen bits, 256 + 5 is 5 in eight.
        assert!(PdStep::new(65_537).is_err());
        assert!(MainGain::new(261).is_err());
        assert!(SpeedRpm::new(65_537).is_err());
        assert!(Dummy::new(-1).is_err());
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

    #[test]
    fn the_largest_on_position_range_makes_a_brake_output() {
        let makes =
            [1, 126, 127].map(|range| OnPosRange::new(range).unwrap().enables_brake_output());
        assert_eq!(makes, [false, false, true]);
    }
}
