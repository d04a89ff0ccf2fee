//! `motionctl home` against a bench with end stops and a switch, and what `jog` and `run` make of the origin.

use std::path::PathBuf;

use rustix::process::Signal;
use serde_json::Value;

use crate::bench::{
    BenchProcess, Scratch, interrupt, motionctl, scratch, start_and_wait_for, status_and_errors,
};
use crate::settings::{json_of, on};
use crate::undisturbed::undisturbed;

/// A file of origins, which is not there yet.
pub(crate) struct OriginsFile(PathBuf);

impl OriginsFile {
    pub(crate) fn new(name: &str) -> Self {
        let path = scratch(&format!("{name}-origins.toml"));
        let _ = std::fs::remove_file(&path);
        Self(path)
    }

    pub(crate) fn path(&self) -> &str {
        self.0.to_str().expect("plain text")
    }

    fn text(&self) -> String {
        std::fs::read_to_string(&self.0).expect("the file")
    }
}

impl Drop for OriginsFile {
    fn drop(&mut self) {
        // Nothing depends on it: the folder is temporary.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// A quick search, so that a test is short.
const QUICK: [&str; 6] = [
    "--rpm",
    "17",
    "--slow-rpm",
    "8",
    "--max-acceleration",
    "1000",
];

fn home(bench: &BenchProcess, options: &[&str]) -> (Option<i32>, String, String) {
    on(
        bench,
        &[&["home", "--drive", "3", "--yes"], &QUICK[..], options].concat(),
    )
}

fn to_a_stop<'a>(direction: &'a str, origins: &'a OriginsFile) -> Vec<&'a str> {
    vec![
        "--method",
        "stop",
        "--direction",
        direction,
        "--max-turns",
        "1",
        "--travel",
        "-2:2",
        "--origins",
        origins.path(),
        "--json",
    ]
}

fn position(bench: BenchProcess) -> i64 {
    let report = bench.stop();
    assert_eq!(report["drives"][0]["enabled"], false, "{report}");
    report["drives"][0]["position_counts"]
        .as_i64()
        .expect("a number")
}

#[test]
fn a_stop_is_found_in_both_directions_and_revisions() {
    undisturbed(|| {
        for (revision, direction, stop_counts) in
            [("1.2A", "negative", -3_277), ("1.6A", "positive", 4_915)]
        {
            let bench = BenchProcess::start_with(
                "home-stop",
                "3",
                &["--stops", "-0.2:0.3", "--revision", revision],
            );
            bench.disable("3");
            let origins = OriginsFile::new("stop");
            let outcome = json_of(home(&bench, &to_a_stop(direction, &origins)));
            let found = outcome["found_counts"].as_i64().expect("a number");
            assert!((found - stop_counts).abs() <= 1, "{outcome}");
            assert_eq!(outcome["origin_counts"], found);
            assert_eq!(outcome["enabled"], false);
            assert_eq!(outcome["after_power_loss"], "home-again");
            assert!(
                outcome["contact_torque_percent"].as_f64() >= Some(15.0),
                "{outcome}"
            );
            let sign = if direction == "positive" { 1.0 } else { -1.0 };
            let rest = outcome["axis_turns"].as_f64().expect("a number");
            assert!((rest + sign * 0.05).abs() < 0.001, "{outcome}");
            let text = origins.text();
            assert!(
                text.contains(&format!("origin-counts = {found}\n")),
                "{text}"
            );
            // 0.05 turns off the stop, and nothing was written to the drive.
            let report = bench.stop();
            assert_eq!(report["drives"][0]["eeprom_writes"], 0);
            assert_eq!(report["drives"][0]["enabled"], false);
        }
    });
}

#[test]
fn jog_and_run_use_the_origin_until_the_drive_loses_its_power() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("home-use", "3", &["--stops", "-0.2:3"]);
        bench.disable("3");
        let origins = OriginsFile::new("use");
        let outcome = json_of(home(&bench, &to_a_stop("negative", &origins)));
        let zero = outcome["origin_counts"].as_i64().expect("a number");
        let jog = |way: &[&str]| {
            let jog = [
                "jog",
                "--drive",
                "3",
                "--rpm",
                "120",
                "--yes",
                "--json",
                "--origins",
                origins.path(),
            ];
            on(&bench, &[&jog[..], way].concat())
        };
        // To a quarter of a turn from the zero, and once more: nothing to go.
        let end = json_of(jog(&["--to", "0.25"]));
        let asked = end["asked_counts"].as_i64().expect("a number");
        assert!((asked - (4_096 - 819)).abs() <= 2, "{end}");
        let end = json_of(jog(&["--to", "0.25"]));
        assert!(
            end["asked_counts"].as_i64().expect("a number").abs() <= 2,
            "{end}"
        );
        // Beyond the travel of 2 turns nothing moves.
        for way in [["--to", "2.1"], ["--turns", "1.9"]] {
            let (status, _, errors) = jog(&way);
            assert_eq!(status, Some(2), "{errors}");
            assert!(
                errors.contains("a position must be -32768..=32768 counts, it is 3"),
                "{errors}"
            );
        }
        let run = |text: &str| {
            let file = Scratch::new("home-use.csv", text);
            on(
                &bench,
                &[
                    "run",
                    "--trajectory",
                    file.path(),
                    "--drives",
                    "3",
                    "--axes",
                    "1",
                    "--yes",
                    "--json",
                    "--origins",
                    origins.path(),
                ],
            )
        };
        let (status, _, errors) = run("time_s,a\n0,0\n0.5,10\n");
        assert_eq!(status, Some(2), "{errors}");
        assert!(
            errors.contains("begins at 0.0000 turns") && errors.contains("--to 0.0000"),
            "{errors}"
        );
        let (status, text, errors) = run("time_s,a\n0,90\n0.5,180\n");
        assert_eq!(status, Some(0), "{text}{errors}");
        let (status, _, errors) = run("time_s,a\n0,180\n4,800\n");
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("leaves the travel of its axis"), "{errors}");
        // The power goes off and on, and the shaft stands half a turn from the zero.
        bench.signal(Signal::USR1);
        std::thread::sleep(std::time::Duration::from_millis(600));
        let (status, _, errors) = jog(&["--to", "0"]);
        assert_eq!(status, Some(2), "{errors}");
        assert!(
            errors.contains("the drive has lost its power since")
                && errors.contains("home it again"),
            "{errors}"
        );
        let report = bench.stop();
        assert_eq!(
            report["drives"][0]["received_counts"].as_i64(),
            Some(zero + 8_192),
            "{report}"
        );
    });
}

