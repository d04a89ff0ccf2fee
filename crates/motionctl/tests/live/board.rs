//! `motionctl board` against `motionctl bench --board` as users run them, and what happens when host, line, inputs or board fail.

use std::fs::File;
use std::io::{Read, Write};
use std::time::Duration;

use board_link::frame::{Decoder, VERSION, checksum, decode};
use board_link::message::{Reason, ToHost};
use serde_json::Value;

use crate::bench::{BenchProcess, Scratch, interrupt, motionctl, scratch, wait_until};
use crate::board_line::{BoardBench, DamagedLine, SETTINGS, run_at};
use crate::terminal::Terminal;
use crate::tool::bus::steps;
use crate::undisturbed::undisturbed;

/// One turn and half a turn back, curved and with a rest.
const SHORT: &str = "time_s,a,b\n0,0,0\n0.31,180,-45\n0.6,300,-90\n0.9,360,-180\n1.0,360,-180\n";
/// A motion that is soon over.
const QUICK: &str = "time_s,a,b\n0,0,0\n0.1,20,-10\n0.25,60,-20\n0.4,60,-20\n";
/// Two axes that go on for long, at 30 counts a cycle after a few seconds.
const LONG: &str = "time_s,a,b\n0,0,0\n12,7200,-7200\n";
/// Steps that change from one cycle to the next by no more than the settings allow, 2.73 counts, and what rounding adds.
const MOST_CHANGE: i64 = 4;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// From the first step that moves something to the last.
fn moving(steps: &[i64]) -> &[i64] {
    let first = steps.iter().position(|step| *step != 0).unwrap_or(0);
    let last = steps.iter().rposition(|step| *step != 0);
    steps.get(first..=last.unwrap_or(0)).unwrap_or_default()
}

/// The set-points slow down within the limits, to rest.
fn is_ramp(steps: &[i64]) {
    let moving = moving(steps);
    assert!(moving.len() > 100, "it moved: {}", moving.len());
    let ends = [&[0], moving, &[0]].concat();
    for (place, pair) in ends.windows(2).enumerate() {
        let change = (pair[1] - pair[0]).abs();
        let of = ends.len();
        assert!(change <= MOST_CHANGE, "{place} of {of}: {pair:?}");
    }
}

fn numbers(list: &Value, field: &str) -> Vec<i64> {
    let entries = list.as_array().expect("a list");
    let number = |entry: &Value| entry[field].as_i64().expect("a number");
    entries.iter().map(number).collect()
}

fn are_off(report: &Value) {
    for drive in report["drives"].as_array().expect("a list") {
        assert_eq!(drive["enabled"], false, "{report}");
        assert_eq!(drive["alarm"], Value::Null, "{report}");
    }
}

/// Starts a motion that goes on for long, and waits until both axes are under way.
fn start_long(bench: &BoardBench, file: &Scratch) -> std::process::Child {
    let words = ["run", file.path(), "--max-turns", "30", "--yes", "--json"];
    let child = bench.spawn(&words);
    // It is enabled within a second, and begins with 0.3 s buffered.
    std::thread::sleep(Duration::from_secs(4));
    child
}

fn end_of(child: std::process::Child) -> (Option<i32>, Value, String) {
    let output = child.wait_with_output().expect("its output");
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(!text.is_empty(), "{errors}");
    (output.status.code(), json(&text), errors)
}

#[test]
fn a_motion_arrives_and_both_sides_have_the_same_sums() {
    undisturbed(|| {
        let bench = BoardBench::start("board-sums", SETTINGS);
        let file = Scratch::new("board-sums.csv", SHORT);
        let table = Scratch::new("board-sums-run.csv", "");
        let run = ["run", file.path(), "--yes", "--json", "--csv", table.path()];
        let (status, text, errors) = bench.run(&run);
        assert_eq!(status, Some(0), "{errors}{text}");
        let summary = json(&text);
        for sums in ["target_counts", "set_point_counts", "read_counts"] {
            assert_eq!(numbers(&summary["axes"], sums), [16_384, -8_192], "{sums}");
        }
        assert_eq!(summary["differs_by_counts"], 0);
        assert_eq!(summary["segments_sent"], summary["segments"]);
        assert_eq!(
            (&summary["completed"], &summary["disabled"]),
            (&true.into(), &true.into())
        );
        let rows = std::fs::read_to_string(table.path()).expect("a table");
        assert!(rows.lines().count() > 50, "{rows}");
        assert!(rows.contains(",16384,"), "{rows}");
        let info = bench.info();
        assert_eq!(
            (&info["state"], &info["stream"]),
            (&"off".into(), &"complete".into())
        );
        let (report, steps) = bench.end();
        assert_eq!(
            numbers(&report["drives"], "received_counts"),
            [16_384, -8_192]
        );
        assert_eq!(
            numbers(&report["drives"], "position_counts"),
            [16_384, -8_192]
        );
        assert_eq!(report["board"]["late_cycles"], 0);
        assert_eq!(report["board"]["silent_hosts"], 0);
        are_off(&report);
        for steps in &steps {
            is_ramp(steps);
        }
    });
}

