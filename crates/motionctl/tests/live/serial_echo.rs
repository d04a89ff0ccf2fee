//! Serial lines that bring back what is sent, lose settings, or have old bytes on them.

use std::time::Duration;

use serde_json::Value;

use crate::bench::BenchProcess;
use crate::relay::{Line, Relay};
use crate::undisturbed::undisturbed;

/// The main gain that the drive itself has, over CAN.
fn main_gain(bench: &BenchProcess, drive: &str) -> i64 {
    let output = bench.run(&["read", "--drive", drive, "--json"]);
    let readings: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let mut parameters = readings["parameters"].as_array().expect("a list").iter();
    let gain = parameters.find(|reading| reading["parameter"] == "main-gain");
    gain.expect("it has one")["value"]
        .as_i64()
        .expect("a number")
}

const AT_ONCE: Duration = Duration::ZERO;
/// So late that it comes while the read-back is awaited.
const LATE: Duration = Duration::from_millis(53);

#[test]
fn a_setting_that_only_its_echo_knows_is_not_taken() {
    undisturbed(|| {
        for (echo, replies_late) in [
            (Some(AT_ONCE), Duration::ZERO),
            (Some(Duration::from_millis(15)), Duration::ZERO),
            // The echo comes while the read-back is awaited, in front of its reply.
            (Some(LATE), Duration::from_millis(20)),
            (None, Duration::ZERO),
        ] {
            let name = format!("echo-drop-{echo:?}");
            let bench = BenchProcess::start_with_serial(&name, "1", &[]);
            let line = Line {
                echo,
                replies_late,
                drops_settings: true,
                ..Line::default()
            };
            let relay = Relay::start(&name, &bench, line);
            let write = ["write", "--drive", "1", "main-gain=33", "--yes"];
            let (status, text, errors) = relay.run(&write);
            assert_eq!(status, Some(1), "{name}: {text}{errors}");
            assert!(!text.contains("is now"), "{name}: {text}");
            assert!(
                errors.contains("did not take main-gain = 33, it reads back 20"),
                "{name}: {errors}"
            );
            assert_eq!(main_gain(&bench, "1"), 20, "{name}");
        }
    });
}

#[test]
fn a_setting_that_arrives_is_taken_on_every_line() {
    undisturbed(|| {
        for echo in [Some(AT_ONCE), Some(Duration::from_millis(15)), None] {
            let name = format!("echo-write-{echo:?}");
            let bench = BenchProcess::start_with_serial(&name, "1", &[]);
            let line = Line {
                echo,
                ..Line::default()
            };
            let relay = Relay::start(&name, &bench, line);
            let write = ["write", "--drive", "1", "main-gain=33", "gear-number=8192"];
            let (status, text, errors) = relay.run(&[&write[..], &["--yes"]].concat());
            assert_eq!(status, Some(0), "{name}: {text}{errors}");
            assert!(text.contains("main-gain is now 33"), "{name}: {text}");
            assert_eq!(main_gain(&bench, "1"), 33, "{name}");
            let (status, text, errors) = relay.run(&["read", "--drive", "1"]);
            assert_eq!(status, Some(0), "{name}: {text}{errors}");
        }
    });
}

#[test]
fn a_line_that_only_echoes_has_no_drive() {
    undisturbed(|| {
        let bench = BenchProcess::start_with_serial("echo-only", "1", &[]);
        let line = Line {
            echo: Some(AT_ONCE),
            drops_all: true,
            ..Line::default()
        };
        let relay = Relay::start("echo-only", &bench, line);
        let (status, text, _) = relay.run(&["scan", "--json"]);
        assert_eq!(status, Some(1), "{text}");
        let (status, text, errors) = relay.run(&["read", "--drive", "1"]);
        assert_eq!((status, text.as_str()), (Some(1), ""), "{errors}");
        assert!(errors.contains("drive 1 does not answer"), "{errors}");
    });
}

#[test]
fn a_fresh_drive_on_an_echoing_line_is_read_and_written() {
    undisturbed(|| {
        let bench = BenchProcess::start_with_serial("echo-fresh", "5", &["--fresh"]);
        let line = Line {
            echo: Some(AT_ONCE),
            ..Line::default()
        };
        let relay = Relay::start("echo-fresh", &bench, line);
        let (status, text, errors) = relay.run(&["write", "--drive", "0", "main-gain=33", "--yes"]);
        assert_eq!(status, Some(0), "{text}{errors}");
        let (_, text, _) = relay.run(&["read", "--drive", "0", "--json"]);
        assert!(text.contains("\"drive\": 0"), "{text}");
        assert_eq!(main_gain(&bench, "5"), 20, "the other one was not meant");
        drop(relay);
        let dropped = Line {
            drops_settings: true,
            ..line
        };
        let relay = Relay::start("echo-fresh", &bench, dropped);
        let (status, text, errors) = relay.run(&["write", "--drive", "0", "main-gain=40", "--yes"]);
        assert_eq!(status, Some(1), "{text}{errors}");
        assert!(errors.contains("reads back 33"), "{errors}");
    });
}

#[test]
fn old_bytes_on_the_line_are_no_reply() {
    undisturbed(|| {
        // Status: disabled and in alarm; main gain 99; a packet that is cut off; noise.
        let stale = [
            &[0x01, 0x99, 0x96, 0xB0][..],
            &[0x01, 0x90, 0xE3, 0xF4],
            &[0x01, 0x9B],
            &[0xFF, 0xFE],
        ]
        .concat();
        let bench = BenchProcess::start_with_serial("stale", "1", &[]);
        let line = Line {
            stale: Box::leak(stale.into_boxed_slice()),
            ..Line::default()
        };
        let relay = Relay::start("stale", &bench, line);
        let (status, text, errors) = relay.run(&["read", "--drive", "1", "--json"]);
        assert_eq!(status, Some(0), "{text}{errors}");
        let readings: Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(readings["state"]["enabled"], true, "{text}");
        assert_eq!(readings["state"]["alarm"], Value::Null, "{text}");
        let (status, _, errors) = relay.run(&["write", "--drive", "1", "main-gain=99", "--yes"]);
        assert_eq!(status, Some(0), "{errors}");
        assert_eq!(main_gain(&bench, "1"), 99);
    });
}
