//! Which settings make a board that works.

#[allow(dead_code, reason = "shared with other tests")]
mod sample;

use board_settings::{
    AxisSettings, Board, BusSettings, Dialect, Inputs, Kind, Polls, ReadBack, Refusal, Settings,
    Travel,
};
use can_motion::{DialectChoice, GroupId, Master, ReadBackScale, ServoMaster};
use proptest::prelude::*;
use sample::{any_settings, axis, settings};
use trajectory::Position;

const BOARD: Board = Board::STM32F405;

type Told = (Kind, Option<u8>, i64, i64);

fn refused(settings: &Settings) -> Told {
    let Refusal {
        kind,
        axis,
        expected,
        actual,
    } = settings.configs(&BOARD).unwrap_err();
    (kind, axis, expected, actual)
}

/// The second of three axes, changed.
fn with_axis(change: impl FnOnce(&mut AxisSettings)) -> Settings {
    let mut changed = settings(3);
    change(&mut changed.axes[1]);
    changed
}

fn with_bus(change: impl FnOnce(&mut BusSettings)) -> Settings {
    let mut changed = settings(3);
    change(&mut changed.bus);
    changed
}

#[test]
fn what_was_said_is_what_the_master_gets() {
    let mut said = settings(2);
    said.inputs = Inputs {
        enable_fitted: false,
    };
    let axis = &mut said.axes[1];
    axis.jerk_rpm_per_s2 = Some(20_000);
    axis.read_back = ReadBack::MovementPositions;
    axis.dialect = Dialect::V1_2A;
    axis.load_can_fall = true;
    axis.polls.torque_us = 50_000;
    axis.drift_tolerance_counts = Some(40);
    let configs = said.configs(&BOARD).unwrap();
    assert_eq!(configs.master.cycle_us, 1_000);
    assert_eq!(configs.master.bus.bit_rate.kbit_per_s(), 1_000);
    assert!(!configs.enable_fitted);
    let axis = &configs.axes[1];
    assert_eq!((axis.drive.get(), axis.gear.get()), (2, 4_096));
    assert_eq!(axis.group, GroupId(0));
    assert_eq!(axis.dialect, DialectChoice::Fixed(dyn_can::Dialect::V1_2A));
    assert!(axis.load_can_fall && !axis.unwatched);
    assert_eq!(axis.read_back, ReadBackScale::movement_positions(axis.gear));
    assert_eq!(axis.polls.torque_us, Some(50_000));
    assert_eq!(axis.polls.speed_us, None);
    // 150 r/min: 40.96 counts in a cycle; 1000 r/min per s: 0.273, 69.9 of 256 parts; 90 degrees: 4096 counts.
    assert_eq!(axis.limits.max_step.get(), 40);
    assert_eq!(axis.limits.max_step_change.per_256_cycles(), 69);
    assert_eq!(axis.limits.travel.max_counts, 4_096);
    assert_eq!(axis.limits.following_error_counts, 8_192);
    assert_eq!(axis.limits.drift_tolerance_counts, 40);
    let limits = &configs.limits[1];
    assert_eq!(limits.motion.velocity(), 40.0);
    assert_eq!(limits.motion.acceleration(), 69.0 / 256.0);
    // 20000 r/min per s²: 333.3 turns per s³ of 16384 counts, 1e-9.
    assert!((limits.motion.jerk() - 0.005_461).abs() < 1e-5);
    assert_eq!(limits.lowest, Position::from_counts(-4_096));
    assert_eq!(configs.limits[0].motion.jerk(), f32::INFINITY);
    assert!(ServoMaster::<14>::with_plan(&configs.plan()).is_ok());
}

