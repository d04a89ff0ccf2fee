//! The commissioning commands against a bench.

use std::io::{BufRead, BufReader};

use rustix::process::{Pid, Signal, kill_process};
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

#[test]
fn scan_finds_the_drives_and_their_revision() {
    undisturbed(|| {
        let bench = BenchProcess::start("scan", "1,7,63");
        let found = |drive| json!({ "drive": drive, "protocol": "CAN 1.6A" });
        assert_eq!(
            json_on(&bench, &["scan"]),
            json!({ "drives": [found(1), found(7), found(63)] })
        );
        let (_, text, _) = on(&bench, &["scan"]);
        assert_eq!(
            text,
            "drive  1  CAN 1.6A\ndrive  7  CAN 1.6A\ndrive 63  CAN 1.6A\n"
        );
    });
}

#[test]
fn read_tells_state_and_parameters_in_units() {
    undisturbed(|| {
        let bench = BenchProcess::start("read", "3");
        let readings = json_on(&bench, &["read", "--drive", "3"]);
        assert_eq!(readings["protocol"], "CAN 1.6A");
        assert_eq!(readings["state"]["enabled"], true);
        assert_eq!(readings["state"]["position_counts"], 0);
        let (_, text, _) = on(&bench, &["read", "--drive", "3"]);
        // (60 + 3)^2 / 16 * 12.21 rpm (DYN2 manual A1.8 section 7).
        assert!(text.contains("3028.8 rpm"), "{text}");
        assert!(text.contains("commands by link, position servo"), "{text}");
        let (status, _, errors) = on(&bench, &["read", "--drive", "4"]);
        assert_eq!(status, Some(1));
        assert!(errors.contains("drive 4 does not answer"), "{errors}");
    });
}

#[test]
fn write_compares_asks_writes_and_reads_back() {
    undisturbed(|| {
        let bench = BenchProcess::start("write", "3");
        let write =
            |settings: &[&str]| on(&bench, &[&["write", "--drive", "3"], settings].concat());
        let value = |parameter: &str| {
            let readings = json_on(&bench, &["read", "--drive", "3"]);
            let parameters = readings["parameters"].as_array().expect("a list").clone();
            let mut parameters = parameters.iter();
            let reading = parameters.find(|reading| reading["parameter"] == parameter);
            reading.expect("the parameter")["value"].as_i64()
        };
        let (status, _, errors) = write(&["max-speed=40", "--yes"]);
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("drive 3 is enabled"), "{errors}");
        assert!(errors.contains("motionctl disable --drives 3"), "{errors}");
        bench.disable("3");
        let (status, _, errors) = write(&["max-speed=40"]);
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("needs a confirmation"), "{errors}");
        assert_eq!(value("max-speed"), Some(60));

        let changes = json_on(
            &bench,
            &[
                "write",
                "--drive",
                "3",
                "max-speed=40",
                "main-gain=20",
                "gear-number=8192",
                "--yes",
            ],
        );
        let change = |parameter, before, value, result| json!({ "parameter": parameter, "before": before, "value": value, "result": result });
        assert_eq!(
            changes["changes"],
            json!([
                change("main-gain", 20, 20, "unchanged"),
                change("max-speed", 60, 40, "written"),
                change("gear-number", 4_096, 8_192, "written"),
            ])
        );
        assert_eq!(
            (value("max-speed"), value("gear-number")),
            (Some(40), Some(8_192))
        );

        let (status, _, errors) = write(&["max-speed=128", "--yes"]);
        assert_eq!(status, Some(2));
        assert!(errors.contains("must be 1..=127, got 128"), "{errors}");
        let (status, _, errors) = write(&["max-speed=1", "max-speed=2", "--yes"]);
        assert_eq!(status, Some(2));
        assert!(errors.contains("max-speed is given twice"), "{errors}");
        assert_eq!(value("max-speed"), Some(40));
    });
}

