//! The manual's unit formulas, in both directions (DYN2 manual A1.8 sections 5 to 7; digest section 3.1).
//!
//! Floating point on purpose: with integer division 2601 / 16 would lose the half rpm that the manual's example
//! shows. These are for set-up and display, not for the cycle. Nothing here needs libm.

use dyn_values::{GearNumber, MaxAcceleration, MaxSpeed, OnPosRange, TorqueFilter};

use crate::dialect::{Rotation, TorqueFullScale};
use crate::reply::Torque;

/// Gear number of gear ratio 1.
const GEAR_UNITY: f64 = 4096.0;
/// Encoder counts of one motor turn (16-bit encoder).
pub const ENCODER_COUNTS_PER_TURN: f64 = 65_536.0;
/// Speed of one unit of `(MaxSpd + 3)^2 / 16`, in rpm.
const SPEED_UNIT_RPM: f64 = 12.21;
/// Acceleration of one unit of MaxAcl, in rpm/s.
const ACCELERATION_UNIT_RPM_S: f64 = 635.78;
/// Steps of the on-position range in one turn.
const ON_POS_STEPS_PER_TURN: f64 = 16_384.0;
/// Time of a soft start from 10 to 90 % at MaxAcl 1, in seconds.
const SOFT_START_S: f64 = 59.98;
/// Corner of the torque filter for one unit of its constant, in rad/s.
const TORQUE_FILTER_RAD_S: f64 = 26.0;

/// Gear ratio, 0.25 ..= 8.192: motor movement for a command of one unity-gear count.
#[must_use]
pub fn gear_ratio(gear: GearNumber) -> f64 {
    GEAR_UNITY / f64::from(gear.get())
}

/// The gear number next to a gear ratio, `None` outside 500 ..= 16384.
#[must_use]
pub fn gear_number(ratio: f64) -> Option<GearNumber> {
    GearNumber::new(round_to_i32(GEAR_UNITY / ratio)?).ok()
}

/// Command counts of one motor turn, 2000 ..= 65536; 16384 at gear number 4096.
#[must_use]
pub const fn command_counts_per_turn(gear: GearNumber) -> u32 {
    4 * gear.get() as u32
}

/// Encoder counts (65536 a turn) that the motor moves for a command.
#[must_use]
pub fn motor_counts(command_counts: i32, gear: GearNumber) -> f64 {
    f64::from(command_counts) * gear_ratio(gear) * 4.0
}

/// Command counts that move the motor by encoder counts, rounded to the nearest; `None` beyond 32 bit.
#[must_use]
pub fn command_counts(motor_counts: f64, gear: GearNumber) -> Option<i32> {
    round_to_i32(motor_counts / (gear_ratio(gear) * 4.0))
}

/// Top speed of built-in moves in rpm.
#[must_use]
pub fn max_speed_rpm(max_speed: MaxSpeed, gear: GearNumber) -> f64 {
    let root = f64::from(max_speed.get()) + 3.0;
    root * root / 16.0 * SPEED_UNIT_RPM * gear_ratio(gear)
}

/// The parameter of the highest top speed that does not exceed `rpm`; `None` when even 1 would.
#[must_use]
pub fn max_speed_parameter(rpm: f64, gear: GearNumber) -> Option<MaxSpeed> {
    largest(MaxSpeed::new, |parameter| {
        max_speed_rpm(parameter, gear) <= rpm
    })
}

/// Acceleration of built-in moves in rpm/s.
#[must_use]
pub fn max_acceleration_rpm_s(max_acceleration: MaxAcceleration, gear: GearNumber) -> f64 {
    f64::from(max_acceleration.get()) * ACCELERATION_UNIT_RPM_S * gear_ratio(gear)
}

/// The parameter of the highest acceleration that does not exceed `rpm_s`; `None` when even 1 would.
#[must_use]
pub fn max_acceleration_parameter(rpm_s: f64, gear: GearNumber) -> Option<MaxAcceleration> {
    largest(MaxAcceleration::new, |parameter| {
        max_acceleration_rpm_s(parameter, gear) <= rpm_s
    })
}

/// On-position window in degrees, 0.022 ..= 2.79.
#[must_use]
pub fn on_position_degrees(range: OnPosRange) -> f64 {
    f64::from(range.get()) * 360.0 / ON_POS_STEPS_PER_TURN
}

/// The widest on-position range within `degrees`; `None` when even 1 is wider.
///
/// Never 127, which would turn an output into the brake output (D54): that one is set by name only.
#[must_use]
pub fn on_position_range(degrees: f64) -> Option<OnPosRange> {
    largest(OnPosRange::new, |range| {
        !range.enables_brake_output() && on_position_degrees(range) <= degrees
    })
}

