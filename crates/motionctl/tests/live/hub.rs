//! Hub motors (`--drives zlac`) against a bench: every word, its exit status and its JSON.

use serde_json::Value;

use crate::bench::{BenchProcess, interrupt, motionctl, start_and_wait_for, wait_until};
use crate::settings::{Backup, json_of, on};
use crate::undisturbed::undisturbed;

fn start(name: &str, nodes: &str) -> BenchProcess {
    BenchProcess::start(name, nodes)
}

fn json(bench: &BenchProcess, words: &[&str]) -> Value {
    json_of(on(bench, &[words, &["--json"]].concat()))
}

/// The value of an object.
fn value(bench: &BenchProcess, drives: &str, object: &str) -> i64 {
    let values = json(bench, &["read", "--drives", drives, object]);
    values[0]["value"].as_i64().expect("a number")
}

/// A command that must end with this status; its errors.
fn fails(bench: &BenchProcess, status: i32, words: &[&str]) -> String {
    let (actual, text, errors) = on(bench, words);
    assert_eq!(actual, Some(status), "{words:?}: {text}{errors}");
    errors
}

fn drive(report: &Value, place: usize) -> &Value {
    &report["drives"][place]
}

#[test]
fn a_first_hour_from_the_box_to_the_restored_drive() {
    undisturbed(|| {
        let bench = start("hub-hour", "zlac");
        let found = json(&bench, &["scan", "--drives", "zlac", "--yes"]);
        assert_eq!(found["drives"][0]["drive"], 4);
        let end = json(
            &bench,
            &[
                "assign-id",
                "--drives",
                "zlac",
                "--from",
                "4",
                "--to",
                "9",
                "--yes",
            ],
        );
        assert_eq!((&end["confirmed"], &end["to"]), (&true.into(), &9.into()));
        let file = Backup::new("hub-hour");
        json(&bench, &["backup", file.path(), "--drives", "zlac:9"]);
        assert!(
            file.text()
                .contains("\"2014h:00\" = 150  # rated-current, 0.1 A")
        );
        let written = json(
            &bench,
            &[
                "write",
                "--drives",
                "zlac:9",
                "rated-current=120",
                "2018h=500",
                "--yes",
            ],
        );
        assert_eq!(
            (&written["eeprom_writes"], &written["saved"]),
            (&1.into(), &true.into())
        );
        assert_eq!(value(&bench, "zlac:9", "2014h"), 120);
        let jogged = json(
            &bench,
            &[
                "jog", "--drives", "zlac:9", "--turns", "-0.5", "--rpm", "60", "--yes",
            ],
        );
        assert_eq!(
            (&jogged["asked_counts"], &jogged["arrived"]),
            (&(-2048).into(), &true.into())
        );
        let read = jogged["read_counts"].as_i64().expect("a position");
        assert!((read + 2048).abs() <= 20, "{read}");
        // What the master of the jog has left in RAM differs too: only the stored values are asked for.
        bench.signal(rustix::process::Signal::USR1);
        wait_until("the drive is back", || {
            on(&bench, &["read", "--drives", "zlac:9", "2014h"]).0 == Some(0)
        });
        let compared = on(
            &bench,
            &["restore", file.path(), "--drives", "zlac", "--compare"],
        );
        assert_eq!(compared.0, Some(1), "{compared:?}");
        assert!(
            compared.1.contains("2014h:00 rated-current: 120 -> 150"),
            "{compared:?}"
        );
        let restored = json(
            &bench,
            &["restore", file.path(), "--drives", "zlac", "--yes"],
        );
        let changes = restored["drives"][0]["changes"].as_array().expect("a list");
        assert_eq!(
            (restored["complete"].as_bool(), changes.len()),
            (Some(true), 2)
        );
        let again = json(
            &bench,
            &["restore", file.path(), "--drives", "zlac", "--yes"],
        );
        assert_eq!(again["drives"][0]["eeprom_writes"], 0);
        let report = bench.stop();
        // assign-id, write and restore saved once each.
        assert_eq!(drive(&report, 0)["eeprom_writes"], 3);
        assert_eq!(drive(&report, 0)["enabled"], false);
    });
}

