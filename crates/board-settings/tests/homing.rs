//! Settings with homings: their bytes, their file, and what cannot work.

#[allow(dead_code, reason = "shared with other tests")]
mod sample;

use board_settings::file::{self, Place, read, write};
use board_settings::{
    AxisHoming, AxisSettings, Board, HomingDirection, HomingMethod, HomingSearch, HomingSettings,
    Kind, LONGEST, Polls, ReadBack, Refusal, Settings, SwitchLevel, Travel, VERSION,
};
use homing::{Config, Direction, HardStop, Homing, Level, Method, Switch, Watch};
use proptest::prelude::*;
use sample::{any_settings, axis, settings};
use trajectory::Position;

/// Four turns.
const WAY: u32 = 4 * 360_000;

fn search() -> HomingSearch {
    HomingSearch::new(HomingDirection::Negative, WAY)
}

/// An axis that goes to a stop, with its torque read.
fn homed(id: u8) -> AxisSettings {
    let mut homed = axis(id);
    homed.polls.torque_us = 20_000;
    homed.homing = Some(HomingSettings::stop(search()));
    homed
}

fn switch() -> HomingMethod {
    HomingMethod::Switch {
        search: search(),
        pin: 3,
        active: SwitchLevel::Low,
    }
}

/// Three axes, the second one homed.
fn with_homing(change: impl FnOnce(&mut AxisSettings, &mut HomingSettings)) -> Settings {
    let mut changed = settings(3);
    let mut axis = homed(2);
    let mut homing = axis.homing.unwrap();
    change(&mut axis, &mut homing);
    axis.homing = Some(homing);
    changed.axes[1] = axis;
    changed
}

fn with_search(change: impl FnOnce(&mut HomingSearch)) -> Settings {
    with_homing(|_, homing| {
        let mut way = search();
        change(&mut way);
        *homing = HomingSettings::stop(way);
    })
}

fn bytes(settings: &Settings) -> Vec<u8> {
    settings.write(&mut [0; LONGEST]).unwrap().to_vec()
}

#[test]
fn homings_stand_behind_the_axes_and_without_one_the_bytes_are_those_of_before() {
    let mut two = settings(2);
    let before = bytes(&two);
    assert_eq!(before[0], 1);
    assert_eq!(Settings::read(&before), Ok(two.clone()));
    two.axes[1].homing = Some(HomingSettings {
        order: 5,
        reference_millidegrees: -1,
        ..HomingSettings::stop(search())
    });
    let with = bytes(&two);
    assert_eq!(with[0], VERSION);
    assert_eq!(with[1..before.len()], before[1..]);
    #[rustfmt::skip]
    let golden = [
        0, // axis 0: none
        1, 1, // axis 1: a stop
        1, 15, 3, 0xAC, 0x02, // negative, 15 r/min, 3 r/min, 300 r/min per s
        0xA0, 0x06, 0xC8, 0xDF, 0x02, // 80 %, 45 degrees
        0x80, 0xF2, 0x57, 0xD0, 0x8C, 0x01, // 4 turns, back by 18 degrees
        0x96, 0x01, 0xB8, 0x17, // 15 %, 3 degrees
        5, 1, // order, reference
    ];
    assert_eq!(with[before.len()..], golden);
    assert_eq!(Settings::read(&with), Ok(two.clone()));
    two.axes[0].homing = Some(HomingSettings::new(HomingMethod::Here));
    two.axes[1].homing = Some(HomingSettings::new(switch()));
    let with = bytes(&two);
    let golden = [
        1, 0, 0, 0, 1, 2, 1, 15, 3, 0xAC, 0x02, 0xA0, 0x06, 0xC8, 0xDF, 0x02, 0x80, 0xF2, 0x57,
        0xD0, 0x8C, 0x01, 3, 0, 0, 0,
    ];
    assert_eq!(with[before.len()..], golden);
    for length in before.len()..with.len() {
        let refusal = Settings::read(&with[..length]).unwrap_err();
        assert_eq!(refusal.kind, Kind::Layout);
    }
    let behind = [with.as_slice(), &[0]].concat();
    assert_eq!(Settings::read(&behind).unwrap_err().kind, Kind::Behind);
}

