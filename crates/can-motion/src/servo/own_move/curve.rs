//! Speed, acceleration and time of the motion that a drive makes by itself, in command counts (DYN2 manual A1.8 section 7).
//!
//! In counts of the command the gear falls out of the formulas: `(MaxSpd + 3)^2 / 16 * 12.21 * g` r/min are
//! `(MaxSpd + 3)^2 * 208.384` counts a second, and `MaxAcl * 635.78 * g` r/min per second are `MaxAcl * 173,610.3` counts per second
//! squared. Whether the gear counts in these formulas at all is doubtful (D64): limits take the faster reading, waiting times the slower.

use core::num::NonZeroU64;

use dyn_can::{GearNumber, ParamGroup2};

/// Gear number of gear ratio 1.
const GEAR_UNITY: u64 = 4_096;
/// Thousandths of a count a second of one unit of `(MaxSpd + 3)^2`.
const SPEED_UNIT: u64 = 208_384;
/// Thousandths of a count per second squared of one unit of MaxAcl.
const ACCELERATION_UNIT: u64 = 173_610_326;
/// The whole time of a soft start at MaxAcl 1 in microseconds: 1.2 times the 59.98 s from 10 to 90 %.
const SOFT_START_US: u64 = 71_976_000;

/// Speed and acceleration of built-in moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Curve {
    /// Counts a second.
    pub(super) speed: NonZeroU64,
    /// Counts per second squared.
    pub(super) acceleration: NonZeroU64,
}

impl Curve {
    /// The faster of both readings of the gear, rounded up.
    pub(super) fn fastest(group: ParamGroup2, gear: GearNumber) -> Self {
        let gear = u64::from(gear.get()).max(GEAR_UNITY);
        let [speed, acceleration] = thousandths(group);
        Self {
            speed: at_least_1((speed * gear).div_ceil(1_000 * GEAR_UNITY)),
            acceleration: at_least_1((acceleration * gear).div_ceil(1_000 * GEAR_UNITY)),
        }
    }

    /// The slower of both readings of the gear, rounded down.
    pub(super) fn slowest(group: ParamGroup2, gear: GearNumber) -> Self {
        let gear = u64::from(gear.get()).min(GEAR_UNITY);
        let [speed, acceleration] = thousandths(group);
        Self {
            speed: at_least_1(speed * gear / (1_000 * GEAR_UNITY)),
            acceleration: at_least_1(acceleration * gear / (1_000 * GEAR_UNITY)),
        }
    }

    /// The highest speed of a move by so many counts: short moves do not reach that of the drive.
    pub(super) fn peak(&self, counts: u32) -> u64 {
        let squared = self.acceleration.get() * u64::from(counts);
        self.speed.get().min(squared.isqrt() + 1)
    }

    /// How long a move by so many counts takes, in milliseconds, rounded up.
    pub(super) fn move_ms(&self, counts: u32) -> u64 {
        let counts = u64::from(counts);
        let (speed, acceleration) = (self.speed.get(), self.acceleration.get());
        let reaches_speed = counts * acceleration >= speed * speed;
        if reaches_speed {
            divided_up(counts * 1_000, self.speed) + divided_up(speed * 1_000, self.acceleration)
        } else {
            // 2 * sqrt(counts / acceleration), with the square in 1e-8 s^2.
            let tenths_of_ms = (counts * 100_000_000 / self.acceleration).isqrt() + 1;
            (2 * tenths_of_ms).div_ceil(10)
        }
    }

    /// Counts in which the drive stops from its full speed, rounded up.
    pub(super) fn braking_counts(&self) -> u64 {
        let speed = self.speed.get();
        divided_up(speed * speed, self.acceleration).div_ceil(2)
    }
}

/// Speed and acceleration in thousandths of a count.
fn thousandths(group: ParamGroup2) -> [u64; 2] {
    let root = u64::from(group.max_speed.get()) + 3;
    let acceleration = u64::from(group.max_acceleration.get());
    [root * root * SPEED_UNIT, acceleration * ACCELERATION_UNIT]
}

/// The whole time of a soft start or stop at constant speed, in microseconds.
pub(super) fn soft_start_us(group: ParamGroup2) -> NonZeroU64 {
    let parameter = u64::from(group.max_acceleration.get());
    at_least_1(divided_up(SOFT_START_US, at_least_1(parameter * parameter)))
}

fn at_least_1(value: u64) -> NonZeroU64 {
    NonZeroU64::new(value).unwrap_or(NonZeroU64::MIN)
}