#[test]
fn a_search_that_finds_nothing_says_so_and_keeps_nothing() {
    undisturbed(|| {
        let bench = BenchProcess::start("home-nothing", "3");
        bench.disable("3");
        let origins = OriginsFile::new("nothing");
        let (status, text, errors) = home(&bench, &to_a_stop("positive", &origins));
        assert_eq!(status, Some(1), "{errors}");
        let outcome: Value = serde_json::from_str(&text).expect("JSON");
        assert_eq!(outcome["found"], false);
        assert_eq!(outcome["reason"], "nothing was found within 16384 counts");
        let text = origins.text();
        assert!(!text.contains("[[axis]]"), "{text}");
        assert_eq!(position(bench), 16_384);
    });
}

#[test]
fn ctrl_c_slows_down_and_disables() {
    undisturbed(|| {
        let bench = BenchProcess::start("home-ctrl-c", "3");
        bench.disable("3");
        let command = [
            "home",
            "--slcan",
            bench.path(),
            "--drive",
            "3",
            "--yes",
            "--method",
            "stop",
            "--direction",
            "positive",
            "--max-turns",
            "50",
        ];
        let child = start_and_wait_for(motionctl(&command), "Ctrl-C stops it");
        std::thread::sleep(std::time::Duration::from_secs(2));
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(130), "{errors}");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(
            text.contains("stopped by the user. It is disabled"),
            "{text}"
        );
        assert!((1..200_000).contains(&position(bench)));
    });
}

