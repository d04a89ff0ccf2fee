//! The choices in a drive's configuration.

use core::fmt;

/// Window of the response delay; each delay is drawn evenly from it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ResponseDelay {
    min_ns: u64,
    max_ns: u64,
}

impl ResponseDelay {
    /// Always the same delay.
    pub const fn fixed(delay_ns: u64) -> Self {
        Self {
            min_ns: delay_ns,
            max_ns: delay_ns,
        }
    }

    /// Delays from `min_ns` to `max_ns`, both included.
    ///
    /// # Errors
    /// [`DynConfigError::EmptyDelayWindow`] when the window ends before it begins.
    pub const fn between(min_ns: u64, max_ns: u64) -> Result<Self, DynConfigError> {
        if max_ns < min_ns {
            return Err(DynConfigError::EmptyDelayWindow { min_ns, max_ns });
        }
        Ok(Self { min_ns, max_ns })
    }

    /// The shortest delay.
    pub const fn min_ns(self) -> u64 {
        self.min_ns
    }

    /// The longest delay.
    pub const fn max_ns(self) -> u64 {
        self.max_ns
    }
}

/// Unit of the position that General_Read reports: no document states it (D44).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReadBackUnit {
    /// Command counts: 4 times the gear number a turn.
    CommandCounts,
    /// Movement positions: 65536 a turn whatever the gear.
    MovementPositions,
    /// Motor steps: 16384 a turn whatever the gear.
    MotorSteps,
}

impl ReadBackUnit {
    /// A position in this unit, rounded towards negative infinity.
    pub(super) fn apply(self, command_counts: i64, gear_number: u16) -> i128 {
        let counts_of_a_turn = match self {
            Self::CommandCounts => return command_counts.into(),
            Self::MovementPositions => 65_536,
            Self::MotorSteps => 16_384,
        };
        (i128::from(command_counts) * counts_of_a_turn).div_euclid(4 * i128::from(gear_number))
    }
}

/// What General_Read reports when the position does not fit: no document says (D17).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PositionOverflow {
    /// The lower 28 bits, sign-extended.
    Wrap28Bit,
    /// The end of the 28-bit range.
    Saturate28Bit,
    /// The lower 32 bits: legal for a "32-bit position" (D16).
    Wrap32Bit,
}

impl PositionOverflow {
    pub(super) fn apply(self, position: i128) -> i32 {
        match self {
            Self::Wrap28Bit => (position as i32) << 4 >> 4,
            Self::Saturate28Bit => position.clamp(-(1 << 27), (1 << 27) - 1) as i32,
            Self::Wrap32Bit => position as i32,
        }
    }
}

/// What becomes of the position at a power cycle in relative mode. In absolute mode it is always kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PositionAfterPower {
    /// The shaft is at 0 wherever it stands, as with an incremental encoder.
    Zero,
    /// The position is kept.
    Kept,
}

/// What the drive does with a request that it cannot obey.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reaction {
    /// Nothing.
    Ignore,
    /// Drive_Error with FF.
    DataError,
}

/// Which numbers out of range raise a data error (D66).
///
/// The chapter on Drive_Error promises one for any invalid data range (1.6A section 6, #29); the chapters of the functions repeat it
/// for some functions only.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RangeErrors {
    /// Every number, whatever the function.
    EveryValue,
    /// Those of the functions that repeat the promise: not Set_Drive_Config, not Go_Relative_Pos_PD, and Assign_Drive_ID in 1.2A only.
    WhereRepeated,
}

/// Highest speed and acceleration of the motor itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ServoDynamics {
    /// Those of the parameters MaxSpeed and MaxAcceleration, as `dyn_can::units` reads them.
    FromParameters,
    /// Those of a given motor and load.
    Limited(ServoLimits),
}

/// Limits of a motor with its load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ServoLimits {
    speed_rpm: f64,
    acceleration_rpm_s: f64,
}

impl ServoLimits {
    /// A highest speed in rpm and a highest acceleration in rpm/s.
    ///
    /// # Errors
    /// [`DynConfigError::NotPositive`] unless both are positive and finite.
    pub const fn new(speed_rpm: f64, acceleration_rpm_s: f64) -> Result<Self, DynConfigError> {
        if let Err(error) = positive("speed limit in rpm", speed_rpm) {
            return Err(error);
        }
        if let Err(error) = positive("acceleration limit in rpm/s", acceleration_rpm_s) {
            return Err(error);
        }
        Ok(Self {
            speed_rpm,
            acceleration_rpm_s,
        })
    }