#[test]
fn the_set_points_on_the_bus_are_those_of_motionctl_run() {
    undisturbed(|| {
        let file = Scratch::new("board-same.csv", QUICK);
        let bench = BoardBench::start("board-same", SETTINGS);
        let (status, text, errors) = bench.run(&["run", file.path(), "--yes", "--json"]);
        assert_eq!(status, Some(0), "{errors}{text}");
        let (_, of_board) = bench.end();
        let log = Scratch::new("board-same-sim.log", "");
        let sim = ["sim", "--trajectory", file.path(), "--candump", log.path()];
        let output = motionctl(&sim).output().expect("motionctl runs");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        are_same(&of_board, &steps(log.path(), 2));
        let log = Scratch::new("board-same-run.log", "");
        let bench = BenchProcess::start_with("board-same-run", "1,2", &["--candump", log.path()]);
        bench.disable("1,2");
        let run = ["run", "--trajectory", file.path(), "--yes", "--json"];
        let output = bench.run(&run);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let summary = json(&String::from_utf8_lossy(&output.stdout));
        bench.stop();
        let of_run = steps(log.path(), 2);
        if summary["pace"]["merged"] == 0 && numbers(&summary["axes"], "merged") == [0, 0] {
            return are_same(&of_board, &of_run);
        }
        // A PC that misses a cycle sends its step with those behind it: elsewhere the positions are the same, and so is the end.
        for (board, run) in of_board.iter().zip(&of_run) {
            let (board, run) = (sums(moving(board)), sums(moving(run)));
            let same = run.iter().filter(|at| board.contains(at)).count();
            assert!(
                5 * same > 3 * run.len(),
                "{same} of {}: {summary}",
                run.len()
            );
            assert_eq!(board.last(), run.last());
        }
    });
}

fn sums(steps: &[i64]) -> Vec<i64> {
    let mut position = 0;
    let after = steps.iter().map(|step| {
        position += step;
        position
    });
    after.collect()
}

fn are_same(of_board: &[Vec<i64>], others: &[Vec<i64>]) {
    for (board, other) in of_board.iter().zip(others) {
        assert!(moving(board).len() > 200, "{}", moving(board).len());
        assert_eq!(moving(board), moving(other));
    }
}

#[test]
fn ctrl_c_stops_on_the_path_and_disables() {
    undisturbed(|| {
        let bench = BoardBench::start("board-interrupt", SETTINGS);
        let file = Scratch::new("board-interrupt.csv", LONG);
        let child = start_long(&bench, &file);
        interrupt(&child);
        let (status, summary, _) = end_of(child);
        assert_eq!(status, Some(130), "{summary}");
        assert_eq!(summary["outcome"], "stopped by the user");
        assert_eq!(summary["disabled"], true);
        let (report, steps) = bench.end();
        are_off(&report);
        let sums = numbers(&summary["axes"], "set_point_counts");
        assert_eq!(numbers(&report["drives"], "received_counts"), sums);
        // Both are equally far: on the path.
        assert!((sums[0] + sums[1]).abs() <= 1 && sums[0] > 0, "{sums:?}");
        steps.iter().for_each(|steps| is_ramp(steps));
    });
}

