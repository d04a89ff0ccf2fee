//! `motionctl tune` against a bench whose drives know their gains.

use std::time::Duration;

use serde_json::{Value, json};

use crate::bench::{
    BenchProcess, interrupt, motionctl, scratch, start_and_wait_for, status_and_errors,
};
use crate::settings::{eeprom_writes, json_of, on};
use crate::undisturbed::undisturbed;

fn gains(bench: &BenchProcess) -> Vec<i64> {
    let readings = json_of(on(bench, &["read", "--drive", "3", "--json"]));
    let parameters = readings["parameters"].as_array().expect("a list").clone();
    ["main-gain", "speed-gain", "integration-gain"]
        .iter()
        .filter_map(|name| {
            let reading = parameters
                .iter()
                .find(|reading| reading["parameter"] == **name)?;
            reading["value"].as_i64()
        })
        .collect()
}

fn number(set: &Value, figure: &str) -> f64 {
    set["figures"][figure]
        .as_f64()
        .unwrap_or_else(|| panic!("{figure}: {set}"))
}

#[test]
fn three_sets_of_gains_are_compared_and_the_old_ones_come_back() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("tune", "3", &["--with-gains"]);
        bench.disable("3");
        let picture = scratch("tune.svg");
        let _ = std::fs::remove_file(&picture);
        let svg = picture.to_str().expect("plain text");
        let outcome = json_of(on(
            &bench,
            &[
                "tune", "--drive", "3", "--yes", "--json", "--svg", svg, "--gains", "20,20,10",
                "--gains", "20,5,10", "--gains", "40,40,10",
            ],
        ));
        let sets = outcome["sets"].as_array().expect("a list");
        assert_eq!(sets.len(), 3);
        // Less damping overshoots more and takes longer; a stiffer loop is faster.
        assert!(
            number(&sets[1], "overshoot_percent") > number(&sets[0], "overshoot_percent") + 20.0,
            "{outcome}"
        );
        assert!(
            number(&sets[1], "settling_ms") > number(&sets[0], "settling_ms"),
            "{outcome}"
        );
        assert!(
            number(&sets[2], "rise_ms") < number(&sets[0], "rise_ms"),
            "{outcome}"
        );
        // The largest error is the step itself, up to what the motor has moved before the first reading.
        let peak = number(&sets[0], "following_error_peak_counts");
        assert!((300.0..=340.0).contains(&peak), "{peak}: {outcome}");
        assert_eq!(outcome["restored"], true);
        // One gain of the second set, three of the third but the integration gain, and two back.
        assert_eq!(outcome["eeprom_writes"], 1 + 2 + 2);
        assert_eq!(gains(&bench), [20, 20, 10]);
        let picture_text = std::fs::read_to_string(&picture).expect("the picture");
        assert!(
            picture_text.starts_with("<svg") && picture_text.contains("main gain 40"),
            "{picture_text}"
        );
        let _ = std::fs::remove_file(&picture);
        let report = bench.stop();
        assert_eq!(report["drives"][0]["enabled"], false);
        assert_eq!(report["drives"][0]["received_counts"], 0);
        assert_eq!(eeprom_writes(&report), [Some(5)]);
    });
}

#[test]
fn ctrl_c_brings_the_old_gains_back_too() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("tune-ctrl-c", "3", &["--with-gains"]);
        bench.disable("3");
        let command = [
            "tune",
            "--slcan",
            bench.path(),
            "--drive",
            "3",
            "--yes",
            "--gains",
            "33,20,10",
            "--periods",
            "50",
        ];
        let child = start_and_wait_for(motionctl(&command), "the motor moves");
        std::thread::sleep(Duration::from_secs(2));
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(130), "{errors}");
        assert!(
            errors.contains("has its old gains again: main gain 20"),
            "{errors}"
        );
        assert_eq!(gains(&bench), [20, 20, 10]);
        assert_eq!(bench.stop()["drives"][0]["enabled"], false);
    });
}

