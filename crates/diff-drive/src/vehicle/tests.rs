use super::*;
use proptest::prelude::*;

const CYCLE_US: u64 = 10_000;

fn geometry() -> Geometry {
    Geometry::new(0.4, 0.1, 4_096).unwrap()
}

fn vehicle(most_rpm: f64, rpm_per_s: f64, resolution: u16) -> DiffDrive {
    let limits = Limits::new(most_rpm, rpm_per_s, 600.0, 200_000).unwrap();
    DiffDrive::new(geometry(), limits, resolution)
}

fn twist(v: f64, omega: f64) -> Twist {
    Twist::new(v, omega).unwrap()
}

#[test]
fn a_twist_is_two_speeds() {
    // 2 pi 0.1 m a turn: 0.628 m/s is 60 r/min; 1 rad/s on 0.2 m is 19.1 r/min.
    let speeds = geometry().wheel_speeds(twist(0.628_318_530_717_958_6, 1.0));
    assert!(
        (speeds.left_rpm - (60.0 - 19.098_593)).abs() < 1e-5,
        "{speeds:?}"
    );
    assert!(
        (speeds.right_rpm - (60.0 + 19.098_593)).abs() < 1e-5,
        "{speeds:?}"
    );
}

#[test]
fn nothing_moves_before_the_first_twist_and_after_a_stand() {
    let mut vehicle = vehicle(100.0, 100.0, 1);
    assert_eq!(vehicle.step(0), Command::default());
    vehicle.set_twist(0, twist(1.0, 0.0));
    for cycle in 1..10 {
        vehicle.step(cycle * CYCLE_US);
    }
    vehicle.stand();
    assert_eq!(vehicle.step(10 * CYCLE_US), Command::default());
}

/// Half a number was left over when it came to rest: it is not told forward and back for ever.
#[test]
fn a_wheel_stands_while_the_other_one_turns() {
    let mut vehicle = vehicle(100.0, 50.0, 1);
    vehicle.step(0);
    vehicle.set_twist(0, twist(1.0, 0.0));
    for cycle in 1..=3 {
        vehicle.step(cycle * CYCLE_US);
    }
    // About the left wheel; the right one at 2 r/min.
    let omega = 2.0 * core::f64::consts::TAU * 0.1 / 60.0 / 0.4;
    vehicle.set_twist(3 * CYCLE_US, twist(omega * 0.2, omega));
    let commands = (4..20).map(|cycle| vehicle.step(cycle * CYCLE_US));
    let commands: std::vec::Vec<Command> = commands.collect();
    assert!(
        commands[4..].iter().all(|command| command.left == 0),
        "{commands:?}"
    );
    assert!(commands.iter().any(|command| command.right != 0));
}

#[test]
fn silence_stops_the_vehicle_on_its_curve_and_says_so() {
    let mut vehicle = vehicle(100.0, 1_000.0, 10);
    vehicle.set_twist(0, twist(0.4, 0.8));
    let mut curves = std::vec::Vec::new();
    let mut last = Command::default();
    for cycle in 0..60 {
        last = vehicle.step(cycle * CYCLE_US);
        let expected = if cycle <= 20 {
            Phase::Following
        } else {
            Phase::TimedOut
        };
        assert_eq!(last.phase, expected, "cycle {cycle}");
        if last.phase == Phase::TimedOut && last.left > 50 {
            curves.push(f64::from(last.left) / f64::from(last.right));
        }
    }
    assert_eq!((last.left, last.right), (0, 0));
    let asked = geometry().wheel_speeds(twist(0.4, 0.8));
    assert!(curves.len() > 3);
    for curve in curves {
        assert!(
            (curve - asked.left_rpm / asked.right_rpm).abs() < 0.02,
            "{curve}"
        );
    }
    // The next twist ends it.
    vehicle.set_twist(600_000, twist(0.1, 0.0));
    assert_eq!(vehicle.step(600_000).phase, Phase::Following);
}

#[test]
fn a_pause_of_the_caller_is_no_leap() {
    let mut vehicle = vehicle(1_000.0, 100.0, 1);
    vehicle.step(0);
    vehicle.set_twist(10_000_000, twist(5.0, 0.0));
    // Ten seconds without a step count as a tenth of one.
    assert_eq!(vehicle.step(10_000_000).left, 10);
    // Time that runs backwards is no time.
    assert_eq!(vehicle.step(5_000_000).left, 10);
}

