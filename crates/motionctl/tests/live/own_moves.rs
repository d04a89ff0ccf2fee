//! `motionctl move` and `motionctl speed` against a bench.

use serde_json::{Value, json};

use crate::bench::{BenchProcess, interrupt, motionctl, start_and_wait_for, status_and_errors};
use crate::undisturbed::undisturbed;

/// Runs a command on a bench; returns its exit status, what it printed, and its errors.
fn on(bench: &BenchProcess, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = bench.run(arguments);
    let (status, errors) = status_and_errors(&output);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    (status, text, errors)
}

fn json_on(bench: &BenchProcess, arguments: &[&str]) -> Value {
    let (status, text, errors) = on(bench, &[arguments, &["--json"]].concat());
    assert_eq!(status, Some(0), "{text}{errors}");
    serde_json::from_str(&text).unwrap_or_else(|_| panic!("{text}"))
}

/// Drives that are off, and slow enough for the default limits: 48.8 r/min, 636 r/min per second.
fn slow_drives(name: &str, ids: &[&str]) -> BenchProcess {
    let bench = BenchProcess::start(name, &ids.join(","));
    bench.disable(&ids.join(","));
    for id in ids {
        let write = [
            "write",
            "--drive",
            id,
            "max-speed=5",
            "max-acceleration=1",
            "--yes",
        ];
        json_on(&bench, &write);
    }
    bench
}

#[test]
fn a_move_arrives_and_the_drive_is_disabled_again() {
    undisturbed(|| {
        let bench = slow_drives("move", &["1", "2"]);
        // A drive that is within the tolerance of its end has arrived.
        let is_at = |one: &Value, counts: i64| {
            let read = one["read_counts"].as_i64().expect("a count");
            assert!((read - counts).abs() <= 16, "{one}");
            assert_eq!(one["arrived"], true, "{one}");
            assert_eq!(one["enabled"], false, "{one}");
        };
        let end = json_on(&bench, &["move", "--drives", "2", "--to", "0.25", "--yes"]);
        is_at(&end["moves"][0], 4_096);
        assert_eq!(end["moves"][0]["end_counts"], 4_096, "{end}");
        assert_eq!(end["interrupted"], false, "{end}");
        let end = json_on(&bench, &["move", "--drives", "2", "--by", "-0.5", "--yes"]);
        is_at(&end["moves"][0], -4_096);
        // Together, by one trigger.
        let both = ["move", "--drives", "2,1", "--by", "0.125,-0.125", "--yes"];
        let end = json_on(&bench, &both);
        is_at(&end["moves"][0], -2_048);
        is_at(&end["moves"][1], -2_048);
        let report = bench.stop();
        for drive in [0, 1] {
            assert_eq!(report["drives"][drive]["enabled"], false, "{report}");
            assert_eq!(report["drives"][drive]["received_counts"], 0, "{report}");
        }
    });
}

#[test]
fn what_is_refused_moves_nothing() {
    undisturbed(|| {
        // As they leave the factory these drives accelerate faster than the default allows, and they are on.
        let bench = BenchProcess::start("move-refused", "1,2");
        let refused = |arguments: &[&str], expected: &str| {
            let (status, _, errors) = on(&bench, arguments);
            assert_eq!(status, Some(2), "{arguments:?}: {errors}");
            assert!(errors.contains(expected), "{arguments:?}: {errors}");
        };
        let by = |turns| ["move", "--drives", "1", "--by", turns, "--yes"];
        refused(
            &by("0.01"),
            "--max-rpm allows 60: lower max-speed of the drive",
        );
        let fast = [&by("0.01")[..], &["--max-rpm", "6000"]].concat();
        refused(&fast, "r/min per second, --max-acceleration allows 1000");
        refused(&by("11"), "--max-turns allows 163840");
        refused(&["move", "--drives", "1", "--by", "0.1"], "--yes");
        refused(
            &["move", "--drives", "1,2", "--by", "1,2,3", "--yes"],
            "not 3",
        );
        refused(&["move", "--drives", "1", "--yes"], "--to");
        let speed = ["speed", "--drives", "1", "--rpm", "61", "--yes"];
        refused(&speed, "--rpm must be 1..=60");
        let report = bench.stop();
        assert_eq!(report["drives"][0]["enabled"], true, "{report}");
    });
}