#[test]
fn a_host_that_is_killed_is_silent_and_the_board_stops_by_itself() {
    undisturbed(|| {
        let bench = BoardBench::start("board-killed", SETTINGS);
        let file = Scratch::new("board-killed.csv", LONG);
        let mut child = start_long(&bench, &file);
        child.kill().expect("it can be ended");
        child.wait().expect("it has ended");
        // Nobody else commands before the board has noticed it, and then somebody does.
        let short = Scratch::new("board-killed-short.csv", SHORT);
        let mut info = Value::Null;
        wait_until("the board stands", || {
            info = bench.info();
            info["stream"] != "moving"
        });
        assert_eq!(
            (&info["state"], &info["stream"]),
            (&"enabled".into(), &"stopped".into())
        );
        assert_eq!(info["silent_hosts"], 1, "{info}");
        let (status, text, errors) = bench.run(&["run", short.path(), "--yes", "--json"]);
        assert_eq!(status, Some(0), "{errors}{text}");
        let (report, steps) = bench.end();
        are_off(&report);
        for steps in &steps {
            let ends = [&[0], &steps[..], &[0]].concat();
            let worst = ends.windows(2).map(|pair| (pair[1] - pair[0]).abs()).max();
            assert!(worst <= Some(MOST_CHANGE), "{worst:?}");
        }
    });
}

#[test]
fn a_second_host_is_refused_and_the_first_goes_on() {
    undisturbed(|| {
        let bench = BoardBench::start("board-second", SETTINGS);
        let file = Scratch::new("board-second.csv", LONG);
        let child = start_long(&bench, &file);
        // The system gives a serial port to one program.
        let (status, _, errors) = bench.run(&["info"]);
        assert_eq!(status, Some(3), "{errors}");
        assert!(errors.contains("in use by another program"), "{errors}");
        interrupt(&child);
        let (status, summary, _) = end_of(child);
        assert_eq!(status, Some(130), "{summary}");
    });
}

#[test]
fn another_host_waits_until_the_board_has_noticed_that_the_first_is_gone() {
    undisturbed(|| {
        let bench = BoardBench::start("board-taken", SETTINGS);
        let long = Scratch::new("board-taken.csv", LONG);
        let mut child = start_long(&bench, &long);
        child.kill().expect("it can be ended");
        child.wait().expect("it has ended");
        // The first one still commands when this one comes.
        let short = Scratch::new("board-taken-short.csv", SHORT);
        let (status, text, errors) = bench.run(&["run", short.path(), "--yes", "--json"]);
        let summary = json(&text);
        // It may come while the axes still slow down: then the board refuses its begin, and nothing of it moves.
        assert!(matches!(status, Some(0 | 1)), "{errors}{summary}");
        if status == Some(1) {
            assert!(errors.contains("refusal"), "{errors}");
        }
        let (report, steps) = bench.end();
        assert_eq!(report["board"]["silent_hosts"], 1, "{report}");
        are_off(&report);
        for steps in &steps {
            let worst = steps.windows(2).map(|pair| (pair[1] - pair[0]).abs()).max();
            assert!(worst <= Some(MOST_CHANGE), "{worst:?}");
        }
    });
}

#[test]
fn a_line_that_damages_bytes_loses_no_set_point() {
    undisturbed(|| {
        let bench = BoardBench::start("board-damage", SETTINGS);
        let line = DamagedLine::start(&bench, 211);
        let points = (0..60).map(|place| {
            let at = f64::from(place) * 0.05;
            format!("{at:.2},{:.3},{:.3}\n", 90.0 * (1.0 - at.cos()), -20.0 * at)
        });
        let text: String = core::iter::once("time_s,a,b\n".to_owned())
            .chain(points)
            .collect();
        let file = Scratch::new("board-damage.csv", &text);
        let run = [
            "run",
            file.path(),
            "--yes",
            "--json",
            "--interpolation",
            "monotone",
        ];
        let (status, text, errors) = run_at(line.port(), &run);
        assert_eq!(status, Some(0), "{errors}{text}");
        let summary = json(&text);
        assert!(summary["lost_messages"].as_u64() > Some(0), "{summary}");
        assert!(line.end() > 20);
        let (report, steps) = bench.end();
        assert!(
            report["board"]["lost_messages"].as_u64() > Some(0),
            "{report}"
        );
        let sums = numbers(&summary["axes"], "target_counts");
        assert_eq!(numbers(&report["drives"], "received_counts"), sums);
        are_off(&report);
        steps.iter().for_each(|steps| is_ramp(steps));
    });
}

#[test]
fn an_enable_input_that_is_released_slows_down_and_switches_off() {
    undisturbed(|| {
        let mut bench = BoardBench::start("board-enable", SETTINGS);
        let file = Scratch::new("board-enable.csv", LONG);
        let child = start_long(&bench, &file);
        bench.tell("enable inactive");
        let (status, summary, errors) = end_of(child);
        assert_eq!(status, Some(1), "{summary}");
        assert!(errors.contains("enable input is not active"), "{errors}");
        let (status, text, errors) = bench.run(&["run", file.path(), "--max-turns", "30", "--yes"]);
        assert_eq!(status, Some(1), "{text}");
        assert!(errors.contains("refusal 26"), "{errors}");
        let (report, steps) = bench.end();
        are_off(&report);
        steps.iter().for_each(|steps| is_ramp(steps));
    });
}