/// Time of a soft start from 10 to 90 % of the speed, in seconds.
#[must_use]
pub fn soft_start_10_90_s(max_acceleration: MaxAcceleration) -> f64 {
    let parameter = f64::from(max_acceleration.get());
    SOFT_START_S / (parameter * parameter)
}

/// Time of a whole soft start, in seconds.
#[must_use]
pub fn soft_start_s(max_acceleration: MaxAcceleration) -> f64 {
    1.2 * soft_start_10_90_s(max_acceleration)
}

/// Corner of the torque filter `a / (s + a)`, in rad/s.
#[must_use]
pub fn torque_filter_rad_s(filter: TorqueFilter) -> f64 {
    TORQUE_FILTER_RAD_S * f64::from(filter.get())
}

impl Torque {
    /// Share of the drive's peak current, positive clockwise; -1 ..= 1 unless [`Self::is_beyond_scale`].
    #[must_use]
    pub fn of_peak(self) -> f64 {
        let share = f64::from(self.raw) / f64::from(self.full_scale.get());
        match self.positive {
            Rotation::Clockwise => share,
            Rotation::CounterClockwise => -share,
        }
    }

    /// The same in thousandths, without floating point: for a processor that has none for `f64`. Rounded towards 0; what 16 bits cannot
    /// hold is their end.
    #[must_use]
    pub const fn permille_of_peak(self) -> i16 {
        let raw = match self.positive {
            Rotation::Clockwise => self.raw as i32,
            Rotation::CounterClockwise => -(self.raw as i32),
        };
        let permille = raw * 1_000 / self.full_scale.get() as i32;
        if permille > i16::MAX as i32 {
            i16::MAX
        } else if permille < i16::MIN as i32 {
            i16::MIN
        } else {
            permille as i16
        }
    }

    /// More than the peak current, which the documents exclude: the revision, the scale or the reply is another one.
    #[must_use]
    pub const fn is_beyond_scale(self) -> bool {
        self.raw.unsigned_abs() > self.full_scale.get().unsigned_abs()
    }

    /// Current in ampere for a drive with this peak current, positive clockwise.
    #[must_use]
    pub fn current_a(self, peak_current_a: f64) -> f64 {
        self.of_peak() * peak_current_a
    }

    /// The torque of a share of the peak current, positive clockwise; `None` outside -1 ..= 1.
    #[must_use]
    pub fn from_share(
        of_peak: f64,
        full_scale: TorqueFullScale,
        positive: Rotation,
    ) -> Option<Self> {
        let signed = match positive {
            Rotation::Clockwise => of_peak,
            Rotation::CounterClockwise => -of_peak,
        };
        let raw = round_to_i32(signed * f64::from(full_scale.get()))?;
        let torque = Self {
            raw: i16::try_from(raw).ok()?,
            full_scale,
            positive,
        };
        (!torque.is_beyond_scale()).then_some(torque)
    }
}

/// Timing of one built-in point-to-point move.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct SCurve {
    /// Highest speed reached, in rpm: below the limit when the move is too short to reach it.
    pub peak_speed_rpm: f64,
    /// Acceleration and deceleration in rpm/s.
    pub acceleration_rpm_s: f64,
    /// Distance in motor turns, not negative.
    pub distance_turns: f64,
    /// Time to reach the peak speed, in seconds; the same to stop.
    pub acceleration_time_s: f64,
    /// Turns while accelerating; the same while stopping.
    pub acceleration_turns: f64,
    /// Time at peak speed, in seconds.
    pub constant_speed_time_s: f64,
    /// Time of the whole move, in seconds.
    pub total_time_s: f64,
}

impl SCurve {
    /// The timing of a move by `command_counts` (DYN2 manual A1.8 section 7, worked example).
    ///
    /// The manual gives nothing for moves too short to reach the top speed: they are a triangle here. Like the
    /// manual's numbers these ignore the smoothing of the curve.
    #[must_use]
    pub fn new(
        command_counts: i32,
        max_speed: MaxSpeed,
        max_acceleration: MaxAcceleration,
        gear: GearNumber,
    ) -> Self {
        let limit_rpm = max_speed_rpm(max_speed, gear);
        let acceleration_rpm_s = max_acceleration_rpm_s(max_acceleration, gear);
        let distance_turns = motor_counts(command_counts, gear).abs() / ENCODER_COUNTS_PER_TURN;
        let acceleration = acceleration_rpm_s / 60.0;
        let speed = square_root(distance_turns * acceleration).min(limit_rpm / 60.0);
        let acceleration_time_s = speed / acceleration;
        let acceleration_turns = (speed * acceleration_time_s).min(distance_turns) / 2.0;
        let cruise_turns = distance_turns - 2.0 * acceleration_turns;
        let constant_speed_time_s = if speed > 0.0 {
            cruise_turns / speed
        } else {
            0.0
        };
        Self {
            peak_speed_rpm: speed * 60.0,
            acceleration_rpm_s,
            distance_turns,
            acceleration_time_s,
            acceleration_turns,
            constant_speed_time_s,
            total_time_s: 2.0 * acceleration_time_s + constant_speed_time_s,
        }
    }
}