#[test]
fn a_switch_is_found_by_the_lines_of_another_program() {
    undisturbed(|| {
        let lines = scratch("home-switch-lines");
        let _ = std::fs::remove_file(&lines);
        let lines_path = lines.to_str().expect("plain text");
        let bench = BenchProcess::start_with(
            "home-switch",
            "3",
            &["--switch-at", "0.2", "--switch-lines", lines_path],
        );
        bench.disable("3");
        let switch = [
            "--method",
            "switch",
            "--direction",
            "positive",
            "--max-turns",
            "1",
            "--json",
            "--switch-input",
        ];
        let outcome = json_of(home(&bench, &[&switch[..], &[lines_path]].concat()));
        let found = outcome["found_counts"].as_i64().expect("a number");
        let uncertainty = outcome["uncertainty_counts"].as_i64().expect("a number");
        assert!((found - 3_277).abs() <= uncertainty.max(40), "{outcome}");
        // A file ends, and says nothing any more.
        let ended = Scratch::new("home-switch-ended", "0\n0\n");
        let (status, text, errors) = home(&bench, &[&switch[..], &[ended.path()]].concat());
        assert_eq!(status, Some(1), "{errors}");
        assert!(
            text.contains("the switch must be at most 200000 us old"),
            "{text}"
        );
        let nonsense = Scratch::new("home-switch-nonsense", "0\nopen\n");
        let (status, _, errors) = home(&bench, &[&switch[..], &[nonsense.path()]].concat());
        assert_eq!(status, Some(1), "{errors}");
        assert!(
            errors.contains("expected 1 or 0 on a line of --switch-input, got \"open\""),
            "{errors}"
        );
        let _ = std::fs::remove_file(&lines);
    });
}

#[test]
fn here_moves_nothing_and_the_drive_takes_its_own_zero_on_request_only() {
    undisturbed(|| {
        let bench = BenchProcess::start("home-here", "3");
        bench.disable("3");
        let jog = [
            "jog", "--drive", "3", "--turns", "0.1", "--rpm", "120", "--yes",
        ];
        let (status, _, errors) = on(&bench, &jog);
        assert_eq!(status, Some(0), "{errors}");
        let here = [
            "home",
            "--drive",
            "3",
            "--method",
            "here",
            "--reference",
            "0.5",
            "--yes",
            "--json",
        ];
        let outcome = json_of(on(&bench, &here));
        assert_eq!(outcome["found_counts"], 1_638);
        assert_eq!(outcome["origin_counts"], 1_638 - 8_192);
        assert_eq!(outcome["eeprom_writes"], 0);
        let origins = OriginsFile::new("here");
        let kept = [
            "--in-drive",
            "--travel",
            "-1:1",
            "--origins",
            origins.path(),
        ];
        let outcome = json_of(on(&bench, &[&here[..], &kept].concat()));
        // The drive reports 0 here now, and the axis is where it was.
        assert_eq!(outcome["origin_counts"], -8_192);
        assert_eq!(
            (&outcome["axis_turns"], &outcome["eeprom_writes"]),
            (&0.5.into(), &1.into())
        );
        let report = bench.stop();
        let drive = &report["drives"][0];
        assert_eq!(
            (&drive["position_counts"], &drive["eeprom_writes"]),
            (&0.into(), &1.into())
        );
        assert_eq!(drive["received_counts"], 1_638);
    });
}

#[test]
fn nothing_moves_without_an_answer_and_a_dry_run_sends_nothing() {
    undisturbed(|| {
        let bench = BenchProcess::start("home-ask", "3");
        bench.disable("3");
        let stop = [
            "home",
            "--drive",
            "3",
            "--method",
            "stop",
            "--direction",
            "negative",
            "--max-turns",
            "1",
        ];
        let (status, _, errors) = on(&bench, &stop);
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("--yes"), "{errors}");
        for (options, expected) in [
            (
                ["--torque", "90"],
                "--torque must be below --max-torque, 80, it is 90",
            ),
            (["--rpm", "100"], "--rpm must be at most"),
            (
                ["--slow-rpm", "20"],
                "--slow-rpm must be below --rpm, 15, it is 20",
            ),
            (
                ["--travel", "-1:0.01"],
                "the axis comes to rest at 819, which must be within its travel",
            ),
            (["--gear-number", "500"], "drive 3 has gear number 4096"),
        ] {
            let (status, _, errors) = on(&bench, &[&stop[..], &options, &["--yes"]].concat());
            assert_eq!(status, Some(2), "{errors}");
            assert!(errors.contains(expected), "{errors}");
        }
        let shown = json_of(on(&bench, &[&stop[..], &["--dry-run", "--json"]].concat()));
        let hex: Vec<&str> = shown["frames"]
            .as_array()
            .expect("a list")
            .iter()
            .filter_map(|frame| frame["hex"].as_str())
            .collect();
        assert!(hex.ends_with(&["079#00", "07C#FF", "079#FF"]), "{hex:?}");
    });
}