#[test]
fn what_cannot_be_is_refused_with_number_axis_expected_and_actual() {
    let travel = |min, max| Travel::Counts { min, max };
    let cases: Vec<(Settings, Told)> = vec![
        (settings(0), (Kind::AxisCount, None, 1, 0)),
        (
            with_axis(|axis| axis.group = 3),
            (Kind::Group, Some(1), 0, 3),
        ),
        (
            with_axis(|axis| axis.drive = 0),
            (Kind::Drive, Some(1), 1, 0),
        ),
        (
            with_axis(|axis| axis.drive = 64),
            (Kind::Drive, Some(1), 63, 64),
        ),
        (
            with_axis(|axis| axis.drive = 1),
            (Kind::Order, Some(1), 2, 1),
        ),
        (
            with_axis(|axis| axis.drive = 9),
            (Kind::Order, Some(2), 10, 3),
        ),
        (
            with_axis(|axis| axis.gear = 499),
            (Kind::Gear, Some(1), 500, 499),
        ),
        (
            with_axis(|axis| axis.gear = 16_385),
            (Kind::Gear, Some(1), 16_384, 16_385),
        ),
        (
            with_axis(|axis| axis.speed_rpm = 3),
            (Kind::Speed, Some(1), 4, 3),
        ),
        (
            with_axis(|axis| axis.speed_rpm = 60_004),
            (Kind::Speed, Some(1), 60_003, 60_004),
        ),
        (
            with_axis(|axis| axis.acceleration_rpm_per_s = 14),
            (Kind::Acceleration, Some(1), 15, 14),
        ),
        (
            with_axis(|axis| axis.acceleration_rpm_per_s = 60_000_015),
            (Kind::Acceleration, Some(1), 60_000_014, 60_000_015),
        ),
        (
            with_axis(|axis| axis.jerk_rpm_per_s2 = Some(0)),
            (Kind::Jerk, Some(1), 1, 0),
        ),
        (
            with_axis(|axis| axis.travel = travel(5, 4)),
            (Kind::Travel, Some(1), 5, 4),
        ),
        (
            with_axis(|axis| axis.travel = travel(0, 1 << 27)),
            (Kind::Travel, Some(1), (1 << 27) - 1, 1 << 27),
        ),
        (
            with_axis(|axis| {
                axis.travel = Travel::Millidegrees {
                    min: i64::MIN,
                    max: 0,
                }
            }),
            (Kind::Travel, Some(1), -(1 << 27), i32::MIN.into()),
        ),
        (
            with_axis(|axis| {
                axis.read_back = ReadBack::Ratio {
                    read_back_counts: 0,
                    command_counts: 1,
                }
            }),
            (Kind::ReadBack, Some(1), 1, 0),
        ),
        (
            with_axis(|axis| {
                axis.read_back = ReadBack::MovementPositions;
                axis.travel = travel(0, 1 << 26);
            }),
            (Kind::ReadBackRange, Some(1), (1 << 27) - 1, 1 << 26),
        ),
        (
            with_axis(|axis| axis.drift_tolerance_counts = Some(8_193)),
            (Kind::Tolerance, Some(1), 8_192, 8_193),
        ),
        (
            with_axis(|axis| axis.polls.status_us = 0),
            (Kind::Unwatched, Some(1), 1_000, 0),
        ),
        (
            with_axis(|axis| axis.polls.speed_us = 999),
            (Kind::PollPeriod, Some(1), 1_000, 999),
        ),
        (
            with_axis(|axis| axis.polls.speed_us = 70_000_000),
            (Kind::PollPeriod, Some(1), 65_535_000, 70_000_000),
        ),
        (
            with_bus(|bus| bus.bit_rate_kbit_per_s = 100),
            (Kind::BitRate, None, 1_000, 100),
        ),
        (
            with_bus(|bus| bus.bit_rate_kbit_per_s = 0),
            (Kind::BitRate, None, 1_000, 0),
        ),
        (
            with_bus(|bus| bus.bit_rate_kbit_per_s = 800),
            (Kind::BoardBitRate, None, 1_000, 800),
        ),
        (
            with_bus(|bus| bus.requests_per_cycle = 0),
            (Kind::Requests, None, 1, 0),
        ),
        (
            with_bus(|bus| (bus.response_min_us, bus.response_max_us) = (600, 500)),
            (Kind::ResponseWindow, None, 600, 500),
        ),
    ];
    for (settings, expected) in cases {
        assert_eq!(refused(&settings), expected, "{settings:?}");
    }
    let named = Settings {
        name: "a\n".parse().unwrap(),
        ..settings(1)
    };
    assert_eq!(refused(&named), (Kind::Name, None, 0, 10));
    let (kind, axis, expected, actual) = refused(&with_bus(|bus| bus.bit_rate_kbit_per_s = 20));
    assert_eq!((kind, axis, expected), (Kind::Overload, Some(0), 20));
    assert!(actual > 20);
    let mut late = settings(1);
    (late.bus.response_min_us, late.bus.response_max_us) = (9_990, 9_990);
    assert_eq!(refused(&late).0, Kind::LateReply);
}

