//! How a simulated drive is set up: everything that the documents leave open is a field here.

use core::fmt;
use core::num::NonZeroU32;

use dyn_can::{
    ConfigByte, Dialect, DriveId, GearNumber, IntegrationGain, MainGain, MaxAcceleration, MaxSpeed,
    OnPosRange, ParamGroup1, ParamGroup2, ParamGroup3, RangeError, Revision, SpeedGain,
    StoredDriveId, TorqueFilter,
};

/// 150 ms from power-on to the first command (DYN2 manual A1.8 section 4; D58).
pub const POWER_ON_DELAY_NS: u64 = 150_000_000;

/// Position error of the lost phase alarm in motor steps of 16384 a turn: 180 degrees (1.6A section 6, #9; D47).
pub const LOST_PHASE_STEPS: u32 = 8_192;

/// A number checked while compiling: the panic is a compiler error and cannot happen at run time.
macro_rules! checked {
    ($type:ty, $value:literal) => {
        const {
            match <$type>::new($value) {
                Ok(value) => value,
                Err(_) => panic!("the literal is out of range"),
            }
        }
    };
}

/// A simulated drive's EEPROM, timing, mechanics and reading of the documents.
///
/// Start from [`Self::new`] or [`Self::fresh`] and change fields.
#[derive(Debug, Clone, PartialEq)]
pub struct DynDriveConfig {
    /// Stored drive id; [`StoredDriveId::NONE`] on a fresh drive, which listens and answers on identifier 0 (D2).
    pub id: StoredDriveId,
    /// Revision and reading of the documents. What may go to identifier 0 is not taken from here: a drive obeys every broadcast.
    pub dialect: Dialect,
    /// From the end of a request to the moment the reply waits for the bus. No document has a figure (D65).
    pub response_delay: ResponseDelay,
    /// Seed of the response delays.
    pub seed: u64,
    /// From power-on, which is at 0 ns and after each power cycle, until the drive hears and acts. 0 is allowed.
    pub power_on_delay_ns: u64,
    /// Unit of the position that General_Read reports.
    pub read_back: ReadBackScale,
    /// What General_Read reports beyond 28 bit.
    pub overflow: PositionOverflow,
    /// Gains and torque filter; stored and reported, they do not change the motion.
    pub group1: ParamGroup1,
    /// Max speed and max acceleration.
    pub group2: ParamGroup2,
    /// On-position range, gear number and line number.
    pub group3: ParamGroup3,
    /// Configuration byte.
    pub config_byte: ConfigByte,
    /// How fast the motor can follow.
    pub dynamics: ServoDynamics,
    /// Deceleration of a free motor, by friction.
    pub coast: CoastDeceleration,
    /// Position that the drive reports at 0 ns, in command counts.
    pub start_position_counts: i64,
    /// Whether the servo is on after power-on (DYN2 manual A1.8 section 4: it is). Bit 5 of the configuration switches it off too.
    pub enabled_after_power_on: bool,
    /// Following error in motor steps (16384 a turn) beyond which the lost phase alarm comes; `None` for never.
    pub lost_phase_steps: Option<u32>,
    /// Position after a power cycle in relative mode.
    pub position_after_power: PositionAfterPower,
    /// Data byte of the reply to Drive_Reset, which no document explains; `None` for silence (D35).
    pub reset_reply: Option<u8>,
    /// Reaction where the documents promise none: wrong length, unknown magic byte, function of the other revision, and numbers out of
    /// range for Set_Drive_Config and, in 1.6A, Assign_Drive_ID (D39).
    pub unspecified: Reaction,
    /// Reaction to a Go_Relative_Pos_PD step out of range: only the general sentence of 1.6A section 6, #29 promises a data error.
    pub pd_out_of_range: Reaction,
}

impl DynDriveConfig {
    /// A drive as it leaves commissioning: revision 1.6A, factory configuration (position servo, RS232 mode), servo on after power-on,
    /// replies after 100 us, read-back in command counts.
    pub const fn new(id: DriveId) -> Self {
        Self {
            // A drive id is 1 ..= 63 and always fits, so that the second arm is never taken.
            id: match StoredDriveId::new(id.get() as i32) {
                Ok(id) => id,
                Err(_) => StoredDriveId::NONE,
            },
            ..Self::fresh()
        }
    }

    /// The same drive before it was given an id.
    pub const fn fresh() -> Self {
        Self {
            id: StoredDriveId::NONE,
            dialect: Dialect::V1_6A,
            response_delay: ResponseDelay::fixed(100_000),
            seed: 0,
            power_on_delay_ns: POWER_ON_DELAY_NS,
            read_back: ReadBackScale::COMMAND_COUNTS,
            overflow: PositionOverflow::Wrap28Bit,
            group1: ParamGroup1 {
                main_gain: checked!(MainGain, 20),
                speed_gain: checked!(SpeedGain, 20),
                integration_gain: checked!(IntegrationGain, 10),
                torque_filter: checked!(TorqueFilter, 127),
            },
            group2: ParamGroup2 {
                max_speed: checked!(MaxSpeed, 60),
                max_acceleration: checked!(MaxAcceleration, 60),
            },
            group3: ParamGroup3 {
                on_pos_range: checked!(OnPosRange, 20),
                gear_number: checked!(GearNumber, 4096),
                line_number: None,
            },
            config_byte: ConfigByte::from_byte(0),
            dynamics: ServoDynamics::FromParameters,
            coast: CoastDeceleration { rpm_s: 3_000.0 },
            start_position_counts: 0,
            enabled_after_power_on: true,
            lost_phase_steps: Some(LOST_PHASE_STEPS),
            position_after_power: PositionAfterPower::Zero,
            reset_reply: Some(0),
            unspecified: Reaction::Ignore,
            pd_out_of_range: Reaction::DataError,
        }
    }

    /// The same drive with the recommended reading of another revision.
    #[must_use]
    pub const fn with_revision(mut self, revision: Revision) -> Self {
        self.dialect = Dialect::of(revision);
        self
    }

    /// A drive with id `number`, otherwise [`Self::new`].
    ///
    /// # Errors
    /// [`RangeError`] outside 1 ..= 63.
    pub fn numbered(number: i32) -> Result<Self, RangeError> {
        DriveId::new(number).map(Self::new)
    }
}

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

/// Reported position in relation to command counts (D44): reported = command counts x numerator / denominator, rounded towards negative infinity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadBackScale {
    /// Numerator.
    pub numerator: NonZeroU32,
    /// Denominator.
    pub denominator: NonZeroU32,
}

impl ReadBackScale {
    /// The position is reported in command counts.
    pub const COMMAND_COUNTS: Self = Self {
        numerator: NonZeroU32::MIN,
        denominator: NonZeroU32::MIN,
    };

    /// The position is reported in quarters of a command count: 65536 a turn at gear number 4096.
    pub const ENCODER_COUNTS: Self = Self {
        numerator: NonZeroU32::MIN.saturating_add(3),
        denominator: NonZeroU32::MIN,
    };

    pub(super) fn apply(self, command_counts: i64) -> i128 {
        (i128::from(command_counts) * i128::from(self.numerator.get()))
            .div_euclid(i128::from(self.denominator.get()))
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
    fn read_back_scales_and_rounds_down() {
        assert_eq!(ReadBackScale::ENCODER_COUNTS.apply(-3), -12);
        let third = ReadBackScale {
            numerator: NonZeroU32::MIN,
            denominator: NonZeroU32::new(3).unwrap(),
        };
        assert_eq!([-1, 1, 3].map(|counts| third.apply(counts)), [-1, 0, 1]);
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
