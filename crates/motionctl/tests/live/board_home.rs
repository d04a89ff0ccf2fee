//! `motionctl board home` on a simulated board, against simulated stops and switches.

use crate::bench::{Scratch, interrupt, motionctl};
use crate::board_line::{BoardBench, SETTINGS};
use serde_json::Value;

/// Two drives of which the first stands at its reference.
pub(crate) const HERE: &str = "\
format = 1

[bus]
bit_rate_kbit_per_s = 1000

[[axis]]
drive = 1
gear_number = 4096
speed_rpm = 600
acceleration_rpm_per_s = 10000
travel_min_millidegrees = -9000000
travel_max_millidegrees = 9000000
homing = \"here\"

[[axis]]
drive = 2
gear_number = 4096
speed_rpm = 600
acceleration_rpm_per_s = 10000
travel_min_millidegrees = -9000000
travel_max_millidegrees = 9000000
";

/// To a low stop, so that the axis rests at 0 of it, and to a switch; a turn and a half from there.
const STOP_AND_SWITCH: &str = "\
format = 1

[bus]
bit_rate_kbit_per_s = 1000

[[axis]]
drive = 1
gear_number = 4096
speed_rpm = 600
acceleration_rpm_per_s = 10000
travel_min_millidegrees = -540000
travel_max_millidegrees = 540000
torque_poll_us = 20000
homing = \"stop\"
homing_direction = \"negative\"
homing_way_millidegrees = 360000
homing_speed_rpm = 30
homing_reference_millidegrees = -18000

[[axis]]
drive = 2
gear_number = 4096
speed_rpm = 600
acceleration_rpm_per_s = 10000
travel_min_millidegrees = -540000
travel_max_millidegrees = 540000
homing = \"switch\"
homing_direction = \"positive\"
homing_way_millidegrees = 360000
homing_speed_rpm = 30
homing_switch_pin = 3
homing_switch_active = \"high\"
homing_reference_millidegrees = 18000
";

/// Half a turn and back, where the axis stands at 0.
const MOTION: &str = "time,axis1,axis2\n0,0,0\n2,180,-180\n4,0,0\n";
/// Beyond a turn and a half from the origin, and not from where the drives count 0.
const BEYOND: &str = "time,axis1,axis2\n0,0,0\n4,541,0\n8,0,0\n";
/// Elsewhere.
const ELSEWHERE: &str = "time,axis1,axis2\n0,90,0\n4,100,0\n8,90,0\n";

fn board(words: &[&str], bench: &BoardBench) -> (Option<i32>, String, String) {
    let port = ["--port", bench.port()];
    let all = [&["board"], words, &port].concat();
    let output = motionctl(&all).output().expect("it runs");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("a text");
    (
        output.status.code(),
        text(output.stdout),
        text(output.stderr),
    )
}

fn homed(bench: &BoardBench) -> Value {
    let (code, out, err) = board(&["home", "--yes", "--json"], bench);
    assert_eq!(code, Some(0), "{out} {err}");
    serde_json::from_str(&out).expect("JSON")
}

#[test]
fn axes_are_homed_and_motions_count_from_there_until_the_drives_are_disabled() {
    let stops = ["--stops", "-0.2:6", "--switch-at", "0.2"];
    let bench = BoardBench::start_with("home", STOP_AND_SWITCH, &stops);
    let run = |text: &str, more: &[&str]| {
        let file = Scratch::new("home.csv", text);
        board(&[&["run", file.path(), "--yes"], more].concat(), &bench)
    };
    let (code, _, err) = run(MOTION, &[]);
    assert_eq!(code, Some(1), "{err}");
    assert!(
        err.contains("the axis of drive 1 is to be homed, and is not"),
        "{err}"
    );
    let report = homed(&bench);
    let origin = |axis: usize| report["axes"][axis]["origin_counts"].as_i64().unwrap();
    // A fifth of a turn, and the reference that is a twentieth of one from the zero.
    assert!((origin(0) - (-3_277 + 819)).abs() <= 2, "{report}");
    assert!((origin(1) - (3_277 - 819)).abs() <= 20, "{report}");
    assert_eq!(
        (&report["homed"], &report["enabled"]),
        (&true.into(), &true.into())
    );
    let (code, _, err) = run(BEYOND, &[]);
    assert_eq!(code, Some(2), "{err}");
    assert!(err.contains("beyond the travel of the axis"), "{err}");
    let (code, _, err) = run(ELSEWHERE, &[]);
    assert_eq!(code, Some(2), "{err}");
    assert!(
        err.contains("drive 1 begins at 0.2500 turns of its motor, and its homed axis stands at"),
        "{err}"
    );
    // Left enabled, it is homed for the next one, which disables.
    for more in [&["--stay-enabled"][..], &[]] {
        let (code, out, err) = run(MOTION, more);
        assert_eq!(code, Some(0), "{out} {err}");
    }
    let (code, _, err) = run(MOTION, &[]);
    assert_eq!(code, Some(1), "{err}");
    assert!(err.contains("is to be homed"), "{err}");
    bench.end();
}

#[test]
fn what_is_not_found_and_what_is_interrupted_leaves_the_drives_off_as_they_were() {
    // No stop within its way.
    let bench = BoardBench::start_with("home-free", STOP_AND_SWITCH, &["--switch-at", "0.2"]);
    let (code, out, err) = board(&["home", "--yes", "--json"], &bench);
    assert_eq!(code, Some(1), "{out} {err}");
    let report: Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!(report["refusal"], 44, "{report}");
    assert_eq!(report["enabled"], false, "{report}");
    assert_eq!(report["axes"][0]["homed"], false, "{report}");
    // On its way to nowhere.
    let port = ["--port", bench.port()];
    let words = [&["board", "home", "--yes", "--json"], &port[..]].concat();
    let child = motionctl(&words)
        .stdout(std::process::Stdio::piped())
        .spawn()
        .expect("it starts");
    std::thread::sleep(std::time::Duration::from_millis(1_500));
    interrupt(&child);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(130));
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(report["refusal"], 43, "{report}");
    assert_eq!(report["enabled"], false, "{report}");
    bench.end();
}

#[test]
fn a_board_whose_settings_ask_for_none_is_told_before_anything_is_asked() {
    let bench = BoardBench::start("home-none", SETTINGS);
    let (code, _, err) = board(&["home"], &bench);
    assert_eq!(code, Some(2), "{err}");
    assert!(err.contains("ask for no homing"), "{err}");
    bench.end();
}

/// Drives that were enabled before are left as they are, which is not as they were.
#[test]
fn drives_that_a_stop_circuit_has_switched_off_are_not_said_to_be_enabled() {
    let stops = ["--stops", "-0.2:6", "--switch-at", "0.2"];
    let mut bench = BoardBench::start_with("home-open", STOP_AND_SWITCH, &stops);
    // It leaves them enabled.
    homed(&bench);
    let port = ["--port", bench.port()];
    let words = [&["board", "home", "--yes", "--json"], &port[..]].concat();
    let child = motionctl(&words)
        .stdout(std::process::Stdio::piped())
        .spawn()
        .expect("it starts");
    std::thread::sleep(std::time::Duration::from_millis(1_000));
    bench.tell("stop open");
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(1));
    let report: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(report["refusal"], 25, "{report}");
    assert_eq!(report["enabled"], false, "{report}");
    bench.end();
}