#[test]
fn wheels_turn_at_their_speeds_and_are_switched_off() {
    undisturbed(|| {
        let bench = start("hub-speed", "zlac:4,5");
        let csv = Backup::new("hub-speed");
        let end = json(
            &bench,
            &[
                "speed",
                "--drives",
                "zlac:5,4",
                "--rpm",
                "60,-30",
                "--for",
                "1",
                "--yes",
                "--csv",
                csv.path(),
            ],
        );
        assert_eq!(end["reached"], true);
        let wheel = |node: u64| {
            let wheels = end["wheels"].as_array().expect("a list");
            let wheel = wheels.iter().find(|wheel| wheel["node"] == node);
            wheel.expect("the node")["rpm"].as_f64()
        };
        // In the order given: the first speed is that of node 5.
        assert_eq!((wheel(5), wheel(4)), (Some(60.0), Some(-30.0)));
        let text = csv.text();
        assert!(text.starts_with("time_s,node,target_rpm,speed_rpm,torque,position_counts\n"));
        assert!(text.lines().count() > 100, "{}", text.lines().count());
        let states = on(
            &bench,
            &["monitor", "--drives", "zlac:4,5", "--count", "1", "--json"],
        );
        let states: Vec<Value> = states
            .1
            .lines()
            .map(|line| serde_json::from_str(line).expect("JSON"))
            .collect();
        assert_eq!(states.len(), 2);
        for state in &states {
            assert_eq!(
                (&state["enabled"], &state["answers"]),
                (&false.into(), &true.into())
            );
            assert_eq!(
                (&state["bus_volts"], &state["mode"]),
                (&48.0.into(), &"velocity".into())
            );
        }
        let report = bench.stop();
        let travel = |place| {
            drive(&report, place)["travel_counts"]
                .as_i64()
                .expect("counts")
        };
        assert!(travel(0) < -2_000 && travel(1) > 4_000, "{report}");
        assert_eq!(drive(&report, 1)["eeprom_writes"], 0);
    });
}

#[test]
fn a_wheel_moves_to_a_position_and_by_a_way_and_arrives() {
    undisturbed(|| {
        let bench = start("hub-move", "zlac");
        let by = [
            "move", "--drives", "zlac", "--by", "-3000", "--rpm", "120", "--yes",
        ];
        let end = json(&bench, &by);
        assert_eq!(
            (&end["arrived"], &end["asked_counts"]),
            (&true.into(), &(-3000).into())
        );
        let to = [
            "move", "--drives", "zlac", "--to", "1096", "--rpm", "120", "--yes",
        ];
        let end = json(&bench, &to);
        let position = end["position_counts"].as_i64().expect("a position");
        assert!((position - 1_096).abs() <= 20, "{end}");
        let far = ["move", "--drives", "zlac", "--to", "1073741824", "--yes"];
        let errors = fails(&bench, 2, &far);
        assert!(errors.contains("-1073741823..=1073741823"), "{errors}");
        let report = bench.stop();
        let travel = drive(&report, 0)["travel_counts"].as_i64().expect("counts");
        assert!((travel - 1_096).abs() <= 20, "{report}");
        assert_eq!(drive(&report, 0)["enabled"], false);
    });
}

