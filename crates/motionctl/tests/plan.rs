//! `motionctl plan` from outside.

use std::process::Command;

fn plan(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_motionctl"))
        .arg("plan")
        .args(arguments)
        .output()
        .expect("motionctl runs");
    let text = String::from_utf8(output.stdout).expect("plain text");
    (output.status.code(), text)
}

fn json(arguments: &[&str]) -> (Option<i32>, serde_json::Value) {
    let (status, text) = plan(&[arguments, &["--json"]].concat());
    (status, serde_json::from_str(&text).expect("JSON"))
}

#[test]
fn every_frame_of_a_bus_that_fits_is_listed_in_time() {
    let (status, json) = json(&["--axes", "14", "--status-hz", "0", "--position-hz", "0"]);
    assert_eq!(status, Some(0), "{json:#}");
    assert_eq!(json["schedulable"], true);
    let frames = json["frames"].as_array().expect("a list");
    assert_eq!(frames.len(), 14);
    let last = &frames[13];
    assert_eq!(
        (&last["frame"], &last["response_us"], &last["deadline_us"]),
        (&"set-point of drive 14".into(), &981.into(), &1_000.into())
    );
    assert_eq!(
        (&json["load_bits"], &json["most_axes"]),
        (&981.into(), &14.into())
    );
}

#[test]
fn polls_have_requests_and_replies_and_a_place() {
    let (_, json) = json(&["--axes", "8"]);
    let frames = json["frames"].as_array().expect("a list");
    let names: Vec<_> = frames[8..]
        .iter()
        .map(|frame| frame["frame"].as_str())
        .collect();
    assert_eq!(
        names,
        [
            Some("status requests"),
            Some("status replies"),
            Some("position requests"),
            Some("position replies")
        ]
    );
    assert_eq!(json["requests_behind"], 3);
    assert_eq!(json["most_axes"], 11);
}

#[test]
fn a_bus_that_is_too_full_is_refused_with_the_frame_and_advice() {
    let (status, text) = plan(&["--axes", "13"]);
    assert_eq!(status, Some(1));
    let expected = "REFUSED: set-point of drive 13 does not fit: with it a cycle carries 1061 bit times, but lasts 1000; \
                    it would fit with no polls, or cycle_us = 1250, or the first 11 axes";
    assert!(text.contains(expected), "{text}");
}

#[test]
fn drive_63_and_stretched_polls_are_noted() {
    let (status, text) = plan(&["--drives", "53-63", "--response-us", "150-250"]);
    assert_eq!(status, Some(0), "{text}");
    assert!(
        text.contains("identifiers of drive 63 from 0x7F0 on"),
        "{text}"
    );
    assert!(text.contains("their periods grow to 110.0 %"), "{text}");
}

#[test]
fn the_picture_shows_each_frame_in_its_place() {
    let (_, text) = plan(&["--axes", "8"]);
    let row = |label: &str| {
        text.lines()
            .find(|line| line.starts_with(label))
            .expect(label)
    };
    assert_eq!(
        row("set-points "),
        "set-points  [1=====[2=====[3=====      [4=====[5=====[6=====[7=====[8====="
    );
    assert_eq!(
        row("requests "),
        format!("requests    {}[poll=", " ".repeat(21))
    );
    assert!(text.contains("meet no set-point"));

    let file = std::env::temp_dir().join(format!("motionctl-plan-{}.svg", std::process::id()));
    let (status, _) = plan(&["--axes", "8", "--svg", file.to_str().expect("a name")]);
    let svg = std::fs::read_to_string(&file).expect("the picture");
    std::fs::remove_file(&file).expect("the picture");
    assert_eq!(status, Some(0));
    // Background, and fill and edge of 8 set-points, a request and the replies, of which three go on in the next row.
    assert_eq!(svg.matches("<rect").count(), 1 + 2 * (10 + 3));
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
}

#[test]
fn slow_buses_have_long_cycles() {
    for (bit_rate, cycle_us) in [("10", "250000"), ("125", "20000"), ("500", "4000")] {
        let (status, json) = json(&[
            "--axes",
            "4",
            "--bit-rate",
            bit_rate,
            "--cycle-us",
            cycle_us,
            "--status-hz",
            "1",
            "--position-hz",
            "0",
        ]);
        let timeout_matters = bit_rate == "10";
        assert_eq!(status, Some(i32::from(timeout_matters)), "{json:#}");
    }
}
