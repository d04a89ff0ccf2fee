//! `motionctl limits` from outside. The targets themselves are reached with the full number of cycles; here fewer show that each
//! figure is measured.

use std::process::Command;

fn limits(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_motionctl"))
        .arg("limits")
        .args(arguments)
        .output()
        .expect("motionctl runs");
    let text = String::from_utf8(output.stdout).expect("plain text");
    (output.status.code(), text)
}

#[test]
fn every_target_is_met() {
    let (status, text) = limits(&["--cycles", "2000", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(status, Some(0), "{json:#}");
    assert_eq!(json["targets_met"], true);
    assert_eq!(json["set_points_only"]["axes"], 14);
    let axes: Vec<_> = json["polled"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|polled| polled["axes"].as_u64())
        .collect();
    assert_eq!(axes, [Some(12), Some(11), Some(10)]);
    assert!(json["jitter_bits"].as_u64() <= Some(25));
    assert!(json["skew_ratio"].as_f64() <= Some(1.15));
    assert!(json["wire_share"]["polled"].as_f64() >= Some(0.72));
    assert!(json["wire_share"]["set_points_only"].as_f64() >= Some(0.91));
    assert!(json["late_after_outage"].as_u64() <= Some(7));
    assert_eq!(json["own_collisions"], 0);
    assert_eq!(json["bound_violations"], 0);
    assert!(json["worst_poll_age_periods"].as_f64() <= Some(1.5));
}

#[test]
fn the_table_has_every_figure_with_its_target() {
    let (status, text) = limits(&["--cycles", "200"]);
    assert_eq!(status, Some(0), "{text}");
    for expected in [
        "axes, set-points only",
        "at least 14",
        "late frames after 10 ms of outage",
        "13 axes at 200 us",
    ] {
        assert!(text.contains(expected), "{expected} in {text}");
    }
}