#[test]
fn jog_moves_by_turns_whatever_the_gear_and_disables() {
    undisturbed(|| {
        let bench = BenchProcess::start("jog", "1,2");
        bench.disable("2");
        // A gear number of 8192 makes a turn of 32768 command counts.
        json_on(
            &bench,
            &["write", "--drive", "2", "gear-number=8192", "--yes"],
        );
        let end = json_on(
            &bench,
            &[
                "jog", "--drive", "2", "--turns", "-0.5", "--rpm", "100", "--yes",
            ],
        );
        assert_eq!(
            end,
            json!({ "asked_counts": -16_384, "sent_counts": -16_384, "read_counts": -16_384, "interrupted": false, "enabled": false })
        );
        let jog = ["jog", "--drive", "2", "--turns", "0.5"];
        let (status, _, errors) = on(
            &bench,
            &[&jog[..], &["--gear-number", "4096", "--yes"]].concat(),
        );
        assert_eq!(status, Some(2), "{errors}");
        assert!(
            errors.contains("drive 2 has gear number 8192, --gear-number says 4096"),
            "{errors}"
        );
        let (status, _, errors) = on(&bench, &jog);
        assert_eq!(status, Some(2), "{errors}");
        let (status, _, errors) = on(&bench, &["jog", "--drive", "2", "--turns", "11", "--yes"]);
        assert_eq!(status, Some(2));
        assert!(errors.contains("must be -10..=10 turns"), "{errors}");
        let report = bench.stop();
        assert_eq!(report["drives"][1]["received_counts"], -16_384);
        assert_eq!(report["drives"][1]["enabled"], false);
        assert_eq!(report["drives"][0]["set_points"], 0);
    });
}

#[test]
fn ctrl_c_stops_a_jog_and_disables() {
    undisturbed(|| {
        let bench = BenchProcess::start("jog-stop", "1");
        bench.disable("1");
        // Ten turns at 60 rpm take 19 s.
        let arguments = [
            "jog",
            "--slcan",
            bench.path(),
            "--drive",
            "1",
            "--turns",
            "10",
            "--yes",
        ];
        let child = start_and_wait_for(motionctl(&arguments), "Ctrl-C stops it");
        std::thread::sleep(std::time::Duration::from_secs(3));
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(130), "{output:?}");
        let report = bench.stop();
        let drive = &report["drives"][0];
        assert_eq!(drive["enabled"], false, "{drive}");
        let received = drive["received_counts"].as_i64().expect("a count");
        assert!((0..163_840).contains(&received), "{drive}");
    });
}

#[test]
fn enable_holds_until_ctrl_c_and_then_disables() {
    undisturbed(|| {
        let bench = BenchProcess::start("enable", "1,2,3");
        bench.disable("2");
        let arguments = [
            "enable",
            "--slcan",
            bench.path(),
            "--drives",
            "2,3",
            "--yes",
            "--json",
        ];
        let child = start_and_wait_for(motionctl(&arguments), "enabled and hold");
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let ended: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(
            ended,
            json!({ "disabled": [2], "unconfirmed": [], "left_enabled": [3] })
        );
        let (_, errors) = status_and_errors(&output);
        assert!(
            errors.contains("drive 3 was enabled before and STAYS ENABLED"),
            "{errors}"
        );
        let report = bench.stop();
        assert_eq!(report["drives"][1]["received_counts"], 0);
        assert_eq!(report["drives"][1]["enabled"], false);
        assert_eq!(report["drives"][0]["enabled"], true);
        assert_eq!(report["drives"][2]["enabled"], true);
    });
}

#[test]
fn a_killed_holder_leaves_drives_that_disable_ends() {
    undisturbed(|| {
        let bench = BenchProcess::start("disable", "1,2");
        let arguments = [
            "enable",
            "--slcan",
            bench.path(),
            "--drives",
            "1,2",
            "--yes",
        ];
        let mut child = start_and_wait_for(motionctl(&arguments), "enabled and hold");
        kill_process(Pid::from_child(&child), Signal::KILL).expect("the process is there");
        child.wait().expect("its end");
        assert_eq!(
            json_on(&bench, &["disable", "--drives", "1-2"]),
            json!({ "disabled": [1, 2], "unconfirmed": [], "left_enabled": [] })
        );
        let (status, text, errors) = on(&bench, &["disable", "--drives", "2,9", "--json"]);
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("drive 9 did not confirm"), "{errors}");
        assert!(text.contains("\"unconfirmed\": [\n    9"), "{text}");
        let report = bench.stop();
        assert_eq!(report["drives"][0]["enabled"], false);
        assert_eq!(report["drives"][1]["enabled"], false);
    });
}