#[test]
fn a_dry_run_shows_the_frames() {
    let shown = |arguments: &[&str]| {
        let output = motionctl(&[arguments, &["--can", "none", "--dry-run", "--json"]].concat())
            .output()
            .expect("the tool");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let shown: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let frames = shown["frames"].as_array().expect("frames").clone();
        let hex = |frame: &Value| frame["hex"].as_str().unwrap_or_default().to_owned();
        frames.iter().map(hex).collect::<Vec<_>>()
    };
    assert_eq!(
        shown(&["move", "--drives", "3", "--to", "-1"]),
        ["074#", "079#00", "061#C000"]
    );
    assert_eq!(
        shown(&["move", "--drives", "1-2", "--by", "0.5"]),
        [
            "034#", "039#00", "054#", "059#00", "037#2000", "057#2000", "018#EE"
        ]
    );
    assert_eq!(
        shown(&["speed", "--drives", "3", "--rpm", "-30"]),
        ["074#", "079#00", "06A#E2", "06A#00", "068#"]
    );
}

#[test]
fn ctrl_c_stops_a_move_on_its_way_and_disables() {
    undisturbed(|| {
        let bench = slow_drives("move-stop", &["1"]);
        // Five turns at 48.8 r/min take more than 6 s.
        let arguments = [
            "move",
            "--slcan",
            bench.path(),
            "--drives",
            "1",
            "--by",
            "5",
            "--yes",
        ];
        let child = start_and_wait_for(motionctl(&arguments), "Ctrl-C stops it");
        std::thread::sleep(std::time::Duration::from_secs(4));
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(130), "{output:?}");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(text.contains("was stopped on its way"), "{text}");
        let at = json_on(&bench, &["read", "--drive", "1"])["state"]["position_counts"].clone();
        assert!((0..81_920).contains(&at.as_i64().expect("a count")), "{at}");
        assert_eq!(bench.stop()["drives"][0]["enabled"], false);
    });
}

#[test]
fn constant_speed_ends_in_position_mode_and_off() {
    undisturbed(|| {
        let bench = slow_drives("speed", &["1"]);
        // With the slowest soft start a motor would need two minutes.
        let write = ["write", "--drive", "1", "max-acceleration=20", "--yes"];
        json_on(&bench, &write);
        let speed = [
            "speed",
            "--drives",
            "1",
            "--rpm",
            "-30",
            "--for",
            "1",
            "--yes",
            "--max-acceleration",
            "2000",
        ];
        let end = json_on(&bench, &speed);
        let drive = &end["drives"][0];
        assert_eq!(
            (&drive["eeprom_writes"], &drive["enabled"]),
            (&json!(1), &json!(false)),
            "{end}"
        );
        let counts = drive["read_counts"].as_i64().expect("a count");
        // Half a turn a second.
        assert!((-20_000..-4_000).contains(&counts), "{end}");
        let (_, text, _) = on(&bench, &["read", "--drive", "1"]);
        assert!(text.contains("position servo"), "{text}");
        // Without --for it is Ctrl-C that ends it.
        let arguments = [
            "speed",
            "--slcan",
            bench.path(),
            "--drives",
            "1",
            "--rpm",
            "30",
            "--yes",
            "--max-acceleration",
            "2000",
        ];
        let child = start_and_wait_for(motionctl(&arguments), "Ctrl-C stops it");
        std::thread::sleep(std::time::Duration::from_secs(3));
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        assert_eq!(bench.stop()["drives"][0]["enabled"], false);
    });
}
