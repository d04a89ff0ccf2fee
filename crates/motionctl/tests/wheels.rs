//! `motionctl sim --drives zlac` as a user runs it: numbers, exit status, messages.

use std::path::PathBuf;
use std::process::{Command, Output};
use std::sync::atomic::{AtomicU32, Ordering};

/// A file of its own for each test, removed afterwards.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str, text: &str) -> Self {
        // Tests run beside each other, and two may call their files the same.
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let place = COUNT.fetch_add(1, Ordering::Relaxed);
        let file = format!("wheels-{}-{place}-{name}", std::process::id());
        let path = std::env::temp_dir().join(file);
        std::fs::write(&path, text).expect("a temporary file");
        Self(path)
    }

    fn as_str(&self) -> &str {
        self.0.to_str().expect("a path of plain text")
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // Nothing depends on it: the folder is temporary.
        let _ = std::fs::remove_file(&self.0);
    }
}

fn sim(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_motionctl"));
    command
        .args(["sim", "--drives"])
        .args(arguments)
        .output()
        .expect("motionctl runs")
}

fn refusal(arguments: &[&str]) -> String {
    let output = sim(arguments);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(output.stdout.is_empty(), "nothing may run: {output:?}");
    String::from_utf8(output.stderr).expect("plain text")
}