#[test]
fn fourteen_axes_with_every_setting_of_a_machine_have_room_and_numbers_of_none_are_refused() {
    let mut many = settings(14);
    for (axis, id) in many.axes.iter_mut().zip(1..) {
        *axis = homed(id);
        (axis.speed_rpm, axis.acceleration_rpm_per_s) = (3_000, 100_000);
        axis.jerk_rpm_per_s2 = Some(100_000_000);
        axis.travel = Travel::Millidegrees {
            min: -36_000_000,
            max: 36_000_000,
        };
        axis.read_back = ReadBack::Ratio {
            read_back_counts: 65_536,
            command_counts: 16_384,
        };
        (axis.polls.speed_us, axis.polls.counter_us) = (100_000, 100_000);
        (axis.following_error_counts, axis.drift_tolerance_counts) = (Some(8_192), Some(1_000));
        let way = HomingSearch::new(HomingDirection::Positive, 36_000_000);
        axis.homing = Some(HomingSettings {
            order: 13,
            reference_millidegrees: -36_000_000,
            ..HomingSettings::stop(way)
        });
    }
    assert!(bytes(&many).len() <= LONGEST);
    for axis in &mut many.axes {
        axis.travel = Travel::Millidegrees {
            min: i64::MIN,
            max: i64::MAX,
        };
        axis.polls = Polls {
            status_us: u32::MAX,
            position_us: u32::MAX,
            torque_us: u32::MAX,
            speed_us: u32::MAX,
            counter_us: u32::MAX,
        };
    }
    let refusal = many.write(&mut [0; LONGEST]).unwrap_err();
    assert_eq!(refusal.kind, Kind::Room);
}

#[test]
fn what_was_said_is_what_is_searched() {
    let mut said = settings(3);
    said.axes[0] = homed(1);
    said.axes[2].homing = Some(HomingSettings {
        order: 7,
        reference_millidegrees: 45_000,
        ..HomingSettings::new(switch())
    });
    let configs = said.configs(&Board::STM32F405).unwrap();
    let [Some(first), None, Some(third)] = configs.homings[..] else {
        panic!("{:?}", configs.homings);
    };
    // 15 r/min of 16384 counts: 4.096 counts in a cycle, 3 r/min 0.8192; 300 r/min per s: 0.08192.
    let limits = |velocity| trajectory::Limits::new(velocity, 0.081_92, 0.001_638_4).unwrap();
    let is = |actual: trajectory::Limits, expected: trajectory::Limits| {
        let near = |actual: f32, expected: f32| (actual / expected - 1.0).abs() < 1e-5;
        near(actual.velocity(), expected.velocity())
            && near(actual.acceleration(), expected.acceleration())
            && near(actual.jerk(), expected.jerk())
    };
    assert!(is(first.search.search, limits(4.096)));
    assert!(is(first.search.slow, limits(0.819_2)));
    let travel = homing::Travel {
        min_counts: -4_096,
        max_counts: 4_096,
    };
    let expected = AxisHoming {
        search: Config {
            method: Method::HardStop(HardStop {
                direction: Direction::Negative,
                contact_permille: 150,
                most_permille: 800,
                contact_counts: 136,
                most_counts: 2_048,
                repeat_counts: 136,
            }),
            cycle_us: 1_000,
            search: first.search.search,
            slow: first.search.slow,
            way_counts: 65_536,
            back_off_counts: 819,
            reference_counts: 0,
            travel,
            watch: Watch::DEFAULT,
        },
        switch_pin: None,
        order: 0,
        reach: homing::Travel {
            min_counts: 1 - (1 << 27),
            max_counts: (1 << 27) - 1,
        },
    };
    assert_eq!(first, expected);
    let expected = Method::Switch(Switch {
        direction: Direction::Negative,
        operated: Level::Low,
        most_counts: 2_048,
        // The torque is not read.
        most_permille: None,
    });
    assert_eq!(third.search.method, expected);
    assert_eq!((third.switch_pin, third.order), (Some(3), 7));
    assert_eq!(third.search.reference_counts, 2_048);
    for found in [first, third] {
        assert!(Homing::new(found.search, 0).is_ok());
    }
    // The master lets a drive stand anywhere; what is streamed keeps the travel, from the origin.
    let whole = (1 << 27) - 1;
    assert_eq!(configs.axes[0].limits.travel.min_counts, -whole);
    assert_eq!(configs.axes[0].limits.travel.max_counts, whole);
    assert_eq!(configs.axes[1].limits.travel.max_counts, 4_096);
    assert_eq!(configs.limits[0].highest, Position::from_counts(4_096));
    assert_eq!(configs.limits[0].lowest, Position::from_counts(-4_096));
}

#[test]
fn a_drive_that_reports_in_fine_counts_may_stand_where_they_can_be_read() {
    let fine = with_homing(|axis, _| axis.read_back = ReadBack::MovementPositions);
    let configs = fine.configs(&Board::STM32F405).unwrap();
    // Four of them are a command count.
    assert_eq!(configs.axes[1].limits.travel.max_counts, (1 << 25) - 1);
}

