//! The commissioning commands over the serial port of the drives of a bench.

use serde_json::{Value, json};

use crate::bench::{BenchProcess, interrupt, motionctl, start_and_wait_for, status_and_errors};
use crate::undisturbed::undisturbed;

/// Runs a command with its link; returns its exit status, what it printed, and its errors.
fn run(link: [&str; 2], arguments: &[&str]) -> (Option<i32>, String, String) {
    let (command, options) = arguments.split_first().expect("a command");
    let [kind, port] = link;
    let start = [*command, kind, port];
    let output = motionctl(&[&start, options].concat())
        .output()
        .expect("motionctl runs");
    let (status, errors) = status_and_errors(&output);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    (status, text, errors)
}

fn serial(bench: &BenchProcess, arguments: &[&str]) -> (Option<i32>, String, String) {
    run(["--serial", bench.serial_path()], arguments)
}

fn json_of((status, text, errors): (Option<i32>, String, String)) -> Value {
    assert_eq!(status, Some(0), "{text}{errors}");
    serde_json::from_str(&text).unwrap_or_else(|_| panic!("{text}"))
}

fn parameter(readings: &Value, name: &str) -> Option<i64> {
    let mut parameters = readings["parameters"].as_array()?.iter();
    parameters.find(|reading| reading["parameter"] == name)?["value"].as_i64()
}

#[test]
fn scan_finds_every_drive_of_the_line() {
    undisturbed(|| {
        let bench = BenchProcess::start_with_serial("serial-scan", "1,9,63", &["--fresh"]);
        let found = |drive| json!({ "drive": drive, "protocol": "DYN232M (serial)" });
        assert_eq!(
            json_of(serial(&bench, &["scan", "--json"])),
            json!({ "drives": [found(0), found(1), found(9), found(63)] })
        );
    });
}

#[test]
fn a_fresh_drive_is_drive_0_here_and_has_no_address_on_can() {
    undisturbed(|| {
        let bench = BenchProcess::start_with_serial("serial-fresh", "1", &["--fresh"]);
        let write = ["write", "--drive", "0", "speed-gain=33", "--yes", "--json"];
        json_of(serial(&bench, &write));
        let readings = json_of(serial(&bench, &["read", "--drive", "0", "--json"]));
        assert_eq!(readings["drive"], 0);
        assert_eq!(parameter(&readings, "speed-gain"), Some(33));
        let (status, _, errors) = run(["--slcan", bench.path()], &["read", "--drive", "0"]);
        assert_eq!(status, Some(2));
        assert!(errors.contains("0 is every drive on CAN"), "{errors}");
        let (status, _, errors) = serial(&bench, &["read", "--drive", "64"]);
        assert_eq!(status, Some(2));
        assert!(errors.contains("must be 0..=63, got 64"), "{errors}");
    });
}

#[test]
fn what_is_written_over_serial_is_read_over_can() {
    undisturbed(|| {
        let bench = BenchProcess::start_with_serial("serial-write", "3", &[]);
        let settings = [
            "main-gain=100",
            "config=0x04",
            "gear-number=8192",
            "speed-gain=20",
        ];
        let write = [
            &["write", "--drive", "3"],
            &settings[..],
            &["--yes", "--allow-absolute-mode", "--json"],
        ]
        .concat();
        let changes = json_of(serial(&bench, &write));
        let results: Vec<_> = changes["changes"]
            .as_array()
            .expect("a list")
            .iter()
            .map(|change| (change["parameter"].as_str(), change["result"].as_str()))
            .collect();
        let end = |parameter, result| (Some(parameter), Some(result));
        assert_eq!(
            results,
            [
                end("speed-gain", "unchanged"),
                end("main-gain", "written"),
                end("config", "written"),
                end("gear-number", "written"),
            ]
        );
        let read = ["read", "--drive", "3", "--json"];
        for readings in [
            json_of(run(["--slcan", bench.path()], &read)),
            json_of(serial(&bench, &read)),
        ] {
            assert_eq!(parameter(&readings, "main-gain"), Some(100));
            assert_eq!(parameter(&readings, "config"), Some(4));
            assert_eq!(parameter(&readings, "gear-number"), Some(8_192));
            assert_eq!(parameter(&readings, "torque-filter"), Some(127));
        }
    });
}

