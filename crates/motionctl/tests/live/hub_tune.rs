//! `motionctl tune --drives zlac` against a bench whose wheels know their gains, and the waves that DYN drives make by themselves.

use std::time::Duration;

use serde_json::{Value, json};

use crate::bench::{
    BenchProcess, interrupt, motionctl, scratch, start_and_wait_for, status_and_errors,
};
use crate::settings::{json_of, on};
use crate::undisturbed::undisturbed;

fn number(set: &Value, figure: &str) -> f64 {
    set["figures"][figure]
        .as_f64()
        .unwrap_or_else(|| panic!("{figure}: {set}"))
}

/// Gains in the RAM of the drive, and nothing in its EEPROM.
fn gains(bench: &BenchProcess) -> Vec<i64> {
    let read = [
        "read", "--drives", "zlac", "201Dh", "201Eh", "201Fh", "2020h", "2021h", "--json",
    ];
    let values = json_of(on(bench, &read));
    let values = values.as_array().expect("a list").iter();
    values.filter_map(|value| value["value"].as_i64()).collect()
}

const FACTORY: [i64; 5] = [500, 100, 1_000, 50, 200];

#[test]
fn three_sets_of_gains_of_a_wheel_are_compared_and_the_old_ones_come_back() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("hub-tune", "zlac", &["--with-gains"]);
        let picture = scratch("hub-tune.svg");
        let _ = std::fs::remove_file(&picture);
        let svg = picture.to_str().expect("plain text");
        let outcome = json_of(on(
            &bench,
            &[
                "tune",
                "--drives",
                "zlac",
                "--yes",
                "--json",
                "--svg",
                svg,
                "--gains",
                "500,100,1000",
                "--gains",
                "500,2000,1000",
                "--gains",
                "1500,100,1000",
            ],
        ));
        let sets = outcome["sets"].as_array().expect("a list");
        assert_eq!((sets.len(), &outcome["of"]), (3, &"speed".into()));
        assert_eq!(
            sets[1]["gains"],
            json!({"kp": 500, "ki": 2_000, "kf": 1_000})
        );
        // More of the integral overshoots more; a stiffer loop is faster.
        let overshoot = |set: &Value| number(set, "overshoot_percent");
        assert!(
            overshoot(&sets[1]) > overshoot(&sets[0]) + 15.0,
            "{outcome}"
        );
        assert!(
            number(&sets[2], "rise_ms") < number(&sets[0], "rise_ms"),
            "{outcome}"
        );
        let peak = number(&sets[0], "speed_error_peak_rpm");
        assert!((20.0..=31.0).contains(&peak), "{outcome}");
        assert_eq!(
            (&outcome["restored"], &outcome["eeprom_writes"]),
            (&true.into(), &0.into())
        );
        assert_eq!(gains(&bench), FACTORY);
        let text = std::fs::read_to_string(&picture).expect("the picture");
        assert!(
            text.starts_with("<svg") && text.contains("speed Kp 1500"),
            "{text}"
        );
        let _ = std::fs::remove_file(&picture);
        let report = bench.stop();
        let drive = &report["drives"][0];
        assert_eq!(
            (&drive["enabled"], &drive["eeprom_writes"]),
            (&false.into(), &0.into())
        );
    });
}

#[test]
fn the_position_of_a_wheel_is_stepped_by_its_own_profile() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("hub-tune-position", "zlac", &["--with-gains"]);
        let outcome = json_of(on(
            &bench,
            &[
                "tune", "--drives", "zlac", "--yes", "--json", "--of", "position", "--gains",
                "50,200", "--gains", "150,200",
            ],
        ));
        let sets = outcome["sets"].as_array().expect("a list");
        let peak = number(&sets[0], "following_error_peak_counts");
        assert!((380.0..=410.0).contains(&peak), "{outcome}");
        // Speed and ramps are those of the profile: what a stiffer loop changes is how it gets to rest, and the place at each moment is
        // read only every 10 ms or so.
        for figure in ["overshoot_percent", "settling_ms"] {
            let of = |set: &Value| number(set, figure);
            assert!(of(&sets[1]) < 0.95 * of(&sets[0]), "{figure}: {outcome}");
        }
        assert_eq!(gains(&bench), FACTORY);
        let report = bench.stop();
        assert_eq!(report["drives"][0]["travel_counts"], 0);
    });
}

#[test]
fn ctrl_c_brings_the_gains_of_a_wheel_back() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("hub-tune-ctrl-c", "zlac", &["--with-gains"]);
        let command = [
            "tune",
            "--slcan",
            bench.path(),
            "--drives",
            "zlac",
            "--yes",
            "--gains",
            "700,100,1000",
            "--periods",
            "50",
        ];
        let child = start_and_wait_for(motionctl(&command), "the wheel moves");
        std::thread::sleep(Duration::from_secs(3));
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(130), "{errors}");
        assert_eq!(gains(&bench), FACTORY);
        assert_eq!(bench.stop()["drives"][0]["enabled"], false);
    });
}