#[test]
fn each_value_that_cannot_work_is_refused_with_its_number() {
    type Case = (Settings, Kind, i64, i64);
    let cases: Vec<Case> = vec![
        (
            with_search(|way| way.speed_rpm = 0),
            Kind::HomingSpeed,
            1,
            0,
        ),
        (
            with_search(|way| way.speed_rpm = 151),
            Kind::HomingSpeed,
            150,
            151,
        ),
        (
            with_search(|way| way.slow_speed_rpm = 16),
            Kind::HomingSlowSpeed,
            15,
            16,
        ),
        (
            with_search(|way| way.acceleration_rpm_per_s = 1_001),
            Kind::HomingAcceleration,
            1_000,
            1_001,
        ),
        (
            with_search(|way| way.most_torque_permille = 1_001),
            Kind::HomingMostTorque,
            1_000,
            1_001,
        ),
        (
            with_search(|way| way.most_torque_permille = 149),
            Kind::HomingTorque,
            149,
            150,
        ),
        // 3 degrees are 136 counts.
        (
            with_search(|way| way.most_millidegrees = 3_000),
            Kind::HomingContact,
            135,
            136,
        ),
        (
            with_search(|way| way.most_millidegrees = 180_000),
            Kind::HomingMost,
            8_191,
            8_192,
        ),
        (
            with_homing(|axis, _| axis.following_error_counts = Some(2_048)),
            Kind::HomingMost,
            2_047,
            2_048,
        ),
        (
            with_search(|way| way.way_millidegrees = 0),
            Kind::HomingWay,
            1,
            0,
        ),
        (
            with_search(|way| way.way_millidegrees = 1_474_560_022),
            Kind::HomingWay,
            1 << 26,
            (1 << 26) + 1,
        ),
        (
            with_search(|way| way.back_off_millidegrees = WAY + 22),
            Kind::HomingBackOff,
            65_536,
            65_537,
        ),
        (
            with_search(|way| way.back_off_millidegrees = 0),
            Kind::HomingBackOff,
            1,
            0,
        ),
        // 90 degrees are 4096 counts, the back-off 819.
        (
            with_homing(|_, homing| homing.reference_millidegrees = 90_000),
            Kind::HomingRest,
            4_096,
            4_915,
        ),
        (
            with_homing(|axis, _| axis.polls.position_us = 50_001),
            Kind::HomingPositionPoll,
            50_000,
            50_001,
        ),
        (
            with_homing(|axis, homing| {
                *homing = HomingSettings::new(HomingMethod::Here);
                axis.polls.position_us = 0;
            }),
            Kind::HomingPositionPoll,
            50_000,
            0,
        ),
        (
            with_homing(|axis, _| axis.polls.torque_us = 0),
            Kind::HomingTorquePoll,
            50_000,
            0,
        ),
        (
            with_homing(|axis, homing| {
                *homing = HomingSettings::new(switch());
                axis.polls.torque_us = 50_001;
            }),
            Kind::HomingTorquePoll,
            50_000,
            50_001,
        ),
        // 42 degrees in 0.2 s are 35 r/min.
        (
            with_search(|way| way.speed_rpm = 36),
            Kind::HomingTooFast,
            35,
            36,
        ),
        (
            with_homing(|axis, _| axis.travel = Travel::Counts { min: 1, max: 0 }),
            Kind::Travel,
            1,
            0,
        ),
        (
            with_homing(|axis, _| {
                axis.travel = Travel::Counts {
                    min: -(1 << 27) - 1,
                    max: 0,
                }
            }),
            Kind::Travel,
            -(1 << 27),
            -(1 << 27) - 1,
        ),
    ];
    for (settings, kind, expected, actual) in cases {
        let refusal = settings.configs(&Board::STM32F405).unwrap_err();
        let told = Refusal {
            kind,
            axis: Some(1),
            expected,
            actual,
        };
        assert_eq!(refusal, told);
    }
    // PC12 of the F405 has its status LED.
    for (board, last) in [(Board::STM32F405, 11), (Board::STM32G474, 12)] {
        for (pin, nearest) in [
            (2, Some(3)),
            (3, None),
            (last, None),
            (last + 1, Some(last.into())),
        ] {
            let on_pin = with_homing(|_, homing| {
                homing.method = HomingMethod::Switch {
                    search: search(),
                    pin,
                    active: SwitchLevel::High,
                };
            });
            let refusal = on_pin.configs(&board).err();
            let expected = nearest.map(|nearest| (Kind::HomingPin, nearest, i64::from(pin)));
            let told = |refusal: Refusal| (refusal.kind, refusal.expected, refusal.actual);
            assert_eq!(refusal.map(told), expected, "{}", board.name);
        }
    }
}