#[test]
fn what_cannot_be_sent_is_refused_with_a_reason() {
    undisturbed(|| {
        let bench = BenchProcess::start_with_serial("serial-refusals", "3", &[]);
        let write = |setting| serial(&bench, &["write", "--drive", "3", setting, "--yes"]);
        let (status, _, errors) = write("line-number=600");
        assert_eq!(status, Some(1));
        assert!(errors.contains("use CAN"), "{errors}");
        let (status, _, errors) = write("gear-number=16384");
        assert_eq!(status, Some(1));
        assert!(
            errors.contains("must be 500..=16383, got 16384"),
            "{errors}"
        );
        let (status, _, errors) = serial(&bench, &["read", "--drive", "4"]);
        assert_eq!(status, Some(1));
        assert!(errors.contains("drive 4 does not answer"), "{errors}");
        let (status, _, errors) = run(["--serial", "/dev/no-such-port"], &["scan"]);
        assert_eq!(status, Some(3));
        assert!(errors.contains("there is no port"), "{errors}");
        let both = ["--can", "can0", "--drive", "3"];
        let (status, ..) = serial(&bench, &[&["read"], &both[..]].concat());
        assert_eq!(status, Some(2));
    });
}

#[test]
fn jog_moves_only_when_the_parameters_of_the_drive_are_slow_enough() {
    undisturbed(|| {
        let bench = BenchProcess::start_with_serial("serial-jog", "1", &[]);
        let jog = ["jog", "--drive", "1", "--turns", "-0.25", "--yes", "--json"];
        let (status, _, errors) = serial(&bench, &jog);
        assert_eq!(status, Some(2));
        assert!(errors.contains("more than --rpm 60"), "{errors}");
        assert!(errors.contains("max-speed=5"), "{errors}");
        let slower = ["write", "--drive", "1", "max-speed=5", "--yes", "--json"];
        json_of(serial(&bench, &slower));
        assert_eq!(
            json_of(serial(&bench, &jog)),
            json!({
                "asked_counts": -4_096, "sent_counts": -4_096, "read_counts": -4_096,
                "interrupted": false, "enabled": true,
            })
        );
        // A position in another unit than expected is noticed.
        let wrong_unit = [&jog[..], &["--read-back", "encoder"]].concat();
        let (status, _, errors) = serial(&bench, &wrong_unit);
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("reports -1024"), "{errors}");
        let report = bench.stop();
        assert_eq!(report["drives"][0]["position_counts"], -8_192);
    });
}