#[test]
fn enabled_drives_are_held_until_ctrl_c_and_refused_meanwhile() {
    undisturbed(|| {
        let bench = start("hub-enable", "zlac");
        let held = json(
            &bench,
            &["enable", "--drives", "zlac", "--for", "1", "--yes"],
        );
        assert_eq!(held["disabled"][0], 4);
        let command = motionctl(&[
            "enable",
            "--slcan",
            bench.path(),
            "--drives",
            "zlac",
            "--yes",
            "--json",
        ]);
        let child = start_and_wait_for(command, "Ctrl-C ends it");
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        // Killed, it leaves the drive enabled; its own supervision stops the wheel, and disable switches it off.
        let command = motionctl(&[
            "enable",
            "--slcan",
            bench.path(),
            "--drives",
            "zlac",
            "--yes",
        ]);
        let mut child = start_and_wait_for(command, "Ctrl-C ends it");
        child.kill().expect("it can be ended");
        child.wait().expect("it ended");
        for words in [
            &["jog", "--drives", "zlac", "--turns", "1", "--yes"] as &[&str],
            &["write", "--drives", "zlac", "2014h=100", "--yes"],
            &["origin", "--drives", "zlac", "--set", "--yes"],
            &[
                "assign-id",
                "--drives",
                "zlac",
                "--from",
                "4",
                "--to",
                "7",
                "--yes",
            ],
        ] {
            let errors = fails(&bench, 2, words);
            assert!(
                errors.contains("node 4 is enabled") && errors.contains("disable"),
                "{errors}"
            );
        }
        let disabled = json(&bench, &["disable", "--drives", "zlac"]);
        assert_eq!(disabled["disabled"][0], 4);
        let report = bench.stop();
        assert_eq!(drive(&report, 0)["enabled"], false);
    });
}

#[test]
fn a_fault_keeps_a_drive_from_moving_until_it_is_reset() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("hub-fault", "zlac", &["--alarm", "zlac:4"]);
        let errors = fails(
            &bench,
            1,
            &["jog", "--drives", "zlac", "--turns", "1", "--yes"],
        );
        assert!(
            errors.contains("0004h: over-current") && errors.contains("reset"),
            "{errors}"
        );
        let end = json(&bench, &["reset", "--drives", "zlac", "--yes"]);
        assert_eq!(end["fault_before"], "0004h: over-current");
        assert_eq!(end["fault_after"], Value::Null);
        let origin = json(&bench, &["origin", "--drives", "zlac", "--set", "--yes"]);
        assert_eq!(origin["position_counts"], 0);
        let end = json(&bench, &["reset", "--drives", "zlac", "--factory", "--yes"]);
        assert_eq!(
            (&end["factory_settings"], &end["node_after"]),
            (&true.into(), &4.into())
        );
    });
}

#[test]
fn a_restore_that_fails_says_what_was_written_and_saves_nothing() {
    undisturbed(|| {
        let bench = start("hub-partly-first", "zlac");
        let file = Backup::new("hub-partly");
        json(&bench, &["backup", file.path(), "--drives", "zlac"]);
        drop(bench);
        file.edit(&[
            ("\"2014h:00\" = 150", "\"2014h:00\" = 140"),
            ("\"2015h:00\" = 300", "\"2015h:00\" = 280"),
            ("\"2016h:00\" = 300", "\"2016h:00\" = 250"),
        ]);
        // 2010h and the first of three.
        let options = ["--silent-after-writes", "2"];
        let bench = BenchProcess::start_with("hub-partly", "zlac", &options);
        let words = [
            "restore",
            file.path(),
            "--drives",
            "zlac",
            "--yes",
            "--json",
        ];
        let (status, text, errors) = on(&bench, &words);
        assert_eq!(status, Some(4), "{text}{errors}");
        let outcome: Value = serde_json::from_str(&text).expect("JSON");
        let changes = outcome["drives"][0]["changes"].as_array().expect("a list");
        let results: Vec<&Value> = changes.iter().map(|change| &change["result"]).collect();
        assert_eq!(results, ["written", "unknown", "not-written"]);
        assert_eq!(outcome["complete"], false);
        assert!(
            errors.contains("2015h:00") && errors.contains("a power cycle undoes it"),
            "{errors}"
        );
        let report = bench.stop();
        assert_eq!(drive(&report, 0)["eeprom_writes"], 0);
    });
}