#[test]
fn the_built_in_differential_drive_keeps_every_promise() {
    let output = sim(&["zlac", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(json["promises_kept"], true);
    assert_eq!(
        (&json["cycle_us"], &json["bit_rate_kbit"]),
        (&10_000.into(), &500.into())
    );
    assert_eq!(
        (&json["late_cycles"], &json["faults"]),
        (&0.into(), &0.into())
    );
    // The areas below the lines of the file, by hand: 367.5 and 592.5 r/min times seconds.
    for (wheel, (node, turns)) in [(4, 367.5 / 60.0), (5, 592.5 / 60.0)]
        .into_iter()
        .enumerate()
    {
        let wheel = &json["wheels"][wheel];
        assert_eq!(wheel["node"], node);
        assert_eq!(wheel["set_points"], wheel["received"]);
        assert_eq!(wheel["eeprom_writes"], 0);
        let travelled = wheel["travelled_turns"].as_f64().expect("a number");
        assert!((travelled - turns).abs() < 0.01, "{travelled} {turns}");
    }
}

#[test]
fn the_traffic_is_canopen() {
    let log = Scratch::new("run.log", "");
    let output = sim(&["zlac:7,9", "--candump", log.as_str()]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = std::fs::read_to_string(log.as_str()).expect("a log");
    for frame in [
        " 707#00",
        " 000#0109",
        " 607#4000100000000000",
        " 080#",
        " 309#0F00",
    ] {
        assert!(text.contains(frame), "{frame}");
    }
}

#[test]
fn what_wheels_cannot_follow_is_refused() {
    let fast = Scratch::new("fast.csv", "t,l,r\n0,0,0\n1,101,0\n2,0,0\n");
    let message = refusal(&["zlac", "--trajectory", fast.as_str()]);
    assert!(
        message.contains("at most 100 r/min, the file has 101"),
        "{message}"
    );
    let output = sim(&[
        "zlac",
        "--speed-resolution",
        "5",
        "--trajectory",
        fast.as_str(),
    ]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let rolling = Scratch::new("rolling.csv", "t,l,r\n0,0,10\n1,0,0\n");
    let message = refusal(&["zlac", "--trajectory", rolling.as_str()]);
    assert!(
        message.contains("line 2") && message.contains("10 r/min"),
        "{message}"
    );
    let message = refusal(&["zlac:4,5,6"]);
    assert!(message.contains("2 columns"), "{message}");
}

#[test]
fn a_bus_that_is_too_slow_is_refused() {
    let message = refusal(&["zlac", "--cycle-us", "1000"]);
    assert!(
        message.contains("the bus carries more than it can") && message.contains("longer cycle"),
        "{message}"
    );
}

#[test]
fn the_traffic_decodes_into_objects() {
    let log = Scratch::new("decode.log", "");
    let output = sim(&["zlac", "--candump", log.as_str()]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let output = Command::new(env!("CARGO_BIN_EXE_motionctl"))
        .args(["decode", "--protocol", "canopen", log.as_str()])
        .output()
        .expect("motionctl runs");
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let text = String::from_utf8(output.stdout).expect("plain text");
    // PDOs are read by the mapping in the log, and every frame has a meaning.
    for words in [
        "node 4   RPDO 1: control word 000Fh, target speed = 600 x 1/n r/min",
        "node 5   SDO request: write 1601h:02",
        " 0 did not decode, 2 look like trouble",
    ] {
        assert!(text.contains(words), "{words}");
    }
    let statistics = text
        .lines()
        .find(|line| line.contains("│ 584 "))
        .expect("a row");
    assert!(statistics.contains("│ 584   4 "), "{statistics}");
}

#[test]
fn a_scan_for_nodes_asks_before_it_sends_what_could_move_servo_drives() {
    let scan = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_motionctl"))
            .args(["scan", "--protocol", "canopen"])
            .args(arguments)
            .stdin(std::process::Stdio::null())
            .output()
            .expect("motionctl runs");
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        String::from_utf8(output.stderr).expect("plain text")
    };
    // Neither port exists, and neither is opened.
    let message = scan(&["--slcan", "/dev/no-such-port"]);
    assert!(message.contains("confirmation"), "{message}");
    let message = scan(&["--serial", "/dev/no-such-port"]);
    assert!(
        message.contains("--protocol canopen is for CAN"),
        "{message}"
    );
}

/// The summary of a run, whatever its exit status.
fn summary(arguments: &[&str]) -> (Option<i32>, serde_json::Value) {
    let output = sim(&[arguments, &["--json"]].concat());
    let json = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{output:?}"));
    (output.status.code(), json)
}

#[test]
fn faults_of_a_script_break_promises_and_are_said() {
    for (script, words) in [
        (
            "[[trip]]\nat_s = 1\nnode = 5\nfault = \"over-current\"\n",
            "emergency 1000h",
        ),
        (
            "[[emergency_input]]\nat_s = 1\nnode = 5\n",
            "emergency stop input",
        ),
        (
            "[[power_cycle]]\nat_s = 1\nnode = 5\noff_s = 0.1\n",
            // Its feedback is missed before it starts again.
            "does not answer",
        ),
        ("[[unplug]]\nat_s = 1\nnode = 5\n", "does not answer"),
    ] {
        let file = Scratch::new("faults.toml", script);
        let (status, summary) = summary(&["zlac", "--faults", file.as_str()]);
        assert_eq!(
            (status, &summary["promises_kept"]),
            (Some(1), &false.into())
        );
        let fault = summary["wheels"][1]["fault"].as_str().expect("a fault");
        assert!(fault.contains(words), "{script}: {fault}");
        // The group stops together.
        assert!(summary["wheels"][0]["fault"].is_string(), "{summary}");
    }
    // What CAN repairs by itself breaks nothing.
    let file = Scratch::new("corrupt.toml", "[[corrupt]]\nat_s = 1\nframes = 3\n");
    let (status, kept) = summary(&["zlac", "--faults", file.as_str()]);
    assert_eq!((status, &kept["promises_kept"]), (Some(0), &true.into()));
    let file = Scratch::new("other.toml", "[[silence]]\nat_s = 1\nnode = 9\n");
    let message = refusal(&["zlac", "--faults", file.as_str()]);
    assert!(
        message.contains("line 1: node 9 takes no part"),
        "{message}"
    );
}

#[test]
fn a_table_has_one_row_a_cycle() {
    let file = Scratch::new("table.csv", "");
    let (status, _) = summary(&["zlac:7,9", "--csv", file.as_str()]);
    assert_eq!(status, Some(0));
    let text = std::fs::read_to_string(file.as_str()).expect("a table");
    let mut lines = text.lines();
    let names = lines.next().expect("names");
    assert!(
        names.starts_with("time_s,bus_load,late,node7_target_rpm,node7_sent_rpm,"),
        "{names}"
    );
    assert_eq!(names.split(',').count(), 3 + 2 * 9);
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert!(rows.len() > 400, "{}", rows.len());
    // 60 r/min in the file, by the target, the wheel and its own report.
    assert!(
        rows.iter()
            .any(|row| row[3] == "60" && row[5] == "60" && row[6] == "60")
    );
    assert!(rows.iter().all(|row| row[2] == "0"));
}