/// An axis would stop at the switch of another one.
#[test]
fn a_switch_is_that_of_one_axis() {
    let with_pins = |pins: &[Option<u8>]| {
        let mut settings = with_homing(|_, _| {});
        settings.axes.clear();
        for (place, pin) in (0..).zip(pins) {
            let mut axis = homed(place + 1);
            let homing = axis.homing.as_mut().expect("it is homed");
            homing.method = pin.map_or(HomingMethod::Here, |pin| HomingMethod::Switch {
                search: search(),
                pin,
                active: SwitchLevel::High,
            });
            settings.axes.push(axis).expect("there is room");
        }
        let refusal = settings.configs(&Board::STM32G474).err();
        refusal.map(|refusal| {
            let Refusal {
                kind,
                axis,
                expected,
                actual,
            } = refusal;
            (kind, axis, expected, actual)
        })
    };
    assert_eq!(with_pins(&[Some(3), None, Some(4), None]), None);
    let refusal = with_pins(&[Some(3), None, Some(4), Some(3)]);
    assert_eq!(refusal, Some((Kind::HomingPinTaken, Some(3), 5, 3)));
    let refusal = with_pins(&[Some(12), Some(12)]);
    assert_eq!(refusal, Some((Kind::HomingPinTaken, Some(1), 3, 12)));
}

const STOP: &str = "\
format = 1

[bus]
bit_rate_kbit_per_s = 1000

[[axis]]
drive = 1
gear_number = 4096
speed_rpm = 150
acceleration_rpm_per_s = 1000
travel_min_millidegrees = -90000
travel_max_millidegrees = 90000
torque_poll_us = 20000
homing = \"stop\"
homing_direction = \"negative\"
homing_way_millidegrees = 1440000
";

#[test]
fn what_must_be_said_in_a_file_is_enough() {
    let mut expected = settings(1);
    expected.name = Default::default();
    expected.axes[0] = homed(1);
    assert_eq!(read(STOP).unwrap().settings, expected);
    let switch = STOP.replace(
        "homing = \"stop\"",
        "homing = \"switch\"\nhoming_switch_pin = 3\nhoming_switch_active = \"low\"",
    );
    let read_switch = read(&switch).unwrap().settings;
    assert_eq!(
        read_switch.axes[0].homing,
        Some(HomingSettings::new(self::switch()))
    );
    let here = STOP.split("homing_direction").next().unwrap();
    let here = format!("{}homing_order = 2\n", here.replace("stop", "here"));
    let expected = HomingSettings {
        order: 2,
        ..HomingSettings::new(HomingMethod::Here)
    };
    assert_eq!(read(&here).unwrap().settings.axes[0].homing, Some(expected));
}

