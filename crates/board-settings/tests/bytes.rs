//! The layout of the bytes, and what is no layout.

#[allow(dead_code, reason = "shared with other tests")]
mod sample;

use board_settings::{Dialect, Kind, LONGEST, Polls, ReadBack, Refusal, Settings, Travel, VERSION};
use proptest::prelude::*;
use sample::{any_settings, axis, settings};

fn bytes(settings: &Settings) -> Vec<u8> {
    settings.write(&mut [0; LONGEST]).unwrap().to_vec()
}

fn refused(bytes: &[u8]) -> (Kind, Option<u8>, i64, i64) {
    let Refusal {
        kind,
        axis,
        expected,
        actual,
    } = Settings::read(bytes).unwrap_err();
    (kind, axis, expected, actual)
}

/// Whoever changes these bytes changes the version.
#[test]
fn the_layout_is_pinned() {
    let mut full = settings(1);
    full.axes.push(sample::axis(63)).unwrap();
    let axis = &mut full.axes[1];
    axis.jerk_rpm_per_s2 = Some(20_000);
    axis.travel = Travel::Counts { min: -1, max: 300 };
    axis.read_back = ReadBack::Ratio {
        read_back_counts: 4,
        command_counts: 1,
    };
    axis.group = 7;
    axis.polls = Polls {
        torque_us: 1_000,
        ..Polls::DEFAULT
    };
    axis.load_can_fall = true;
    axis.dialect = Dialect::V1_6A;
    axis.drift_tolerance_counts = Some(9);
    #[rustfmt::skip]
    let golden = [
        1, // version
        5, b'l', b'a', b't', b'h', b'e',
        0xE8, 0x07, 1, 0, 0xD0, 0x0F, // 1000 kbit/s, one request, 0 to 2000 us
        1, // enable fitted
        2, // axes
        1, 0x80, 0x20, 0x96, 0x01, 0xE8, 0x07, 0, // drive 1, gear 4096, 150 r/min, 1000 r/min per s, no jerk
        0, 0x9F, 0xFE, 0x0A, 0xA0, 0xFE, 0x0A, // -90000 to 90000 millidegrees, zigzag
        0, 0, 0xA0, 0x9C, 0x01, 0xA0, 0x9C, 0x01, 0, 0, 0, // command counts, group 0, 20 ms twice, no others
        0, 0, 0, 0, 0, // watched, cannot fall, detect, no tolerances
        63, 0x80, 0x20, 0x96, 0x01, 0xE8, 0x07, 1, 0xA0, 0x9C, 0x01,
        1, 1, 0xD8, 0x04, // -1 to 300 counts
        3, 4, 1, 7, 0xA0, 0x9C, 0x01, 0xA0, 0x9C, 0x01, 0xE8, 0x07, 0, 0,
        0, 1, 2, 0, 1, 9,
    ];
    assert_eq!(bytes(&full), golden);
    assert_eq!(Settings::read(&golden), Ok(full));
}

#[test]
fn the_longest_settings_have_room_and_no_byte_more() {
    let mut longest = settings(14);
    longest.name = "0123456789abcdef01234567".parse().unwrap();
    longest.bus.bit_rate_kbit_per_s = u16::MAX;
    longest.bus.response_min_us = u32::MAX;
    longest.bus.response_max_us = u32::MAX;
    for axis in &mut longest.axes {
        axis.gear = u16::MAX;
        axis.speed_rpm = u32::MAX;
        axis.acceleration_rpm_per_s = u32::MAX;
        axis.jerk_rpm_per_s2 = Some(u32::MAX);
        axis.travel = Travel::Millidegrees {
            min: i64::MIN,
            max: i64::MAX,
        };
        axis.read_back = ReadBack::Ratio {
            read_back_counts: u32::MAX,
            command_counts: u32::MAX,
        };
        axis.polls = Polls {
            status_us: u32::MAX,
            position_us: u32::MAX,
            torque_us: u32::MAX,
            speed_us: u32::MAX,
            counter_us: u32::MAX,
        };
        axis.following_error_counts = Some(u32::MAX);
        axis.drift_tolerance_counts = Some(u32::MAX);
    }
    assert_eq!(bytes(&longest).len(), LONGEST);
    let refusal = longest.write(&mut [0; LONGEST - 1]).unwrap_err();
    assert_eq!(
        (refusal.kind, refusal.expected, refusal.actual),
        (Kind::Room, LONGEST as i64, LONGEST as i64 - 1)
    );
    assert_eq!(longest.write(&mut []).unwrap_err().kind, Kind::Room);
}

#[test]
fn a_newer_version_is_refused_with_both_numbers() {
    let mut newer = bytes(&settings(2));
    newer[0] = VERSION + 1;
    assert_eq!(refused(&newer), (Kind::Version, None, 2, 3));
    // Whatever follows it.
    assert_eq!(refused(&[0xFF]), (Kind::Version, None, 2, 255));
    assert_eq!(refused(&[0; 40]), (Kind::Version, None, 2, 0));
}

#[test]
fn settings_that_are_cut_short_are_refused_wherever_the_cut_is() {
    let whole = bytes(&settings(3));
    for length in 0..whole.len() {
        let (kind, _, expected, actual) = refused(&whole[..length]);
        assert_eq!((kind, expected), (Kind::Layout, length as i64));
        assert!(actual <= expected);
    }
    let mut long = whole.clone();
    long.push(0);
    let (whole, long_len) = (whole.len() as i64, long.len() as i64);
    assert_eq!(refused(&long), (Kind::Behind, None, whole, long_len));
}

#[test]
fn fifteen_axes_are_refused_as_such() {
    let fourteen = settings(14);
    let mut many = bytes(&fourteen);
    let count = many.iter().position(|byte| *byte == 14).unwrap();
    many[count] = 15;
    many.extend(
        bytes(&Settings {
            axes: [axis(15)].into_iter().collect(),
            ..settings(0)
        })[14..]
            .iter(),
    );
    assert_eq!(refused(&many), (Kind::AxisCount, None, 14, 15));
}

#[test]
fn a_choice_that_does_not_exist_names_its_axis() {
    let mut bad = settings(2);
    bad.axes[1].dialect = Dialect::V1_6A;
    let mut bad = bytes(&bad);
    let last = bad.len() - 3;
    assert_eq!(bad[last], 2);
    bad[last] = 3;
    let (kind, axis, ..) = refused(&bad);
    assert_eq!((kind, axis), (Kind::Layout, Some(1)));
}

proptest! {
    #[test]
    fn bytes_and_settings_round_trip(settings in any_settings()) {
        prop_assert_eq!(Settings::read(&bytes(&settings)), Ok(settings));
    }

    #[test]
    fn any_bytes_are_settings_or_refused(mut bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = Settings::read(&bytes);
        if let Some(version) = bytes.first_mut() {
            *version = *version % VERSION + 1;
        }
        if let Ok(settings) = Settings::read(&bytes) {
            let again = self::bytes(&settings);
            prop_assert_eq!(Settings::read(&again), Ok(settings));
        }
    }
}