/// A quotient, rounded up.
pub(super) fn divided_up(value: u64, by: NonZeroU64) -> u64 {
    value / by + u64::from(value % by != 0)
}

/// Counts a second at a speed of the motor in r/min.
pub(super) fn counts_per_s(rpm: u32, gear: GearNumber) -> u64 {
    (u64::from(rpm) * u64::from(dyn_can::units::command_counts_per_turn(gear))).div_ceil(60)
}

/// Counts in one cycle at so many counts a second, rounded up.
pub(super) const fn per_cycle(counts_per_s: u64, cycle_us: u32) -> u32 {
    let counts = counts_per_s
        .saturating_mul(cycle_us as u64)
        .div_ceil(1_000_000);
    if counts > u32::MAX as u64 {
        u32::MAX
    } else {
        counts as u32
    }
}

/// The change of the step in 1/256 counts per cycle and cycle at so many counts per second squared, rounded up.
pub(super) const fn change_per_cycle(counts_per_s2: u64, cycle_us: u32) -> u32 {
    let cycle_us = cycle_us as u128;
    let change = (counts_per_s2 as u128 * 256 * cycle_us * cycle_us).div_ceil(1_000_000_000_000);
    if change > u32::MAX as u128 {
        u32::MAX
    } else {
        change as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dyn_can::units::SCurve;
    use dyn_can::{MaxAcceleration, MaxSpeed};
    use proptest::prelude::*;

    fn group(speed: i32, acceleration: i32) -> ParamGroup2 {
        ParamGroup2 {
            max_speed: MaxSpeed::new(speed).unwrap(),
            max_acceleration: MaxAcceleration::new(acceleration).unwrap(),
        }
    }

    fn gear(number: i32) -> GearNumber {
        GearNumber::new(number).unwrap()
    }

    #[test]
    fn worked_example_of_the_manual() {
        // Section 7: MaxSpd 48, MaxAcl 30, 140000 counts: 1985 r/min, 19073 r/min per second, 0.362 s.
        let curve = Curve::slowest(group(48, 30), gear(4_096));
        assert_eq!(curve.speed.get() * 60 / 16_384, 1_984);
        assert_eq!(curve.acceleration.get() * 60 / 16_384, 19_073);
        assert_eq!(curve.move_ms(140_000), 364);
        assert_eq!(curve.braking_counts(), 28_203);
        let fastest = Curve::fastest(group(48, 30), gear(4_096));
        assert_eq!(fastest.speed.get(), curve.speed.get() + 1);
    }

    #[test]
    fn the_gear_is_read_either_way() {
        // 51^2 * 208.384 = 542,006.8 counts a second.
        let speeds = |number| {
            let gear = gear(number);
            let fastest = Curve::fastest(group(48, 30), gear);
            let slowest = Curve::slowest(group(48, 30), gear);
            (slowest.speed.get(), fastest.speed.get())
        };
        assert_eq!(speeds(4_096), (542_006, 542_007));
        assert_eq!(speeds(8_192), (542_006, 1_084_014));
        assert_eq!(speeds(2_048), (271_003, 542_007));
    }

    #[test]
    fn limits_are_rounded_up() {
        assert_eq!(counts_per_s(60, gear(4_096)), 16_384);
        assert_eq!(per_cycle(16_384, 1_000), 17);
        assert_eq!(change_per_cycle(163_840, 1_000), 42);
        assert_eq!(per_cycle(u64::MAX, 1_000_000), u32::MAX);
        assert_eq!(soft_start_us(group(1, 127)).get(), 4_463);
    }

    proptest! {
        #[test]
        fn time_and_peak_are_those_of_the_formulas(
            counts in 1_u32..1 << 28, speed in 1..=127_i32, acceleration in 1..=127_i32
        ) {
            let group = group(speed, acceleration);
            let signed = i32::try_from(counts).unwrap();
            let expected = SCurve::new(signed, group.max_speed, group.max_acceleration, gear(4_096));
            let ms = Curve::slowest(group, gear(4_096)).move_ms(counts) as f64;
            let exact_ms = expected.total_time_s * 1e3;
            prop_assert!(ms >= exact_ms - 1.0 && ms <= exact_ms * 1.001 + 3.0, "{ms} {exact_ms}");
            let peak = expected.peak_speed_rpm / 60.0 * 16_384.0;
            let own = Curve::fastest(group, gear(4_096)).peak(counts) as f64;
            prop_assert!(own >= peak - 1.0 && own <= peak * 1.001 + 3.0, "{own} {peak}");
        }
    }
}
