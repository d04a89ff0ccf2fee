//! Limits of motion. There is no default: whoever builds a machine knows how fast it may move and where it ends.

use dyn_can::units::command_counts_per_turn;
use dyn_can::{Counts28, GearNumber, StepLimit};

/// Cycles of full speed that may be owed: at 1 kHz more than an outage that [`Timeouts::stuck_us`](crate::servo::Timeouts) allows.
const BACKLOG_CYCLES: u32 = 32;

/// How far an axis may go, in command counts from the origin.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Travel {
    /// Smallest target.
    pub min_counts: i32,
    /// Largest target.
    pub max_counts: i32,
}

impl Travel {
    /// Everything that 28 bit of the protocol can say: for an axis without ends.
    pub const WHOLE: Self = Self {
        min_counts: Counts28::MIN.get(),
        max_counts: Counts28::MAX.get(),
    };

    /// From one angle of the motor to another, in thousandths of a degree, with this gear number. Rounded towards 0; what 32 bit cannot
    /// hold is the end of 32 bit, and refused later.
    #[must_use]
    pub const fn of_motor_millidegrees(min: i64, max: i64, gear: GearNumber) -> Self {
        Self {
            min_counts: millidegrees_to_counts(min, gear),
            max_counts: millidegrees_to_counts(max, gear),
        }
    }
}

const fn millidegrees_to_counts(millidegrees: i64, gear: GearNumber) -> i32 {
    let turn = command_counts_per_turn(gear) as i64;
    let counts = millidegrees.saturating_mul(turn) / 360_000;
    if counts > i32::MAX as i64 {
        i32::MAX
    } else if counts < i32::MIN as i64 {
        i32::MIN
    } else {
        counts as i32
    }
}

/// Largest change of the step from one cycle to the next: the acceleration limit, in 1/256 command counts per cycle and cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct StepChange(u32);

impl StepChange {
    /// The smallest, 1/256 count.
    pub const MIN: Self = Self(1);
    /// The largest, 16384 counts: from standstill to the largest step in one cycle.
    pub const MAX: Self = Self(16_384 * 256);

    /// A change of whole counts, 1 ..= 16384.
    #[must_use]
    pub const fn from_counts(counts: u32) -> Option<Self> {
        match counts {
            1..=16_384 => Some(Self(counts * 256)),
            _ => None,
        }
    }

    /// A change in 1/256 counts, 1 ..= 16384 * 256.
    #[must_use]
    pub const fn from_256ths(change: u32) -> Option<Self> {
        if change == 0 || change > Self::MAX.0 {
            return None;
        }
        Some(Self(change))
    }

    /// The change of the step over 256 cycles, in counts.
    #[must_use]
    pub const fn per_256_cycles(self) -> u32 {
        self.0
    }
}

/// Limits of motion in the units of the motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MotorLimits {
    /// Fastest speed of the motor, r/min.
    pub speed_rpm: u32,
    /// Fastest change of that speed, r/min per second.
    pub acceleration_rpm_per_s: u32,
}

/// Limits that the protocol cannot express.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LimitsError {
    /// The speed is no step of 1 ..= 16384 counts in one cycle.
    #[error(
        "a speed must be a step of 1..=16384 counts in one cycle, {actual_rpm} r/min are {step_counts}: choose another speed, cycle or gear number"
    )]
    Speed {
        /// The speed given.
        actual_rpm: u32,
        /// The counts that it needs in one cycle, rounded down.
        step_counts: u64,
    },
    /// The acceleration is less than 1/256 count, or more than 16384 counts, per cycle and cycle.
    #[error(
        "an acceleration must be at least {least_rpm_per_s} r/min per second in this cycle, got {actual_rpm_per_s}"
    )]
    Acceleration {
        /// The acceleration given.
        actual_rpm_per_s: u32,
        /// The smallest that this cycle and gear number can express, rounded up.
        least_rpm_per_s: u64,
    },
}

/// Limits of one axis, in command counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// Largest step in one cycle: the speed limit of the axis. No frame carries more, whatever happens.
    pub max_step: StepLimit,
    /// Largest change of the step from one cycle to the next while ramping down or catching up: the acceleration limit.
    pub max_step_change: StepChange,
    /// How far the axis may go.
    pub travel: Travel,
    /// How far the axis may fall behind its target.
    pub backlog_counts: u32,
    /// Distance between sent position and read position beyond which a moving axis faults.
    pub following_error_counts: u32,
    /// The same at standstill: an error that stays is a lost or doubled step.
    pub drift_tolerance_counts: u32,
}