#[test]
fn mappings_are_restored_closed_and_opened_in_pre_operational() {
    undisturbed(|| {
        let bench = start("hub-mapping", "zlac");
        let file = Backup::new("hub-mapping");
        json(&bench, &["backup", file.path(), "--drives", "zlac"]);
        // Speed in TPDO0, as the guide prints it (6.1).
        file.edit(&[
            ("\"1A00h:00\" = 0", "\"1A00h:00\" = 1"),
            ("\"1A00h:01\" = 0", "\"1A00h:01\" = 0x606C0020"),
        ]);
        let restored = json(
            &bench,
            &["restore", file.path(), "--drives", "zlac", "--yes"],
        );
        assert_eq!(restored["complete"], true, "{restored}");
        assert_eq!(restored["drives"][0]["pre_operational"], true);
        assert_eq!(value(&bench, "zlac", "1A00h:01"), 0x606C_0020);
        assert_eq!(value(&bench, "zlac", "1A00h:00"), 1);
        // One that is in force is closed for its entries, and is in force again with the count that it had.
        file.edit(&[("0x606C0020", "0x60640020")]);
        let words = ["restore", file.path(), "--drives", "zlac", "--yes"];
        let restored = json(&bench, &words);
        assert_eq!(restored["complete"], true, "{restored}");
        assert_eq!(value(&bench, "zlac", "1A00h:01"), 0x6064_0020);
        assert_eq!(value(&bench, "zlac", "1A00h:00"), 1);
    });
}

#[test]
fn a_mapping_that_is_refused_is_said_to_be_closed() {
    undisturbed(|| {
        let bench = start("hub-refused", "zlac");
        let file = Backup::new("hub-refused");
        json(&bench, &["backup", file.path(), "--drives", "zlac"]);
        // 1000h cannot be mapped, which the drive says when the mapping is to be in force.
        file.edit(&[
            ("\"1A00h:00\" = 0", "\"1A00h:00\" = 1"),
            ("\"1A00h:01\" = 0", "\"1A00h:01\" = 0x10000020"),
        ]);
        let words = [
            "restore",
            file.path(),
            "--drives",
            "zlac",
            "--yes",
            "--json",
        ];
        let (status, text, errors) = on(&bench, &words);
        assert_eq!(status, Some(4), "{text}{errors}");
        assert!(errors.contains("node 4 refuses 1A00h:00"), "{errors}");
        let outcome: Value = serde_json::from_str(&text).expect("JSON");
        let drive_outcome = &outcome["drives"][0];
        assert_eq!(drive_outcome["closed_mappings"][0], "1A00h:00");
        assert_eq!(drive_outcome["saved"], false);
        let report = bench.stop();
        assert_eq!(drive(&report, 0)["eeprom_writes"], 0);
    });
}

#[test]
fn what_makes_no_sense_is_refused_with_what_to_do() {
    undisturbed(|| {
        let bench = start("hub-refusals", "zlac:4,5");
        for (status, words, text) in [
            (
                1,
                &["read", "--drives", "zlac:7"] as &[&str],
                "node 7 does not answer",
            ),
            (
                2,
                &["read", "--drives", "zlac", "2024h"],
                "no object 2024h:00",
            ),
            (
                2,
                &["write", "--drives", "zlac", "2014h=151", "--yes"],
                "0..=150, got 151",
            ),
            (
                2,
                &["write", "--drives", "zlac", "6040h=15", "--yes"],
                "could move the motor",
            ),
            (
                2,
                &["write", "--drives", "zlac", "2014h=1", "2014h=2", "--yes"],
                "given twice",
            ),
            (
                2,
                &["write", "--drives", "zlac", "2014h=1"],
                "needs a confirmation",
            ),
            (
                2,
                &["jog", "--drives", "zlac", "--turns", "11", "--yes"],
                "-10..=10",
            ),
            (
                2,
                &["jog", "--drives", "zlac:4,5", "--turns", "1", "--yes"],
                "for one drive",
            ),
            (
                2,
                &[
                    "speed", "--drives", "zlac", "--rpm", "1,2", "--for", "1", "--yes",
                ],
                "expected one speed or 1",
            ),
            (
                2,
                &[
                    "speed", "--drives", "zlac", "--rpm", "0.4", "--for", "1", "--yes",
                ],
                "rounds to 0",
            ),
            (
                1,
                &[
                    "assign-id",
                    "--drives",
                    "zlac",
                    "--from",
                    "4",
                    "--to",
                    "5",
                    "--yes",
                ],
                "node 5 answers already",
            ),
            (
                2,
                &[
                    "assign-id",
                    "--drives",
                    "zlac",
                    "--from",
                    "4",
                    "--to",
                    "3",
                    "--yes",
                ],
                "DIP switch",
            ),
            (2, &["probe", "--drives", "zlac"], "lowest byte comes first"),
            (
                2,
                &["limits", "--drives", "zlac"],
                "`motionctl plan --drives zlac`",
            ),
            (
                2,
                &["restore", "/no/such/file", "--drives", "zlac"],
                "cannot read",
            ),
        ] {
            let errors = fails(&bench, status, words);
            assert!(errors.contains(text), "{words:?}: {errors}");
        }
        let report = bench.stop();
        for place in [0, 1] {
            assert_eq!(drive(&report, place)["eeprom_writes"], 0);
            assert_eq!(drive(&report, place)["travel_counts"], 0);
        }
    });
}