    /// Highest speed in rpm.
    pub const fn speed_rpm(self) -> f64 {
        self.speed_rpm
    }

    /// Highest acceleration in rpm/s.
    pub const fn acceleration_rpm_s(self) -> f64 {
        self.acceleration_rpm_s
    }
}

/// Deceleration of a free motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoastDeceleration {
    rpm_s: f64,
}

impl CoastDeceleration {
    /// 3000 rpm/s: a motor at 3000 rpm turns for another second.
    pub const DEFAULT: Self = Self { rpm_s: 3_000.0 };

    /// A deceleration in rpm/s.
    ///
    /// # Errors
    /// [`DynConfigError::NotPositive`] unless it is positive and finite: a free motor stops some day.
    pub const fn new(rpm_s: f64) -> Result<Self, DynConfigError> {
        match positive("coast deceleration in rpm/s", rpm_s) {
            Ok(rpm_s) => Ok(Self { rpm_s }),
            Err(error) => Err(error),
        }
    }

    /// The deceleration in rpm/s.
    pub const fn rpm_s(self) -> f64 {
        self.rpm_s
    }
}

const fn positive(quantity: &'static str, actual: f64) -> Result<f64, DynConfigError> {
    if actual > 0.0 && actual.is_finite() {
        Ok(actual)
    } else {
        Err(DynConfigError::NotPositive { quantity, actual })
    }
}

/// A drive cannot be set up like this.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum DynConfigError {
    /// The window of the response delay ends before it begins.
    EmptyDelayWindow {
        /// Its begin.
        min_ns: u64,
        /// Its end.
        max_ns: u64,
    },
    /// A limit is zero, negative, infinite or not a number.
    NotPositive {
        /// Which limit, with its unit.
        quantity: &'static str,
        /// What was given.
        actual: f64,
    },
}

impl fmt::Display for DynConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::EmptyDelayWindow { min_ns, max_ns } => write!(
                f,
                "the longest response delay must be at least the shortest, {min_ns} ns, got {max_ns} ns"
            ),
            Self::NotPositive { quantity, actual } => {
                write!(f, "{quantity} must be positive and finite, got {actual}")
            }
        }
    }
}

impl core::error::Error for DynConfigError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn impossible_settings_are_refused_with_the_number() {
        let window = ResponseDelay::between(5, 4);
        assert_eq!(
            window.map_err(|error| error.to_string()),
            Err("the longest response delay must be at least the shortest, 5 ns, got 4 ns".into())
        );
        assert!(ResponseDelay::between(5, 5).is_ok());
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(ServoLimits::new(bad, 1.0).is_err());
            assert!(ServoLimits::new(1.0, bad).is_err());
            assert!(CoastDeceleration::new(bad).is_err());
        }
    }

    #[test]
    fn one_turn_is_read_back_in_three_units_at_every_gear() {
        // One turn is 2000, 16384 and 65536 command counts (manual section 4.1).
        for (gear, turn) in [(500, 2_000), (4_096, 16_384), (16_384, 65_536)] {
            let read = |unit: ReadBackUnit| unit.apply(turn, gear);
            assert_eq!(read(ReadBackUnit::CommandCounts), turn.into());
            assert_eq!(read(ReadBackUnit::MovementPositions), 65_536);
            assert_eq!(read(ReadBackUnit::MotorSteps), 16_384);
        }
        // A quarter of a count is rounded down on both sides of zero.
        let steps = |counts| ReadBackUnit::MotorSteps.apply(counts, 16_384);
        assert_eq!([-1, 0, 3, 4].map(steps), [-1, 0, 0, 1]);
    }

    #[test]
    fn overflow_has_three_readings() {
        use PositionOverflow::{Saturate28Bit, Wrap28Bit, Wrap32Bit};
        let beyond = 1 << 27;
        assert_eq!(
            [Wrap28Bit, Saturate28Bit, Wrap32Bit].map(|overflow| overflow.apply(beyond)),
            [-(1 << 27), (1 << 27) - 1, 1 << 27]
        );
        assert_eq!(Wrap28Bit.apply(-5), -5);
    }
}