#[test]
fn what_a_wheel_cannot_be_tuned_with_is_refused() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("hub-tune-refused", "zlac", &["--alarm", "zlac:4"]);
        for (status, options, expected) in [
            (
                2,
                ["--wave", "drive-square"],
                "hub motors have no wave of their own",
            ),
            (
                2,
                ["--gains", "50,200"],
                "expected Kp,Ki,Kf of the speed loop",
            ),
            (2, ["--gains", "30001,1,1"], "must be 0..=30000, got 30001"),
            (2, ["--rpm", "201"], "201 is not in 1..=200"),
            (1, ["--rpm", "20"], "node 4 has a fault"),
            (1, ["--drive", "9"], "node 9 does not answer"),
        ] {
            let words = [&["tune", "--drives", "zlac", "--yes"], &options[..]].concat();
            let (actual, _, errors) = on(&bench, &words);
            assert_eq!(actual, Some(status), "{options:?}: {errors}");
            assert!(errors.contains(expected), "{options:?}: {errors}");
        }
        bench.stop();
        let bench = BenchProcess::start("hub-tune-ask", "zlac");
        let (status, _, errors) = on(&bench, &["tune", "--drives", "zlac"]);
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("--yes"), "{errors}");
        let dry = [
            "tune",
            "--drives",
            "zlac",
            "--gains",
            "1,2,3",
            "--dry-run",
            "--json",
        ];
        let shown = json_of(on(&bench, &dry));
        let frames = shown["frames"].as_array().expect("a list");
        let is_kp = |frame: &&Value| frame["hex"] == "604#2B1D200001000000";
        assert_eq!(frames.iter().filter(is_kp).count(), 1, "{shown}");
        let report = bench.stop();
        assert_eq!(report["drives"][0]["rpdos"], 0);
    });
}

#[test]
fn a_servo_drive_makes_its_own_waves() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("tune-wave", "3", &["--with-gains"]);
        bench.disable("3");
        let wave = |options: &[&str]| {
            let words = [&["tune", "--drive", "3", "--yes", "--json"], options].concat();
            json_of(on(&bench, &words))
        };
        let square = [
            "--wave",
            "drive-square",
            "--gains",
            "20,20,10",
            "--gains",
            "20,5,10",
        ];
        let outcome = wave(&square);
        let sets = outcome["sets"].as_array().expect("a list");
        let overshoot = |set: &Value| number(set, "overshoot_percent");
        assert!(
            overshoot(&sets[1]) > overshoot(&sets[0]) + 20.0,
            "{outcome}"
        );
        for set in sets {
            assert!(
                (number(set, "frequency_hz") - 2.0).abs() < 0.05,
                "{outcome}"
            );
            // 0.02 turns to either side; the simulated drive reads that as the whole swing (D43).
            assert_eq!(set["figures"]["told_counts"], 656);
            assert!(
                (number(set, "swing_counts") - 328.0).abs() < 12.0,
                "{outcome}"
            );
        }
        let outcome = wave(&["--wave", "drive-sine", "--frequency", "4", "--periods", "6"]);
        let set = &outcome["sets"][0];
        assert!((number(set, "frequency_hz") - 4.0).abs() < 0.1, "{outcome}");
        assert!(set["figures"]["overshoot_percent"].is_null(), "{outcome}");
        let (status, _, errors) = on(
            &bench,
            &[
                "tune",
                "--drive",
                "3",
                "--yes",
                "--wave",
                "drive-sine",
                "--periods",
                "2",
            ],
        );
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("needs --periods 3 or more"), "{errors}");
        let report = bench.stop();
        let drive = &report["drives"][0];
        assert_eq!(
            (&drive["enabled"], &drive["data_errors"]),
            (&false.into(), &0.into())
        );
    });
}

#[test]
fn ctrl_c_ends_the_wave_of_a_drive() {
    undisturbed(|| {
        let bench = BenchProcess::start("tune-wave-ctrl-c", "3");
        bench.disable("3");
        let command = [
            "tune",
            "--slcan",
            bench.path(),
            "--drive",
            "3",
            "--yes",
            "--wave",
            "drive-square",
            "--periods",
            "50",
        ];
        let child = start_and_wait_for(motionctl(&command), "the motor moves");
        std::thread::sleep(Duration::from_secs(2));
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(130), "{errors}");
        let report = bench.stop();
        assert_eq!(report["drives"][0]["enabled"], false);
        let position = report["drives"][0]["position_counts"]
            .as_i64()
            .expect("a number");
        assert!(position.abs() < 50, "{report}");
    });
}

#[test]
fn a_picture_that_cannot_be_written_is_refused_before_anything_moves() {
    undisturbed(|| {
        let bench = BenchProcess::start("tune-picture", "3");
        bench.disable("3");
        let there = crate::bench::Scratch::new("tune-picture.svg", "");
        for (path, expected) in [
            ("/nonexistent/a.svg", "cannot write /nonexistent/a.svg"),
            (there.path(), "exists: choose another name"),
        ] {
            let words = ["tune", "--drive", "3", "--yes", "--svg", path];
            let (status, _, errors) = on(&bench, &words);
            assert_eq!(status, Some(2), "{errors}");
            assert!(errors.contains(expected), "{errors}");
        }
        let report = bench.stop();
        assert_eq!(report["drives"][0]["set_points"], 0);
    });
}