#[test]
fn what_does_not_fit_in_a_file_is_refused_with_its_place() {
    let cases = [
        (
            STOP.replace("\"stop\"", "\"stops\""),
            "line 14, column 10: expected \"stop\", \"switch\" or \"here\", got \"stops\"; docs/homing.md says what they do",
        ),
        (
            STOP.replace("homing_direction = \"negative\"\n", ""),
            "line 14, column 10: expected homing_direction beside homing = \"stop\", got none; say it; it has no default",
        ),
        (
            STOP.replace("homing_way_millidegrees = 1440000\n", ""),
            "line 14, column 10: expected homing_way_millidegrees beside homing = \"stop\", got none; say it; it has no default",
        ),
        (
            STOP.replace("\"negative\"", "\"left\""),
            "line 15, column 20: expected \"positive\" or \"negative\", got \"left\"; positive is towards larger counts",
        ),
        (
            format!("{STOP}homing_switch_pin = 3\n"),
            "line 17, column 21: expected no homing_switch_pin with homing = \"stop\", got 3; leave it out, or choose another homing",
        ),
        (
            STOP.replace("homing = \"stop\"\n", ""),
            "line 14, column 20: expected no homing_direction without homing, got \"negative\"; leave it out, or choose another homing",
        ),
        (
            STOP.replace("\"stop\"", "\"here\""),
            "line 15, column 20: expected no homing_direction with homing = \"here\", got \"negative\"; leave it out, or choose another homing",
        ),
        (
            format!("{STOP}homing_speed_rpm = 65536\n"),
            "line 17, column 20: expected 0 to 65535, got 65536; correct the number",
        ),
        (
            STOP.replace("\"stop\"", "\"switch\""),
            "line 14, column 10: expected homing_switch_pin beside homing = \"switch\", got none; say it; it has no default",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(read(&text).unwrap_err().to_string(), expected);
    }
    let place = |text: &str| {
        let file = read(text).unwrap();
        let refusal = file.settings.configs(&Board::STM32F405).unwrap_err();
        let Place { line, column } = file.locate(&refusal);
        (refusal.kind, line, column)
    };
    assert_eq!(
        place(&format!("{STOP}homing_speed_rpm = 151\n")),
        (Kind::HomingSpeed, 17, 1)
    );
    assert_eq!(
        place(&STOP.replace("torque_poll_us = 20000", "torque_poll_us = 60000")),
        (Kind::HomingTorquePoll, 13, 1)
    );
}

fn any_search() -> impl Strategy<Value = HomingSearch> {
    let numbers = any::<(bool, u16, u16, u32, u16, u32, u32, u32)>();
    numbers.prop_map(|numbers| HomingSearch {
        direction: if numbers.0 {
            HomingDirection::Positive
        } else {
            HomingDirection::Negative
        },
        speed_rpm: numbers.1,
        slow_speed_rpm: numbers.2,
        acceleration_rpm_per_s: numbers.3,
        most_torque_permille: numbers.4,
        most_millidegrees: numbers.5,
        way_millidegrees: numbers.6,
        back_off_millidegrees: numbers.7,
    })
}

fn any_homing() -> impl Strategy<Value = HomingSettings> {
    let method = prop_oneof![
        Just(HomingMethod::Here),
        (any_search(), any::<u16>(), any::<u32>()).prop_map(
            |(search, torque_permille, contact_millidegrees)| HomingMethod::Stop {
                search,
                torque_permille,
                contact_millidegrees,
            }
        ),
        (any_search(), any::<u8>(), any::<bool>()).prop_map(|(search, pin, is_low)| {
            let active = if is_low {
                SwitchLevel::Low
            } else {
                SwitchLevel::High
            };
            HomingMethod::Switch {
                search,
                pin,
                active,
            }
        }),
    ];
    (method, any::<u8>(), any::<i32>()).prop_map(|(method, order, reference_millidegrees)| {
        HomingSettings {
            method,
            order,
            reference_millidegrees,
        }
    })
}

proptest! {
    #[test]
    fn bytes_settings_and_file_round_trip(
        mut settings in any_settings(),
        homings in prop::collection::vec(prop::option::of(any_homing()), 8),
    ) {
        settings.axes.truncate(homings.len());
        for (axis, homing) in settings.axes.iter_mut().zip(homings) {
            axis.homing = homing;
        }
        let written = bytes(&settings);
        prop_assert_eq!(Settings::read(&written), Ok(settings.clone()));
        let text = write(&settings);
        let read = file::read(&text);
        prop_assert!(read.is_ok(), "{}\n{}", read.unwrap_err(), text);
        prop_assert_eq!(read.unwrap().settings, settings);
    }

    /// No settings make a search that the search itself refuses, and none makes a panic.
    #[test]
    fn what_the_check_admits_can_be_searched(homing in any_homing(), torque_us in 0_u32..100_000) {
        let with = with_homing(|axis, of| {
            *of = homing;
            axis.polls.torque_us = torque_us;
        });
        if let Ok(configs) = with.configs(&Board::STM32F405) {
            let search = configs.homings[1].unwrap().search;
            prop_assert!(Homing::new(search, 0).is_ok());
            let travel = configs.axes[1].limits.travel;
            prop_assert!(Homing::new(search, travel.min_counts).is_ok());
        }
    }

    /// The same with values that are often right.
    #[test]
    fn what_the_check_admits_of_likely_values_can_be_searched(
        speed in 0_u16..40, slow in 0_u16..20, way in 0_u32..2_000_000, back in 0_u32..100_000,
        most in 1_000_u32..200_000, contact in 0_u32..10_000, reference in -100_000..100_000_i32,
    ) {
        let with = with_homing(|_, homing| {
            let mut search = search();
            (search.speed_rpm, search.slow_speed_rpm) = (speed, slow);
            (search.way_millidegrees, search.back_off_millidegrees) = (way, back);
            search.most_millidegrees = most;
            homing.method = HomingMethod::Stop {
                search,
                torque_permille: 150,
                contact_millidegrees: contact,
            };
            homing.reference_millidegrees = reference;
        });
        match with.configs(&Board::STM32F405) {
            Ok(configs) => {
                let search = configs.homings[1].unwrap().search;
                prop_assert!(Homing::new(search, 0).is_ok());
            }
            Err(refusal) => prop_assert_ne!(refusal.kind, Kind::HomingSearch),
        }
    }
}