#[test]
fn commands_that_stream_no_motion_work_on_the_fullest_bus() {
    undisturbed(|| {
        let bench = BenchProcess::start("full", "1-63");
        let ended = json_on(&bench, &["disable", "--drives", "1-63"]);
        assert_eq!(ended["disabled"].as_array().map(Vec::len), Some(63));
        // Set-points of that many axes do not fit into a cycle, and that is known before any is sent.
        let trajectory = [
            "run",
            "--columns",
            "2,2,2,2,2,2,2,2,2,2,2,2,2,2,2,2",
            "--yes",
        ];
        let (status, _, errors) = on(&bench, &trajectory);
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("does not fit"), "{errors}");
        assert_eq!(bench.stop()["drives"][0]["set_points"], 0);
    });
}

#[test]
fn monitor_shows_each_drive_and_who_is_missing() {
    undisturbed(|| {
        let bench = BenchProcess::start("monitor", "1");
        let arguments = [
            "monitor",
            "--drives",
            "1,5",
            "--count",
            "2",
            "--every-ms",
            "900",
            "--json",
        ];
        let (status, text, errors) = on(&bench, &arguments);
        assert_eq!(status, Some(0), "{errors}");
        let lines: Vec<Value> = text
            .lines()
            .map(|line| serde_json::from_str(line).expect("JSON"))
            .collect();
        let answers: Vec<_> = lines
            .iter()
            .map(|line| (line["drive"].as_u64(), line["answers"].as_bool()))
            .collect();
        let pair = [(Some(1), Some(true)), (Some(5), Some(false))];
        assert_eq!(answers, [pair, pair].concat());
        assert_eq!(lines[0]["position_counts"], 0);
        // Every value has its age, and one that never was read has none.
        for age in ["status_ms", "position_ms", "torque_ms", "speed_ms"] {
            let ms = lines[2]["ages"][age].as_u64();
            assert!(ms.is_some_and(|ms| ms < 2_000), "{lines:?}");
            assert!(lines[3]["ages"][age].is_null(), "{lines:?}");
        }
        assert_eq!(bench.stop()["drives"][0]["set_points"], 0);
    });
}

#[test]
fn a_vanished_adapter_ends_a_hold_with_a_warning() {
    undisturbed(|| {
        let mut bench = BenchProcess::start("hold-vanish", "1");
        let arguments = ["enable", "--slcan", bench.path(), "--drives", "1", "--yes"];
        let child = start_and_wait_for(motionctl(&arguments), "enabled and hold");
        bench.kill();
        let output = child.wait_with_output().expect("its output");
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(3), "{errors}");
        assert!(errors.contains("the adapter is gone"), "{errors}");
        assert!(errors.contains("drive 1 may still be ENABLED"), "{errors}");
    });
}

#[test]
fn completions_know_the_commands() {
    undisturbed(|| {
        for shell in ["bash", "zsh", "fish"] {
            let output = motionctl(&["completions", shell])
                .output()
                .expect("motionctl runs");
            let script = String::from_utf8_lossy(&output.stdout);
            assert!(
                script.contains("monitor") && script.contains("slcan"),
                "{shell}"
            );
        }
    });
}

#[test]
fn monitor_shows_no_value_that_is_too_old() {
    undisturbed(|| {
        let bench = BenchProcess::start("commission-stale", "1");
        let arguments = ["monitor", "--slcan", bench.path(), "--drives", "1"];
        let often = ["--every-ms", "250", "--count", "24", "--json"];
        let mut child = motionctl(&[&arguments[..], &often].concat())
            .spawn()
            .expect("motionctl starts");
        let mut lines = BufReader::new(child.stdout.take().expect("it is piped")).lines();
        let mut next = || -> Option<Value> {
            let line = lines.next()?.expect("a line");
            Some(serde_json::from_str(&line).expect("JSON"))
        };
        while next().expect("a line")["position_counts"].is_null() {}
        bench.signal(Signal::STOP);
        let mut last = Value::Null;
        while let Some(line) = next() {
            last = line;
        }
        bench.signal(Signal::CONT);
        child.wait().expect("its end");
        assert_eq!(last["answers"], false, "{last}");
        assert!(last["enabled"].is_null() && last["position_counts"].is_null());
        assert!(last["ages"]["position_ms"].as_u64() > Some(500), "{last}");
    });
}