#[test]
fn a_dry_run_shows_the_frames_and_opens_nothing() {
    let frames = |words: &[&str]| {
        let link = ["--slcan", "/dev/no-such-port", "--dry-run", "--json"];
        let output = motionctl(&[words, &link].concat())
            .output()
            .expect("it runs");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let shown: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(shown["dry_run"], true);
        let frames = shown["frames"].as_array().expect("a list").iter();
        let hex: Vec<String> = frames
            .map(|frame| frame["hex"].as_str().expect("text").to_owned())
            .collect();
        hex
    };
    let write = frames(&["write", "--drives", "zlac:5", "2014h=120"]);
    assert!(
        write.contains(&"605#2B14200078000000".to_owned()),
        "{write:?}"
    );
    assert_eq!(
        write.last().map(String::as_str),
        Some("605#2B09200002000000")
    );
    let reset = frames(&["reset", "--drives", "zlac"]);
    assert!(
        reset.contains(&"604#2B40600080000000".to_owned()),
        "{reset:?}"
    );
    let factory = frames(&["reset", "--drives", "zlac", "--factory"]);
    assert!(
        factory.contains(&"604#2B09200001000000".to_owned()),
        "{factory:?}"
    );
    let assign = frames(&["assign-id", "--drives", "zlac", "--from", "4", "--to", "9"]);
    assert!(
        assign.contains(&"604#2B0D200009000000".to_owned()),
        "{assign:?}"
    );
    assert!(assign.contains(&"000#8104".to_owned()), "{assign:?}");
    let origin = frames(&["origin", "--drives", "zlac", "--set"]);
    assert_eq!(origin.len(), 3, "{origin:?}");
}

#[test]
fn a_bus_is_planned_for_its_wheels() {
    let plan = |words: &[&str]| {
        let words = [&["plan", "--json"], words].concat();
        let output = motionctl(&words).output().expect("it runs");
        let plan: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        (output.status.code(), plan)
    };
    let (status, fits) = plan(&["--drives", "zlac:4,5"]);
    assert_eq!((status, &fits["fits"]), (Some(0), &true.into()));
    let (status, late) = plan(&["--drives", "zlac:4-11", "--cycle-us", "2000"]);
    assert_eq!((status, &late["fits"]), (Some(1), &false.into()));
    assert!(
        late["reason"]
            .as_str()
            .expect("text")
            .contains("longer cycle")
    );
}

/// The example, from this package.
const SQUARE: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../examples/square-twist.csv"
);

#[test]
fn a_number_that_counts_after_a_restart_is_said_and_a_wheel_that_did_not_get_one_is_stopped_early()
{
    undisturbed(|| {
        let bench = start("hub-restart", "zlac");
        let write = [
            "write",
            "--drives",
            "zlac",
            "speed-resolution-divider=10",
            "--yes",
        ];
        let (status, text, errors) = on(&bench, &write);
        assert_eq!(status, Some(0), "{text}{errors}");
        let wanted = "202Fh:05 counts when the drive has been switched off and on";
        assert!(text.contains(wanted), "{text}");
        let speed = [
            "speed", "--drives", "zlac", "--rpm", "60", "--for", "1", "--yes",
        ];
        let errors = fails(&bench, 1, &speed);
        assert!(errors.contains("at most 120.0 are allowed"), "{errors}");
        bench.signal(rustix::process::Signal::USR1);
        wait_until("the drive is back", || {
            on(&bench, &["read", "--drives", "zlac", "202Fh:05"]).0 == Some(0)
        });
        let (status, text, errors) = on(&bench, &speed);
        assert_eq!(status, Some(0), "{text}{errors}");
    });
}