impl Limits {
    /// Limits of speed, acceleration and travel; 32 cycles of full speed of backlog, the 8192 counts of following error after which a
    /// drive alarms by itself (1.6A section 6, #9), and 16 counts (0.35 degrees at gear number 4096) of drift.
    #[must_use]
    pub const fn new(max_step: StepLimit, max_step_change: StepChange, travel: Travel) -> Self {
        Self {
            max_step,
            max_step_change,
            travel,
            backlog_counts: BACKLOG_CYCLES * max_step.get() as u32,
            following_error_counts: 8_192,
            drift_tolerance_counts: 16,
        }
    }

    /// The same from the units of the motor, for a gear number and a cycle. Speed and acceleration are rounded down.
    ///
    /// # Errors
    /// [`LimitsError`] when the protocol cannot express them.
    pub const fn of_motor(
        motor: MotorLimits,
        travel: Travel,
        gear: GearNumber,
        cycle_us: u32,
    ) -> Result<Self, LimitsError> {
        let turn = command_counts_per_turn(gear) as u64;
        let cycle_us = cycle_us as u64;
        let step_counts = motor.speed_rpm as u64 * turn * cycle_us / 60_000_000;
        let too_fast = LimitsError::Speed {
            actual_rpm: motor.speed_rpm,
            step_counts,
        };
        if step_counts == 0 || step_counts > StepLimit::MAX.get() as u64 {
            return Err(too_fast);
        }
        let Ok(max_step) = StepLimit::new(step_counts as i32) else {
            return Err(too_fast);
        };
        // Counts per cycle and cycle in 1/256: rpm/s * turn / 60 * (cycle / 1 s)^2 * 256, with 256 taken out of the square of a second. What
        // does not fit 64 bits is far too much.
        const SQUARE_OF_SECOND: u64 = 60_000_000_000_000 / 256;
        let divisor = turn.saturating_mul(cycle_us.saturating_mul(cycle_us));
        let rpm_per_s = motor.acceleration_rpm_per_s as u64;
        let change = rpm_per_s.saturating_mul(divisor) / SQUARE_OF_SECOND;
        let change = if change > u32::MAX as u64 {
            None
        } else {
            StepChange::from_256ths(change as u32)
        };
        match change {
            Some(max_step_change) => Ok(Self::new(max_step, max_step_change, travel)),
            None if divisor == 0 => Err(too_fast),
            None => Err(LimitsError::Acceleration {
                actual_rpm_per_s: motor.acceleration_rpm_per_s,
                least_rpm_per_s: SQUARE_OF_SECOND.div_ceil(divisor),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GEAR: GearNumber = match GearNumber::new(4_096) {
        Ok(gear) => gear,
        Err(_) => panic!("4096 is a gear number"),
    };

    fn of_motor(speed_rpm: u32, acceleration_rpm_per_s: u32) -> Result<Limits, LimitsError> {
        let motor = MotorLimits {
            speed_rpm,
            acceleration_rpm_per_s,
        };
        Limits::of_motor(motor, Travel::WHOLE, GEAR, 1_000)
    }

    #[test]
    fn motor_units_are_counts_per_cycle() {
        // 150 r/min are 2.5 turns of 16384 counts in a second, so 40.96 in a millisecond.
        let limits = of_motor(150, 1_000).unwrap();
        assert_eq!(limits.max_step.get(), 40);
        // 1000 r/min per second are 273,067 counts per second squared, 0.273 per cycle squared.
        assert_eq!(limits.max_step_change.per_256_cycles(), 69);
        assert_eq!(limits.backlog_counts, 1_280);
    }

    #[test]
    fn what_the_protocol_cannot_express_is_refused() {
        assert!(matches!(of_motor(0, 100), Err(LimitsError::Speed { .. })));
        assert_eq!(of_motor(60_000, 1_000).unwrap().max_step, StepLimit::MAX);
        assert!(matches!(
            of_motor(60_004, 100),
            Err(LimitsError::Speed {
                step_counts: 16_384..,
                ..
            })
        ));
        assert_eq!(
            of_motor(100, 14),
            Err(LimitsError::Acceleration {
                actual_rpm_per_s: 14,
                least_rpm_per_s: 15
            })
        );
        assert!(of_motor(100, 15).is_ok());
    }

    #[test]
    fn travel_in_degrees_of_the_motor() {
        let travel = Travel::of_motor_millidegrees(-90_000, 360_000, GEAR);
        assert_eq!((travel.min_counts, travel.max_counts), (-4_096, 16_384));
    }
}