#[test]
fn an_open_stop_circuit_ends_every_set_point_at_once() {
    undisturbed(|| {
        let mut bench = BoardBench::start("board-stop", SETTINGS);
        let file = Scratch::new("board-stop.csv", LONG);
        let child = start_long(&bench, &file);
        bench.tell("stop open");
        let (status, summary, errors) = end_of(child);
        assert_eq!(status, Some(1), "{summary}");
        assert!(errors.contains("stop circuit is open"), "{errors}");
        let (status, _, errors) = bench.run(&["run", file.path(), "--max-turns", "30", "--yes"]);
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("refusal 25"), "{errors}");
        // Closed again, nothing moves by itself.
        bench.tell("stop closed");
        std::thread::sleep(Duration::from_secs(1));
        assert_eq!(bench.info()["state"], "off");
        let (report, steps) = bench.end();
        are_off(&report);
        for steps in &steps {
            // In motion until the last one: no ramp, which the drive makes.
            let last = moving(steps).last().copied().unwrap_or_default();
            assert!(last.abs() > 20, "{last}");
        }
    });
}

#[test]
fn settings_are_refused_with_their_reason_and_stored_when_they_are_right() {
    undisturbed(|| {
        let bench = BoardBench::start("board-settings", "");
        assert_eq!(bench.info()["state"], "no settings");
        let file = Scratch::new("board-settings.csv", SHORT);
        let (status, _, errors) = bench.run(&["run", file.path(), "--yes"]);
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("has no settings"), "{errors}");
        let wrong = SETTINGS.replacen("gear_number = 4096", "gear_number = 4", 1);
        let wrong = Scratch::new("board-settings-wrong.toml", &wrong);
        let (status, _, errors) = bench.run(&["settings", "set", wrong.path(), "--yes"]);
        assert_eq!(status, Some(2), "{errors}");
        assert!(
            errors.contains("line 9, column") && errors.contains("refusal 1009"),
            "{errors}"
        );
        let right = Scratch::new("board-settings-right.toml", SETTINGS);
        let set = ["settings", "set", right.path(), "--yes", "--json"];
        let (status, text, errors) = bench.run(&set);
        assert_eq!(status, Some(0), "{errors}");
        let report = json(&text);
        assert_eq!(
            (&report["stored"], &report["restart_needed"]),
            (&true.into(), &true.into())
        );
        // They are in the flash, and count from the next start on.
        assert!(
            std::fs::read_to_string(bench.settings_path())
                .expect("it is there")
                .contains("speed_rpm = 600")
        );
        assert_eq!(bench.info()["state"], "no settings");
        bench.power_cycle();
        let (status, text, errors) = bench.run(&set);
        assert_eq!(
            (status, &json(&text)["stored"]),
            (Some(0), &false.into()),
            "{errors}"
        );
        let (status, text, errors) = bench.run(&["run", file.path(), "--yes", "--json"]);
        assert_eq!(status, Some(0), "{errors}{text}");
        let slower = SETTINGS.replace("speed_rpm = 600", "speed_rpm = 10");
        let slower = Scratch::new("board-settings-slower.toml", &slower);
        let (status, text, errors) = bench.run(&["settings", "set", slower.path(), "--yes"]);
        assert_eq!(status, Some(0), "{errors}{text}");
        assert!(errors.contains("drive 2: speed_rpm: 600 -> 10"), "{errors}");
        bench.power_cycle();
        // What the settings do not allow is refused before anything is enabled.
        let (status, _, errors) = bench.run(&["run", file.path(), "--yes"]);
        assert_eq!(status, Some(2), "{errors}");
        assert!(
            errors.contains("refusal 8") && errors.contains("Nothing has moved"),
            "{errors}"
        );
        assert_eq!(bench.info()["state"], "off");
    });
}