#[test]
fn the_board_decides_which_bit_rates_and_which_cycle_there_are() {
    let fast = with_bus(|bus| bus.bit_rate_kbit_per_s = 800);
    assert!(fast.configs(&Board::STM32G474).is_ok());
    let board = Board {
        cycle_us: 200,
        ..BOARD
    };
    let refusal = settings(1).configs(&board).unwrap_err();
    assert_eq!(
        (refusal.kind, refusal.expected, refusal.actual),
        (Kind::Cycle, 250, 200)
    );
    assert_eq!(Board::named("stm32g474"), Some(Board::STM32G474));
    assert_eq!(Board::named("STM32"), None);
}

#[test]
fn the_bus_plan_says_which_axis_is_too_much() {
    assert!(settings(9).configs(&BOARD).is_ok());
    let (kind, axis, expected, actual) = refused(&settings(14));
    assert_eq!(
        (kind, axis, expected),
        (Kind::LateSetPoint, Some(12), 1_000)
    );
    assert!(actual > 1_000);
    // Without polls fourteen fit.
    let mut blind = settings(14);
    for axis in &mut blind.axes {
        axis.unwatched = true;
        axis.polls = Polls {
            status_us: 0,
            position_us: 0,
            ..Polls::DEFAULT
        };
    }
    assert!(blind.configs(&BOARD).is_ok());
}

proptest! {
    /// What passes the check is taken by a master as it is, and the limits of the link are within those of the master.
    #[test]
    fn what_is_checked_works(mut settings in any_settings(), slow in any::<[(u32, u32); 14]>()) {
        for (axis, (speed, acceleration)) in settings.axes.iter_mut().zip(slow) {
            let fair = sample::axis(axis.drive % 64);
            axis.gear = 500 + axis.gear % 15_885;
            axis.speed_rpm = 60 + speed % 3_000;
            axis.acceleration_rpm_per_s = 200 + acceleration % 100_000;
            axis.polls = fair.polls;
            axis.travel = fair.travel;
            axis.read_back = fair.read_back;
            axis.drift_tolerance_counts = None;
            axis.following_error_counts = None;
        }
        let mut axes: Vec<_> = settings.axes.iter().copied().collect();
        axes.sort_by_key(|axis| axis.drive);
        axes.dedup_by_key(|axis| axis.drive);
        settings.axes = axes.into_iter().collect();
        settings.bus = BusSettings::new(1_000);
        if let Ok(configs) = settings.configs(&BOARD) {
            let master: Result<ServoMaster<14>, _> = Master::with_plan(&configs.plan());
            prop_assert!(master.is_ok());
            for ((axis, config), limits) in settings.axes.iter().zip(&configs.axes).zip(&configs.limits) {
                prop_assert_eq!(config.drive.get(), axis.drive);
                let step = config.limits.max_step.get();
                prop_assert_eq!(limits.motion.velocity(), f32::from(step));
                let counts = u64::from(axis.speed_rpm) * 4 * u64::from(axis.gear) / 60_000;
                prop_assert_eq!(u64::from(step), counts);
            }
        }
    }

    #[test]
    fn no_settings_panic(settings in any_settings()) {
        let _ = settings.configs(&BOARD);
    }
}

#[test]
fn an_axis_of_the_sample_works() {
    assert_eq!(axis(1).drive, 1);
    assert!(settings(1).configs(&BOARD).is_ok());
}