#[test]
fn a_move_goes_to_a_place_within_the_limits_that_were_given() {
    undisturbed(|| {
        let bench = BenchProcess::start_with_serial("serial-move", "1,2", &[]);
        let to = |turns, more: &[&'static str]| {
            let start = ["move", "--drives", "1", "--to", turns, "--yes", "--json"];
            serial(&bench, &[&start[..], more].concat())
        };
        let refused = |more: &[&'static str], reason: &str| {
            let (status, text, errors) = to("0.5", more);
            assert_eq!((status, text.as_str()), (Some(2), ""), "{errors}");
            assert!(errors.contains(reason), "{errors}");
        };
        refused(&[], "more than --max-rpm 60");
        let slower = ["write", "--drive", "1", "max-speed=5", "--yes", "--json"];
        json_of(serial(&bench, &slower));
        refused(&["--max-turns", "0.4"], "0.500 turns away");
        refused(&[], "--max-acceleration allows 1000");
        let fast = ["--max-acceleration", "100000"];
        let end = |start: i64, end: i64| {
            json!({
                "moves": [{
                    "drive": 1, "start_counts": start, "end_counts": end, "arrived": true,
                    "read_counts": end, "enabled": true,
                }],
                "interrupted": false,
            })
        };
        assert_eq!(json_of(to("0.5", &fast)), end(0, 8_192));
        assert_eq!(json_of(to("-0.25", &fast)), end(8_192, -4_096));
        // It is there already.
        assert_eq!(json_of(to("-0.25", &fast)), end(-4_096, -4_096));
        let by = ["move", "--drives", "1", "--by", "0.125", "--yes", "--json"];
        let by = [&by[..], &fast].concat();
        assert_eq!(json_of(serial(&bench, &by)), end(-4_096, -2_048));
        let both = ["move", "--drives", "1,2", "--to", "0", "--yes"];
        let (status, _, errors) = serial(&bench, &both);
        assert_eq!(status, Some(2));
        assert!(errors.contains("one drive moves at a time"), "{errors}");
        bench.disable("1");
        let (status, _, errors) = to("0", &fast);
        assert_eq!(status, Some(1));
        assert!(errors.contains("the servo is off"), "{errors}");
        let report = bench.stop();
        assert_eq!(report["drives"][0]["position_counts"], -2_048);
        assert_eq!(report["drives"][1]["position_counts"], 0);
    });
}

#[test]
fn monitor_shows_the_drives_of_the_line_and_who_is_silent() {
    undisturbed(|| {
        let bench = BenchProcess::start_with_serial("serial-monitor", "1,2", &["--alarm", "2"]);
        let monitor = [
            "monitor",
            "--drives",
            "1-3",
            "--every-ms",
            "50",
            "--count",
            "2",
        ];
        let (status, text, errors) = serial(&bench, &[&monitor[..], &["--json"]].concat());
        assert_eq!(status, Some(0), "{errors}");
        let lines: Vec<Value> = text
            .lines()
            .map(|line| serde_json::from_str(line).expect("JSON"))
            .collect();
        let drives: Vec<_> = lines.iter().map(|line| line["drive"].as_u64()).collect();
        assert_eq!(drives, [1, 2, 3, 1, 2, 3].map(Some));
        assert_eq!(lines[3]["answers"], true);
        assert_eq!(lines[3]["position_counts"], 0);
        assert_eq!(lines[3]["alarm"], Value::Null);
        assert!(lines[4]["alarm"].is_string(), "{text}");
        assert_eq!(lines[5]["answers"], false);
        assert_eq!(lines[5]["position_counts"], Value::Null);
        let (_, text, _) = serial(&bench, &monitor);
        assert!(
            text.contains("drive  3: does not answer, it never did"),
            "{text}"
        );
    });
}

#[test]
fn ctrl_c_stops_a_jog_on_its_way() {
    undisturbed(|| {
        let bench = BenchProcess::start_with_serial("serial-stop", "1", &[]);
        let slower = ["write", "--drive", "1", "max-speed=5", "--yes", "--json"];
        json_of(serial(&bench, &slower));
        let port = ["jog", "--serial", bench.serial_path()];
        let long = ["--drive", "1", "--turns", "10", "--yes", "--json"];
        let child = start_and_wait_for(motionctl(&[port.as_slice(), &long].concat()), "moves");
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(130), "{errors}");
        let end: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(end["interrupted"], true);
        let read = end["read_counts"].as_i64().expect("a position");
        assert!((0..163_840).contains(&read), "{read}");
        // The motor stands where the tool has left it.
        assert_eq!(bench.stop()["drives"][0]["position_counts"], read);
    });
}

#[test]
fn a_vanished_port_ends_a_read() {
    undisturbed(|| {
        let mut bench = BenchProcess::start_with_serial("serial-vanish", "1", &[]);
        let port = ["scan", "--serial", bench.serial_path()];
        let child = motionctl(&port).spawn().expect("motionctl runs");
        bench.kill();
        let output = child.wait_with_output().expect("its output");
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(3), "{errors}");
    });
}
