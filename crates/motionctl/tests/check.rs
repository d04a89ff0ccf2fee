//! What `motionctl check` says of a file is what `run` does with it.

mod tool;

use serde_json::Value;
use tool::{Scratch, motionctl, text};

const SLOW: &str = "time_s,a_deg,b_turns\n0,0,0\n1,90,0.5\n2,180,0\n";

#[test]
fn a_motion_within_its_limits_is_described() {
    let file = Scratch::new("check-slow.csv", SLOW);
    let picture = std::env::temp_dir().join(format!("check-{}.svg", std::process::id()));
    let svg = picture.to_str().expect("a path");
    let output = motionctl(&[
        "check",
        file.as_str(),
        "--json",
        "--drives",
        "3,1",
        "--svg",
        svg,
    ]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let value: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(
        (&value["would_run"], &value["duration_s"]),
        (&true.into(), &2.0.into())
    );
    assert_eq!(value["axes"][0]["drive"], 3);
    let need = |axis: usize, need: usize| value["axes"][axis]["needs"][need]["needed"].as_f64();
    // The farthest ways: half a turn of each motor.
    assert_eq!((need(0, 2), need(1, 2)), (Some(0.5), Some(0.5)));
    assert_eq!(value["bus"]["is_in_time"], true);
    let picture = std::fs::read_to_string(&picture).expect("it was written");
    assert!(picture.contains("drive 3: turns of the motor") && picture.contains("polyline"));
    let _ = std::fs::remove_file(svg);
    let words = motionctl(&["check", file.as_str()]);
    assert!(
        text(&words.stdout).contains("`motionctl run` would take it."),
        "{words:?}"
    );
}

#[test]
fn every_limit_that_is_exceeded_is_named_with_its_option() {
    let file = Scratch::new("check-fast.csv", "time_s,a_turns\n0,0\n1,20\n2,0\n");
    let output = motionctl(&["check", file.as_str()]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    for option in [
        "--max-rpm 1",
        "--max-acceleration",
        "--max-turns 20",
        "would refuse it",
    ] {
        assert!(
            text(&output.stdout).contains(option),
            "{option}: {output:?}"
        );
    }
    let enough = [
        "--max-rpm",
        "4000",
        "--max-acceleration",
        "40000",
        "--max-turns",
        "20",
    ];
    let output = motionctl(&[&["check", file.as_str()], &enough[..]].concat());
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    // Ten axes in half a millisecond are too much for a bus.
    let names: Vec<String> = (0..10).map(|axis| format!("q{axis}")).collect();
    let zeros = ["0"; 10].join(",");
    let file = Scratch::new(
        "check-wide.csv",
        format!("t,{}\n0,{zeros}\n1,{zeros}\n", names.join(",")),
    );
    let output = motionctl(&["check", file.as_str(), "--cycle-us", "500"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(
        text(&output.stdout).contains("REFUSED: the bus: "),
        "{output:?}"
    );
}

#[test]
fn a_file_that_is_none_is_refused() {
    let file = Scratch::new("check-broken.csv", "time_s,a\n0,0\n1,x\n");
    let output = motionctl(&["check", file.as_str()]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(
        text(&output.stderr).contains("line 3, column 2 (a)"),
        "{output:?}"
    );
    assert_eq!(
        motionctl(&["check", "/no/such/file"]).status.code(),
        Some(2)
    );
}
