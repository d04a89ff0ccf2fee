//! The settings as a file, and what is wrong with one.

#[allow(dead_code, reason = "shared with other tests")]
mod sample;

use board_settings::file::{self, Place, read, write};
use board_settings::{Board, Inputs, LONGEST, Polls, ReadBack, Settings};
use proptest::prelude::*;
use sample::{any_settings, settings};

const LEAST: &str = "\
format = 1

[bus]
bit_rate_kbit_per_s = 1000

[[axis]]
drive = 1
gear_number = 4096
speed_rpm = 150
acceleration_rpm_per_s = 1_000
travel_min_millidegrees = -90_000
travel_max_millidegrees = 90_000
";

fn wrong(text: &str) -> String {
    read(text).unwrap_err().to_string()
}

#[test]
fn what_must_be_said_is_enough() {
    let file = read(LEAST).unwrap();
    let expected = Settings {
        name: Default::default(),
        ..settings(1)
    };
    assert_eq!(file.settings, expected);
    assert_eq!(
        file.settings.inputs,
        Inputs {
            enable_fitted: true
        }
    );
    assert_eq!(file.settings.axes[0].polls, Polls::DEFAULT);
    assert_eq!(file.settings.axes[0].read_back, ReadBack::CommandCounts);
    assert!(file.settings.configs(&Board::STM32F405).is_ok());
}

#[test]
fn a_written_file_can_be_read_by_people() {
    assert_eq!(
        write(&settings(1)),
        "\
# What a motion board is told.
format = 1
name = \"lathe\"

[bus]
bit_rate_kbit_per_s = 1000
requests_per_cycle = 1
# How long the drives take to answer.
response_min_us = 0
response_max_us = 2000

[inputs]
enable_fitted = true

[[axis]]
drive = 1
gear_number = 4096
speed_rpm = 150
acceleration_rpm_per_s = 1000
travel_min_millidegrees = -90000
travel_max_millidegrees = 90000
read_back = \"command-counts\"
# Axes of a group stop together.
group = 0
# 0: not read.
status_poll_us = 20000
position_poll_us = 20000
torque_poll_us = 0
speed_poll_us = 0
counter_poll_us = 0
unwatched = false
load_can_fall = false
dialect = \"detect\"
"
    );
}

#[test]
fn each_limit_must_be_said() {
    for key in [
        "bit_rate_kbit_per_s",
        "drive",
        "gear_number",
        "speed_rpm",
        "acceleration_rpm_per_s",
    ] {
        let lines = LEAST.lines().filter(|line| !line.starts_with(key));
        let text: Vec<&str> = lines.collect();
        let message = wrong(&text.join("\n"));
        assert!(message.contains(&format!("`{key}`")), "{message}");
    }
    let text = LEAST.replace("travel_max_millidegrees = 90_000\n", "");
    assert_eq!(
        wrong(&text),
        "line 6, column 1: expected travel_min_millidegrees and travel_max_millidegrees, or travel_min_counts and travel_max_counts, got other keys of the travel; say where the axis may go, in one of the two units; an axis without ends has -134217728 to 134217727 counts"
    );
}

#[test]
fn what_does_not_fit_is_refused_with_its_place() {
    let cases = [
        (
            LEAST.replace("speed_rpm = 150", "speed_rpm = -1"),
            "line 9, column 13: expected 0 to 4294967295, got -1; correct the number",
        ),
        (
            LEAST.replace("drive = 1", "drive = 256"),
            "line 7, column 9: expected 0 to 255, got 256; correct the number",
        ),
        (
            LEAST.replace("format = 1", "format = 2"),
            "line 1, column 10: expected format = 1, got 2; use the version of the tool that wrote it",
        ),
        (
            format!("{LEAST}dialect = \"1.7\"\n"),
            "line 13, column 11: expected \"detect\", \"1.2A\" or \"1.6A\", got \"1.7\"; `motionctl scan` shows the revision of a drive",
        ),
        (
            LEAST.replace(
                "format = 1",
                "format = 1\nname = \"a board with far too long a name\"",
            ),
            "line 2, column 8: expected a name of at most 24 bytes, got 32 bytes; choose a shorter name",
        ),
        (
            format!("{LEAST}read_back_counts = 4\n"),
            "line 6, column 1: expected read_back, or read_back_counts and read_back_command_counts, got other keys of the read-back; keep one of the two",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(wrong(&text), expected);
    }
    let message = wrong(&format!("{LEAST}speed = 1\n"));
    assert!(
        message.starts_with("line 13, column 1: ") && message.contains("`speed`"),
        "{message}"
    );
    let message = wrong("format = 1\n[bus\n");
    assert!(message.starts_with("line 2, column "), "{message}");
    let axis = LEAST.split_once("[[axis]]").unwrap();
    let many = format!("{}{}", axis.0, format!("[[axis]]{}", axis.1).repeat(15));
    let message = wrong(&many);
    assert!(
        message.starts_with("line 104, column 1: expected at most 14 axes, got 15"),
        "{message}"
    );
}

#[test]
fn what_the_check_refuses_is_found_in_the_file() {
    let place = |text: &str| {
        let file = read(text).unwrap();
        let refusal = file.settings.configs(&Board::STM32F405).unwrap_err();
        let Place { line, column } = file.locate(&refusal);
        (refusal.kind.number(), line, column)
    };
    let second = "\n[[axis]]\ndrive = 2\ngear_number = 400\nspeed_rpm = 150\nacceleration_rpm_per_s = 1000\n  travel_min_counts = 0\ntravel_max_counts = 1\n";
    let two = format!("{LEAST}{second}");
    assert_eq!(place(&two), (1009, 16, 1));
    let two = two.replace("= 400", "= 4096");
    assert_eq!(
        place(&two.replace("counts = 1\n", "counts = -1\n")),
        (1013, 19, 3)
    );
    assert_eq!(
        place(&format!("{two}torque_poll_us = 9_99 # often\n")),
        (1018, 21, 1)
    );
    // What is left out has the place of its axis.
    assert_eq!(place(&format!("{two}status_poll_us = 0\n")), (1017, 21, 1));
    assert_eq!(place(&LEAST.replace("= 1000\n", "= 100\n")), (1019, 4, 1));
    let none = LEAST.split("[[axis]]").next().unwrap();
    assert_eq!(place(none), (1006, 1, 1));
}

proptest! {
    #[test]
    fn bytes_settings_and_file_round_trip(settings in any_settings()) {
        let text = write(&settings);
        let read = file::read(&text);
        prop_assert!(read.is_ok(), "{}\n{}", read.unwrap_err(), text);
        let again = read.unwrap().settings;
        let (mut one, mut other) = ([0; LONGEST], [0; LONGEST]);
        prop_assert_eq!(again.write(&mut one), settings.write(&mut other));
        prop_assert_eq!(again, settings);
    }
}