/// The largest parameter 1 ..= 127 that fits.
fn largest<T: Copy, E>(new: impl Fn(i32) -> Result<T, E>, fits: impl Fn(T) -> bool) -> Option<T> {
    (1..=127)
        .rev()
        .filter_map(|parameter| new(parameter).ok())
        .find(|&parameter| fits(parameter))
}

/// Half away from zero; `None` beyond 32 bit or not a number.
fn round_to_i32(x: f64) -> Option<i32> {
    let rounded = x + 0.5_f64.copysign(x);
    let inside = rounded > f64::from(i32::MIN) - 1.0 && rounded < f64::from(i32::MAX) + 1.0;
    inside.then_some(rounded as i32)
}

/// Square root by Newton's method from above, which falls until it stands still.
fn square_root(x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let mut root = if x > 1.0 { x } else { 1.0 };
    loop {
        let next = 0.5 * (root + x / root);
        if next >= root {
            return root;
        }
        root = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const GEAR_1: i32 = 4096;

    fn close(actual: f64, expected: f64, tolerance: f64) -> bool {
        (actual - expected).abs() <= tolerance
    }

    #[test]
    fn the_gear_divides_speed_and_acceleration() {
        // (48 + 3)^2 / 16 * 12.21 = 1984.9 r/min, 30 * 635.78 = 19073.4 r/min per second.
        for (gear, share) in [(4_096, 1.0), (8_192, 0.5), (2_048, 2.0)] {
            let gear = GearNumber::new(gear).unwrap();
            let speed = max_speed_rpm(MaxSpeed::new(48).unwrap(), gear);
            assert!(close(speed, 1_984.9 * share, 0.1), "{speed}");
            let acceleration = max_acceleration_rpm_s(MaxAcceleration::new(30).unwrap(), gear);
            assert!(close(acceleration, 19_073.4 * share, 0.1), "{acceleration}");
        }
    }

    #[test]
    fn steps_of_the_on_position_range_are_of_16_384_in_a_turn() {
        let degrees = |range| on_position_degrees(OnPosRange::new(range).unwrap());
        assert!(close(degrees(1), 0.022, 0.000_1));
        assert!(close(degrees(127), 2.790_5, 0.000_1));
    }

    #[test]
    fn a_soft_start_is_shorter_with_the_square_of_the_parameter() {
        let parameter = |number| MaxAcceleration::new(number).unwrap();
        assert!(close(soft_start_10_90_s(parameter(1)), 59.98, 1e-9));
        assert!(close(soft_start_10_90_s(parameter(10)), 0.599_8, 1e-9));
        assert!(close(soft_start_s(parameter(10)), 0.719_76, 1e-9));
    }

    #[test]
    fn the_corner_of_the_torque_filter_rises_with_its_constant() {
        let corner = |constant| torque_filter_rad_s(TorqueFilter::new(constant).unwrap());
        assert!(close(corner(1), 26.0, 1e-9));
        assert!(close(corner(100), 2_600.0, 1e-9));
    }

    #[test]
    fn numbers_are_rounded_half_away_from_zero_and_refused_beyond_32_bits() {
        let rounded = [2.5, -2.5, 2.4, -2.4, 0.0].map(round_to_i32);
        assert_eq!(rounded, [Some(3), Some(-3), Some(2), Some(-2), Some(0)]);
        let (min, max) = (f64::from(i32::MIN), f64::from(i32::MAX));
        assert_eq!(round_to_i32(min - 0.4), Some(i32::MIN));
        assert_eq!(round_to_i32(max + 0.4), Some(i32::MAX));
        for beyond in [min - 0.5, max + 0.5, f64::NAN, f64::INFINITY] {
            assert_eq!(round_to_i32(beyond), None, "{beyond}");
        }
    }

    #[test]
    fn a_turn_has_four_counts_for_each_unit_of_the_gear_number() {
        let counts = [500, 4_096, 16_384]
            .map(|number| command_counts_per_turn(GearNumber::new(number).unwrap()));
        assert_eq!(counts, [2_000, 16_384, 65_536]);
    }

    #[test]
    fn worked_example_of_the_manual() {
        // DYN2 manual A1.8 section 7: MaxSpd 48, MaxAcl 30, 140000 counts at gear 4096.
        let move_ = SCurve::new(
            140_000,
            MaxSpeed::new(48).unwrap(),
            MaxAcceleration::new(30).unwrap(),
            GearNumber::new(GEAR_1).unwrap(),
        );
        assert!(close(move_.peak_speed_rpm, 1985.0, 0.5));
        assert!(close(move_.acceleration_rpm_s, 19_073.0, 0.5));
        assert!(close(move_.acceleration_time_s, 0.104, 0.0005));
        assert!(close(move_.acceleration_turns, 1.72, 0.005));
        assert!(close(move_.constant_speed_time_s, 0.154, 0.0005));
        assert!(close(move_.total_time_s, 0.362, 0.0005));
    }

    #[test]
    fn a_short_move_is_a_triangle_and_no_move_takes_no_time() {
        let of = |counts| {
            SCurve::new(
                counts,
                MaxSpeed::MAX,
                MaxAcceleration::MIN,
                GearNumber::new(GEAR_1).unwrap(),
            )
        };
        let short = of(-1000);
        assert!(short.constant_speed_time_s < 1e-12);
        assert!(close(
            2.0 * short.acceleration_turns,
            short.distance_turns,
            1e-12
        ));
        assert_eq!(of(0).total_time_s, 0.0);
    }

    #[test]
    fn parameters_never_exceed_what_was_asked() {
        let gear = GearNumber::new(GEAR_1).unwrap();
        assert_eq!(
            max_speed_parameter(3000.0, gear).map(MaxSpeed::get),
            Some(59)
        );
        assert_eq!(max_speed_parameter(12.0, gear), None);
        assert_eq!(on_position_range(360.0).map(OnPosRange::get), Some(126));
        assert_eq!(gear_number(1.0).map(GearNumber::get), Some(4096));
        assert_eq!(gear_number(0.0), None);
    }

    #[test]
    fn thousandths_of_the_peak_have_the_sign_of_the_revision() {
        let torque = |raw, full_scale, positive| Torque {
            raw,
            full_scale,
            positive,
        };
        let new = |raw| torque(raw, TorqueFullScale::Raw981, Rotation::Clockwise);
        let old = |raw| torque(raw, TorqueFullScale::Raw700, Rotation::CounterClockwise);
        let permille = |torque: Torque| torque.permille_of_peak();
        assert_eq!([-157, 0, 981].map(new).map(permille), [-160, 0, 1_000]);
        assert_eq!([-157, 0, 700].map(old).map(permille), [224, 0, -1_000]);
        assert_eq!(
            [i16::MIN, i16::MAX].map(old).map(permille),
            [32_767, -32_768]
        );
    }

    #[test]
    fn torque_of_the_documents_example() {
        // 1.6A section 6, #14 with the corrected factor (D29): -157 of 981 at 20 A is 3.2 A counter-clockwise.
        let torque = Torque {
            raw: -157,
            full_scale: TorqueFullScale::Raw981,
            positive: Rotation::Clockwise,
        };
        assert!(close(torque.current_a(20.0), -3.2, 0.05));
        // 1.2A section 6, #14: -157 of 700 at 20 A is 4.48 A clockwise.
        let older = Torque {
            raw: -157,
            full_scale: TorqueFullScale::Raw700,
            positive: Rotation::CounterClockwise,
        };
        assert!(close(older.current_a(20.0), 4.48, 0.01));
        for torque in [torque, older] {
            assert_eq!(
                Torque::from_share(torque.of_peak(), torque.full_scale, torque.positive),
                Some(torque)
            );
            assert_eq!(
                Torque::from_share(1.01, torque.full_scale, torque.positive),
                None
            );
        }
    }

    proptest! {
        #[test]
        fn square_root_squares_back(x in 1e-9_f64..1e12) {
            let root = square_root(x);
            prop_assert!(close(root * root, x, x * 1e-14));
        }

        #[test]
        fn parameters_come_back(parameter in 1..=127_i32, gear in 500..=16_384_i32) {
            let gear = GearNumber::new(gear).unwrap();
            let speed = MaxSpeed::new(parameter).unwrap();
            prop_assert_eq!(max_speed_parameter(max_speed_rpm(speed, gear), gear), Some(speed));
            let acceleration = MaxAcceleration::new(parameter).unwrap();
            prop_assert_eq!(
                max_acceleration_parameter(max_acceleration_rpm_s(acceleration, gear), gear),
                Some(acceleration)
            );
            prop_assert_eq!(gear_number(gear_ratio(gear)), Some(gear));
        }

        #[test]
        fn counts_come_back(counts in -134_217_728..=134_217_727_i32, gear in 500..=16_384_i32) {
            let gear = GearNumber::new(gear).unwrap();
            prop_assert_eq!(command_counts(motor_counts(counts, gear), gear), Some(counts));
        }
    }
}