#[test]
fn numbers_that_are_none_are_refused() {
    for (v, omega) in [
        (f64::NAN, 0.0),
        (0.0, f64::NAN),
        (f64::INFINITY, 0.0),
        (0.0, -1_001.0),
    ] {
        assert!(Twist::new(v, omega).is_err(), "{v} {omega}");
    }
    assert!(Geometry::new(f64::NAN, 0.1, 4_096).is_err());
    assert!(Geometry::new(0.4, 0.0, 4_096).is_err());
    assert!(Geometry::new(0.4, 0.1, 0).is_err());
    assert!(Limits::new(100.0, 0.0, 1.0, 1_000_000).is_err());
    assert!(Limits::new(100.0, 1.0, 1.0, 999).is_err());
    let text = std::format!("{}", Twist::new(0.0, 2e3).unwrap_err());
    assert_eq!(text, "omega in rad/s must be -1000..=1000, got 2000");
}

proptest! {
    /// A limit makes the vehicle slower, and never another curve.
    #[test]
    fn limits_keep_the_curve(
        v in -5.0..5.0_f64,
        omega in -20.0..20.0_f64,
        most_rpm in 1.0..500.0_f64,
    ) {
        let asked = geometry().wheel_speeds(twist(v, omega));
        let limited = asked.within(most_rpm);
        prop_assert!(limited.fastest_rpm() <= most_rpm * (1.0 + 1e-12));
        let cross = asked.left_rpm * limited.right_rpm - asked.right_rpm * limited.left_rpm;
        prop_assert!(cross.abs() <= 1e-9 * (1.0 + asked.fastest_rpm() * most_rpm), "{cross}");
        prop_assert!(asked.left_rpm * limited.left_rpm >= 0.0);
        if asked.fastest_rpm() <= most_rpm {
            prop_assert_eq!(asked, limited);
        }
    }

    /// Neither wheel changes faster than it may, whatever is asked for, and the way adds up within one number of the drive.
    #[test]
    fn acceleration_is_kept_and_rounding_loses_no_way(
        twists in proptest::collection::vec((-1.0..1.0_f64, -3.0..3.0_f64), 1..30),
        resolution in 1..=10_u16,
    ) {
        let mut vehicle = vehicle(120.0, 200.0, resolution);
        let n = f64::from(resolution);
        let (mut sum, mut exact) = ((0_i64, 0_i64), (0.0, 0.0));
        let (mut now_us, mut before) = (0, (0, 0));
        for (v, omega) in twists {
            vehicle.set_twist(now_us, twist(v, omega));
            for _ in 0..15 {
                let command = vehicle.step(now_us);
                now_us += CYCLE_US;
                let most = 200.0 * n * CYCLE_US as f64 * 1e-6 + 2.0;
                prop_assert!(f64::from((command.left - before.0).abs()) <= most);
                prop_assert!(f64::from((command.right - before.1).abs()) <= most);
                prop_assert!(f64::from(command.left.abs()) <= 120.0 * n + 1.0);
                before = (command.left, command.right);
                sum = (sum.0 + i64::from(command.left), sum.1 + i64::from(command.right));
                exact = (exact.0 + vehicle.speeds.left_rpm * n, exact.1 + vehicle.speeds.right_rpm * n);
                if vehicle.speeds.fastest_rpm() > 0.0 {
                    prop_assert!((sum.0 as f64 - exact.0).abs() <= 1.0);
                    prop_assert!((sum.1 as f64 - exact.1).abs() <= 1.0);
                } else {
                    exact = (sum.0 as f64, sum.1 as f64);
                }
            }
        }
    }
}

proptest! {
    /// A limit between two numbers of the drives is not exceeded by what rounding has left over.
    #[test]
    fn no_target_is_faster_than_the_limit(
        most_rpm in prop_oneof![0.1..200.0_f64, Just(100.5), Just(0.5), Just(99.999)],
        resolution in 1..=10_u16,
        twists in proptest::collection::vec((-3.0..3.0_f64, -3.0..3.0_f64), 1..5),
    ) {
        let mut vehicle = vehicle(most_rpm, 1_000.0, resolution);
        vehicle.step(0);
        let mut now_us = 0;
        for (v, omega) in twists {
            for _ in 0..60 {
                vehicle.set_twist(now_us, twist(v, omega));
                now_us += CYCLE_US;
                let command = vehicle.step(now_us);
                for told in [command.left, command.right] {
                    let rpm = f64::from(told.abs()) / f64::from(resolution);
                    prop_assert!(rpm <= most_rpm + 1e-6, "{rpm} {most_rpm}");
                }
            }
        }
    }
}

#[test]
fn a_limit_of_whole_numbers_is_reached() {
    for (most_rpm, resolution, most) in [(100.5, 1, 100), (100.1, 10, 1_001), (28.7, 10, 287)] {
        let mut vehicle = vehicle(most_rpm, 10_000.0, resolution);
        vehicle.step(0);
        vehicle.set_twist(0, twist(-3.0, 0.0));
        for cycle in 1..20 {
            let command = vehicle.step(cycle * CYCLE_US);
            assert!(command.is_limited);
            if cycle > 5 {
                assert_eq!((command.left, command.right), (-most, -most));
            }
        }
    }
}