#[test]
fn settings_are_not_stored_while_a_drive_is_enabled() {
    undisturbed(|| {
        let bench = BoardBench::start("board-enabled", SETTINGS);
        let file = Scratch::new("board-enabled.csv", LONG);
        let mut child = start_long(&bench, &file);
        child.kill().expect("it can be ended");
        child.wait().expect("it has ended");
        let other = SETTINGS.replace("speed_rpm = 600", "speed_rpm = 700");
        let other = Scratch::new("board-enabled.toml", &other);
        let (status, _, errors) = bench.run(&["settings", "set", other.path(), "--yes"]);
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("refusal 34"), "{errors}");
        let text = std::fs::read_to_string(bench.settings_path()).expect("it is there");
        assert_eq!(text, SETTINGS);
    });
}

#[test]
fn a_board_that_is_reset_in_motion_is_told_and_nothing_moves_afterwards() {
    undisturbed(|| {
        let mut bench = BoardBench::start("board-reset", SETTINGS);
        let file = Scratch::new("board-reset.csv", LONG);
        let child = start_long(&bench, &file);
        bench.tell("reset");
        let (status, summary, errors) = end_of(child);
        assert_eq!(status, Some(3), "{summary}");
        assert!(errors.contains("the board was reset"), "{errors}");
        // The program has come back to it, and has switched the drives off.
        assert_eq!(summary["disabled"], true, "{summary}");
        let (report, _) = bench.end();
        assert_eq!(report["board"]["starts"], 2, "{report}");
        are_off(&report);
    });
}

/// The bytes of a frame, without a byte of our own encoder.
fn frame(version: u8, body: &[u8]) -> Vec<u8> {
    let content = [&[version], body].concat();
    let bytes = [&content[..], &checksum(&content).to_le_bytes()].concat();
    let mut stuffed = vec![0];
    for part in bytes.split(|byte| *byte == 0) {
        stuffed.push(part.len() as u8 + 1);
        stuffed.extend_from_slice(part);
    }
    stuffed.push(0);
    stuffed
}

#[test]
fn another_version_is_answered_with_a_number_on_both_sides() {
    let bench = BoardBench::start("board-version", SETTINGS);
    let mut port = File::options()
        .read(true)
        .write(true)
        .open(bench.port())
        .expect("its port");
    port.write_all(&frame(VERSION + 1, &[7, 0, 0]))
        .expect("room");
    let (mut decoder, mut refused) = (Decoder::new(), None);
    let mut byte = [0];
    while refused.is_none() {
        port.read_exact(&mut byte).expect("an answer");
        if let Some(Ok(content)) = decoder.push(byte[0])
            && let Some(ToHost::Reply { number, result }) = decode(content.body)
        {
            refused = Some((number, result.expect_err("it is refused")));
        }
    }
    let expected = Reason::Version.because(VERSION.into(), i64::from(VERSION) + 1);
    assert_eq!(refused, Some((0, expected)));
    drop(port);

    // The other way round: a board of tomorrow.
    let link = scratch("board-of-tomorrow");
    let mut terminal = Terminal::new(&link);
    let path = link.to_str().expect("plain text").to_owned();
    let child = motionctl(&["board", "info", "--port", &path])
        .spawn()
        .expect("it starts");
    let thread = std::thread::spawn(move || end_of_errors(child));
    while !thread.is_finished() {
        if !terminal.read().is_empty() {
            terminal.write(&mut frame(VERSION + 1, &[1, 2, 3]), None);
        }
    }
    let (status, errors) = thread.join().expect("it ends");
    assert_eq!(status, Some(1), "{errors}");
    assert!(
        errors.contains("another version of the protocol"),
        "{errors}"
    );
    let _ = std::fs::remove_file(&link);
}

fn end_of_errors(child: std::process::Child) -> (Option<i32>, String) {
    let output = child.wait_with_output().expect("its output");
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), errors)
}

#[test]
fn a_board_is_found_and_a_port_without_one_is_told() {
    let bench = BoardBench::start("board-find", SETTINGS);
    let (status, text, errors) = bench.run(&["find", "--json"]);
    assert_eq!(status, Some(0), "{errors}");
    let found = json(&text);
    assert_eq!(found["boards"][0]["port"], bench.port(), "{found}");
    assert_eq!(found["boards"][0]["axes"], 2, "{found}");
    let adapter = BenchProcess::start("board-find-other", "1");
    let (status, _, errors) = run_at(adapter.path(), &["find"]);
    assert_eq!(status, Some(1), "{errors}");
    let (status, _, errors) = run_at(adapter.path(), &["info"]);
    assert_eq!(status, Some(3), "{errors}");
    assert!(errors.contains("no motion board answers"), "{errors}");
    let report = adapter.stop();
    assert_eq!(report["frames_from_host"], 0, "{report}");
}