#[test]
fn a_vehicle_drives_a_square_on_the_bench() {
    undisturbed(|| {
        let options = ["--speed-resolution", "10"];
        let bench = BenchProcess::start_with("hub-square", "zlac:4,5", &options);
        let log = Backup::new("hub-square");
        let end = json(
            &bench,
            &[
                "run",
                "--drives",
                "zlac:4,5",
                "--twist",
                SQUARE,
                "--track",
                "0.4",
                "--wheel-radius",
                "0.085",
                "--odometry",
                log.path(),
                "--yes",
            ],
        );
        assert_eq!(
            (&end["complete"], &end["stands"]),
            (&true.into(), &true.into()),
            "{end}"
        );
        // A PC is late now and then, and the feedback of the two wheels comes at different times.
        let closed_m = end["pose"]["from_start_m"].as_f64().expect("a number");
        assert!(closed_m < 0.05, "{end}");
        assert!(
            log.text()
                .starts_with("time_s,x_m,y_m,heading_rad,left_counts,right_counts\n")
        );
        let wheels = end["wheels"].clone();
        let report = bench.stop();
        for place in [0, 1] {
            let read = wheels[place]["counts"].as_i64().expect("counts");
            let travel = drive(&report, place)["travel_counts"]
                .as_i64()
                .expect("counts");
            assert!((read - travel).abs() <= 2, "{read} {travel}");
        }
    });
}

#[test]
fn a_stream_of_twists_that_falls_silent_stops_the_wheels() {
    use std::io::Write as _;
    undisturbed(|| {
        let options = ["--speed-resolution", "10"];
        let bench = BenchProcess::start_with("hub-twists", "zlac:4,5", &options);
        let mut command = motionctl(&[
            "run",
            "--slcan",
            bench.path(),
            "--drives",
            "zlac:4,5",
            "--twist",
            "-",
            "--track",
            "0.4",
            "--wheel-radius",
            "0.085",
            "--yes",
        ]);
        command.stdin(std::process::Stdio::piped());
        let mut child = start_and_wait_for(command, "Ctrl-C slows them down");
        let mut stream = child.stdin.take().expect("it is piped");
        writeln!(stream, "0,0.1,0").expect("it reads");
        let errors = child.stderr.as_mut().expect("it is piped");
        let mut heard = Vec::new();
        while !String::from_utf8_lossy(&heard).contains("no twist came in time") {
            let mut byte = [0];
            let length = std::io::Read::read(errors, &mut byte).expect("its error output");
            assert_eq!(length, 1, "{}", String::from_utf8_lossy(&heard));
            heard.push(byte[0]);
        }
        writeln!(stream, "9,0.1,nonsense").expect("it reads");
        drop(stream);
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(
            errors.contains("line 2, column 3: expected a number (omega in rad/s)"),
            "{errors}"
        );
        let report = bench.stop();
        for place in [0, 1] {
            assert_eq!(drive(&report, place)["enabled"], false);
            assert_eq!(drive(&report, place)["speed_rpm"], 0.0);
            assert!(
                drive(&report, place)["travel_counts"].as_i64() > Some(100),
                "{report}"
            );
        }
    });
}

/// An event of a Linux joystick: 0x01 is a button, 0x02 a stick.
fn stick(kind: u8, number: u8, value: i16) -> [u8; 8] {
    let [low, high] = value.to_le_bytes();
    [0, 0, 0, 0, low, high, kind, number]
}

