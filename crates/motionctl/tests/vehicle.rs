//! A vehicle on two hub motors: `motionctl sim --drives zlac --twist`.

mod tool;

use serde_json::Value;
use tool::{Scratch, motionctl, text};

/// The example, from this package.
const SQUARE: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/../../examples/square-twist.csv"
);
const MEASURES: [&str; 4] = ["--track", "0.4", "--wheel-radius", "0.085"];

fn drive(file: &str, options: &[&str]) -> (Option<i32>, Value) {
    let words = ["sim", "--drives", "zlac", "--json", "--twist", file];
    let output = motionctl(&[&words[..], &MEASURES, options].concat());
    let summary = serde_json::from_slice(&output.stdout)
        .unwrap_or_else(|_| panic!("{}", text(&output.stderr)));
    (output.status.code(), summary)
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

/// Closes within 5 mm, a whole turn, and agrees with the wheels within 2 counts.
fn assert_is_closed_square(summary: &Value) {
    let odometry = &summary["odometry"];
    assert!(number(&odometry["from_start_m"]) < 0.005, "{summary}");
    let turn = number(&odometry["heading_rad"]) - std::f64::consts::TAU;
    assert!(turn.abs() < 0.01, "{summary}");
    for side in ["left_counts", "right_counts"] {
        let difference = number(&odometry[side]) - number(&summary["wheels_pose"][side]);
        assert!(difference.abs() <= 2.0, "{summary}");
    }
    // 4 m straight on, and 2 pi on a track of 0.4 m: in counts of 2 pi 0.085 m / 4096.
    let m_per_count = std::f64::consts::TAU * 0.085 / 4_096.0;
    let turning = std::f64::consts::TAU * 0.2 / m_per_count;
    let straight = 4.0 / m_per_count;
    let (left, right) = (&odometry["left_counts"], &odometry["right_counts"]);
    assert!(
        (number(left) - (straight - turning)).abs() < 30.0,
        "{summary}"
    );
    assert!(
        (number(right) - (straight + turning)).abs() < 30.0,
        "{summary}"
    );
}

#[test]
fn a_square_closes_with_ramps_and_delays() {
    for ramp_ms in ["0", "500", "5000"] {
        for (response_us, seed) in [("200", "1"), ("3000", "2")] {
            let (status, summary) = drive(
                SQUARE,
                &[
                    "--ramp-ms",
                    ramp_ms,
                    "--response-us",
                    response_us,
                    "--response-spread",
                    "100",
                    "--seed",
                    seed,
                ],
            );
            assert_eq!(status, Some(0), "{ramp_ms} ms: {summary}");
            assert_is_closed_square(&summary);
            assert_eq!(summary["dead_man_cycles"], 0);
        }
    }
}

#[test]
fn a_wheel_that_counts_down_forwards_closes_the_same_square() {
    let (status, summary) = drive(SQUARE, &["--reversed", "right"]);
    assert_eq!(status, Some(0), "{summary}");
    assert_is_closed_square(&summary);
    let wheels = &summary["run"]["wheels"];
    assert!(number(&wheels[0]["travelled_turns"]) > 0.0);
    assert!(number(&wheels[1]["travelled_turns"]) < 0.0);
}

#[test]
fn a_stream_that_falls_silent_stops_the_vehicle_and_says_so() {
    let gap = Scratch::new("gap.csv", "0,0.2,0\n3,0.2,0\n3.2,0,0\n");
    let (status, summary) = drive(gap.as_str(), &["--dead-man-ms", "500"]);
    assert_eq!(status, Some(0), "{summary}");
    // From 0.5 s to 3 s nothing is in force.
    let cycles = number(&summary["dead_man_cycles"]);
    assert!((245.0..=255.0).contains(&cycles), "{summary}");
    // Some 0.5 s and 0.2 s at 0.2 m/s, not 3.2 s.
    let x_m = number(&summary["odometry"]["x_m"]);
    assert!((0.1..0.2).contains(&x_m), "{summary}");
}

#[test]
fn a_twist_that_is_too_fast_is_driven_slower_on_its_curve() {
    let curve = Scratch::new(
        "curve.csv",
        "0,1.5,1.5\n0.4,1.5,1.5\n0.8,1.5,1.5\n1.2,0,0\n",
    );
    let (status, summary) = drive(curve.as_str(), &["--max-rpm", "60"]);
    assert_eq!(status, Some(0), "{summary}");
    assert!(number(&summary["limited_cycles"]) > 100.0, "{summary}");
    // Radius 1 m: x = sin, y = 1 - cos of the heading.
    let pose = &summary["odometry"];
    let heading = number(&pose["heading_rad"]);
    assert!(
        (number(&pose["x_m"]) - heading.sin()).abs() < 0.01,
        "{summary}"
    );
    assert!(
        (number(&pose["y_m"]) - (1.0 - heading.cos())).abs() < 0.01,
        "{summary}"
    );
}

#[test]
fn what_is_no_twist_or_no_vehicle_is_refused() {
    let wrong = Scratch::new("wrong.csv", "time,v,omega\n0,0.1,0\n1,0.1\n");
    let refused = |words: &[&str]| {
        let output = motionctl(&[&["sim"], words].concat());
        assert_eq!(output.status.code(), Some(2), "{words:?}");
        assert!(output.stdout.is_empty(), "{words:?}");
        text(&output.stderr).to_owned()
    };
    let zlac = ["--drives", "zlac", "--twist"];
    let with =
        |file: &str, options: &[&str]| refused(&[&zlac[..], &[file], &MEASURES, options].concat());
    let message = with(wrong.as_str(), &[]);
    assert!(
        message.contains("line 3: expected the 3 columns time,v,omega, got 2"),
        "{message}"
    );
    let message = with("/no/such/file", &[]);
    assert!(
        message.contains("/no/such/file: cannot read it"),
        "{message}"
    );
    let message = with(SQUARE, &["--max-rpm", "120"]);
    assert!(message.contains("at most 99 r/min"), "{message}");
    let message = with(SQUARE, &["--max-rpm", "nan"]);
    assert!(
        message.contains("largest speed in r/min must be"),
        "{message}"
    );
    let message = refused(&[&zlac[..], &[SQUARE, "--track", "0.4"]].concat());
    assert!(message.contains("--wheel-radius"), "{message}");
    let words = [SQUARE, "--track=-1", "--wheel-radius=0.1"];
    let message = refused(&[&zlac[..], &words].concat());
    assert!(
        message.contains("track in m must be 0.01..=10, got -1"),
        "{message}"
    );
    let message = refused(&[&["--twist", SQUARE][..], &MEASURES].concat());
    assert!(message.contains("--drives zlac"), "{message}");
    let message = refused(
        &[
            &["--drives", "zlac:4,5,6", "--twist", SQUARE][..],
            &MEASURES,
        ]
        .concat(),
    );
    assert!(message.contains("2 columns"), "{message}");
}