#[test]
fn without_gains_nothing_is_written_and_nothing_moves_without_an_answer() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("tune-present", "3", &["--with-gains"]);
        // Its servo is on after power-on.
        let tune = ["tune", "--drive", "3"];
        let (status, _, errors) = on(&bench, &[&tune[..], &["--yes"]].concat());
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("drive 3 is enabled"), "{errors}");
        bench.disable("3");
        let (status, _, errors) = on(&bench, &tune);
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("--yes"), "{errors}");
        for (gains, words) in [
            ("20,20", "each 1..=127"),
            ("20,20,128", "each 1..=127"),
            ("0,20,10", "each 1..=127"),
        ] {
            let (status, _, errors) =
                on(&bench, &[&tune[..], &["--gains", gains, "--yes"]].concat());
            assert_eq!(status, Some(2), "{errors}");
            assert!(errors.contains(words), "{errors}");
        }
        let four = [
            "--gains", "1,1,1", "--gains", "1,1,1", "--gains", "1,1,1", "--gains", "1,1,1",
        ];
        let (status, _, errors) = on(&bench, &[&tune[..], &four].concat());
        assert_eq!(
            (
                status,
                errors.contains("--gains may be given 3 times, it is given 4 times")
            ),
            (Some(2), true),
            "{errors}"
        );
        let dry = json_of(on(
            &bench,
            &[&tune[..], &["--gains", "21,20,10", "--dry-run", "--json"]].concat(),
        ));
        let written = dry["frames"].as_array().expect("a list").iter();
        assert!(
            written.clone().any(|frame| frame["hex"] == "070#15000000"),
            "{dry}"
        );
        let wave = [
            "--yes",
            "--json",
            "--periods",
            "3",
            "--hold-ms",
            "200",
            "--amplitude",
            "-0.01",
        ];
        let outcome = json_of(on(&bench, &[&tune[..], &wave].concat()));
        assert_eq!(
            (
                &outcome["eeprom_writes"],
                &outcome["sets"][0]["gains"]["main-gain"]
            ),
            (&json!(0), &json!(20))
        );
        assert!(number(&outcome["sets"][0], "samples") > 100.0, "{outcome}");
        assert_eq!(eeprom_writes(&bench.stop()), [Some(0)]);
    });
}

#[test]
fn gains_that_cannot_be_brought_back_are_named_with_what_to_do() {
    undisturbed(|| {
        let options = ["--with-gains", "--ignore-settings-after", "1"];
        let bench = BenchProcess::start_with("tune-stuck", "3", &options);
        bench.disable("3");
        let tune = ["tune", "--drive", "3", "--yes", "--gains", "33,20,10"];
        let (status, _, errors) = on(&bench, &tune);
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("are NOT back"), "{errors}");
        let remedy = "motionctl write --drive 3 main-gain=20 speed-gain=20 integration-gain=10";
        assert!(errors.contains(remedy), "{errors}");
        assert_eq!(gains(&bench), [33, 20, 10]);
        assert_eq!(bench.stop()["drives"][0]["enabled"], false);
    });
}

/// A drive that goes into alarm ends the measurement, and gets its gains back all the same.
#[test]
fn a_fault_brings_the_old_gains_back_too() {
    undisturbed(|| {
        let options = ["--with-gains", "--stops", "-0.01:0.01"];
        let bench = BenchProcess::start_with("tune-fault", "3", &options);
        bench.disable("3");
        let step = ["--amplitude", "0.25", "--gains", "127,20,10"];
        let (status, _, errors) = on(
            &bench,
            &[&["tune", "--drive", "3", "--yes"], &step[..]].concat(),
        );
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("at standstill the position is"), "{errors}");
        assert!(errors.contains("has its old gains again"), "{errors}");
        assert_eq!(gains(&bench), [20, 20, 10]);
        assert_eq!(bench.stop()["drives"][0]["enabled"], false);
    });
}