#[test]
fn a_joystick_drives_two_hub_motors_and_its_button_ends_it() {
    use std::io::{Read as _, Write as _};
    use std::process::{Command, Stdio};
    undisturbed(|| {
        let folder = crate::tool::Folder::new("joystick");
        std::fs::create_dir_all(&folder.0).expect("a folder");
        let device = folder.file("js0");
        let made = Command::new("mkfifo").arg(&device).status();
        assert!(made.is_ok_and(|status| status.success()), "mkfifo");
        let example = concat!(
            env!("CARGO_MANIFEST_DIR"),
            "/../../examples/twist_stream.py"
        );
        let mut program = Command::new("python3")
            .args([example, "--joystick", &device, "--speed", "0.2"])
            .stdout(Stdio::piped())
            .spawn()
            .expect("Python is there");
        let options = ["--speed-resolution", "10"];
        let bench = BenchProcess::start_with("hub-joystick", "zlac:4,5", &options);
        let mut command = motionctl(&[
            "run",
            "--slcan",
            bench.path(),
            "--drives",
            "zlac:4,5",
            "--twist",
            "-",
            "--track",
            "0.4",
            "--wheel-radius",
            "0.085",
            "--reversed",
            "right",
            "--yes",
        ]);
        command.stdin(program.stdout.take().expect("it is piped"));
        // It opens when Python does.
        let mut joystick = std::fs::OpenOptions::new()
            .write(true)
            .open(&device)
            .expect("a pipe");
        let mut move_stick = |event: [u8; 8]| joystick.write_all(&event).expect("it reads");
        // Where the stick stands, and nearly in the middle.
        move_stick(stick(0x82, 1, 400));
        let mut child = start_and_wait_for(command, "Ctrl-C slows them down");
        move_stick(stick(0x02, 1, -32_767));
        std::thread::sleep(std::time::Duration::from_secs(1));
        move_stick(stick(0x01, 0, 1));
        assert!(program.wait().is_ok_and(|status| status.success()));
        let mut errors = String::new();
        let heard = child.stderr.take().expect("it is piped");
        std::io::BufReader::new(heard)
            .read_to_string(&mut errors)
            .expect("its error output");
        let status = child.wait().expect("it ends").code();
        assert_eq!(status, Some(0), "{errors}");
        assert!(!errors.contains("no twist came in time"), "{errors}");
        let report = bench.stop();
        let [left, right] = [0, 1].map(|place| drive(&report, place)["travel_counts"].as_i64());
        // Forwards: one of two wheels that are mounted alike counts down.
        assert!(left > Some(100) && right < Some(-100), "{report}");
        for place in [0, 1] {
            assert_eq!(drive(&report, place)["enabled"], false);
            assert_eq!(drive(&report, place)["speed_rpm"], 0.0);
        }
    });
}

#[test]
fn speeds_of_a_file_run_on_the_bench_and_wrong_ones_are_refused() {
    undisturbed(|| {
        let bench = start("hub-run", "zlac:4,5");
        let file = crate::bench::Scratch::new(
            "hub-run.csv",
            "t,l,r\n0,0,0\n0.5,30,60\n1,30,60\n1.5,0,0\n",
        );
        let words = [
            "run",
            "--drives",
            "zlac:4,5",
            "--trajectory",
            file.path(),
            "--yes",
        ];
        let end = json(&bench, &words);
        assert_eq!(end["complete"], true, "{end}");
        for (wheel, turns) in [(0, 0.5), (1, 1.0)] {
            let counts = end["wheels"][wheel]["counts"].as_f64().expect("counts");
            assert!((counts / 4_096.0 - turns).abs() < 0.03, "{end}");
        }
        let slow = ["--max-acceleration", "100"];
        let errors = fails(&bench, 2, &[&words[..], &slow].concat());
        assert!(errors.contains("--max-acceleration allows 100"), "{errors}");
        let one = [
            "run",
            "--drives",
            "zlac:4",
            "--twist",
            SQUARE,
            "--track",
            "0.4",
            "--wheel-radius",
            "0.085",
            "--yes",
        ];
        let errors = fails(&bench, 2, &one);
        assert!(errors.contains("zlac:LEFT,RIGHT"), "{errors}");
    });
}
