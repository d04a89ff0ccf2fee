//! `motionctl home --drives zlac` against a bench with end stops and a switch, and what `jog` makes of the origin.

use rustix::process::Signal;
use serde_json::Value;

use crate::bench::{
    BenchProcess, Scratch, interrupt, motionctl, scratch, start_and_wait_for, status_and_errors,
    wait_until,
};
use crate::home::OriginsFile;
use crate::settings::{json_of, on};
use crate::undisturbed::undisturbed;

/// A quick search, so that a test is short.
const QUICK: [&str; 6] = [
    "--rpm",
    "25",
    "--slow-rpm",
    "10",
    "--max-acceleration",
    "1000",
];
const STOP: [&str; 6] = [
    "--method",
    "stop",
    "--max-turns",
    "1",
    "--direction",
    "negative",
];

fn home(bench: &BenchProcess, options: &[&str]) -> (Option<i32>, String, String) {
    on(
        bench,
        &[&["home", "--drives", "zlac", "--yes"], &QUICK[..], options].concat(),
    )
}

/// The command must end with this status and this text, in its output or its errors.
fn ends(bench: &BenchProcess, status: i32, text: &str, options: &[&str]) {
    let (actual, output, errors) = home(bench, options);
    assert_eq!(actual, Some(status), "{options:?}: {output}{errors}");
    assert!(
        output.contains(text) || errors.contains(text),
        "{options:?}: {output}{errors}"
    );
}

fn number(value: &Value) -> i64 {
    value.as_i64().expect("a number")
}

/// What the drive has as its largest current, in 0.1 A.
fn most_current(bench: &BenchProcess) -> i64 {
    let read = ["read", "--drives", "zlac", "2015h", "--json"];
    number(&json_of(on(bench, &read))[0]["value"])
}

#[test]
fn a_stop_is_found_in_both_directions_and_nothing_is_stored() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("hub-home-stop", "zlac", &["--stops", "-0.2:0.3"]);
        for (direction, stop_counts, sign) in [("negative", -819, -1.0), ("positive", 1_229, 1.0)] {
            let search = [
                "--method",
                "stop",
                "--max-turns",
                "1",
                "--direction",
                direction,
                "--json",
            ];
            let outcome = json_of(home(&bench, &search));
            let found = number(&outcome["found_counts"]);
            assert!((found - stop_counts).abs() <= 1, "{outcome}");
            assert_eq!(
                (&outcome["node"], &outcome["found"]),
                (&4.into(), &true.into())
            );
            assert_eq!(outcome["origin_counts"], found);
            assert_eq!(outcome["after_power_loss"], "home-again");
            let torque = outcome["contact_torque_percent"].as_f64();
            assert!(torque >= Some(15.0), "{outcome}");
            let rest = outcome["axis_turns"].as_f64().expect("a number");
            assert!((rest + sign * 0.05).abs() < 0.002, "{outcome}");
        }
        assert_eq!(most_current(&bench), 300);
        let report = bench.stop();
        let drive = &report["drives"][0];
        assert_eq!(
            (&drive["enabled"], &drive["eeprom_writes"]),
            (&false.into(), &0.into())
        );
    });
}

#[test]
fn jog_uses_the_origin_until_the_drive_loses_its_power() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("hub-home-use", "zlac", &["--stops", "-0.2:3"]);
        let origins = OriginsFile::new("hub-use");
        let kept = ["--travel", "-0.5:2", "--origins", origins.path(), "--json"];
        let outcome = json_of(home(&bench, &[&STOP[..], &kept].concat()));
        let zero = number(&outcome["origin_counts"]);
        let jog = |way: &[&str]| {
            let jog = ["jog", "--drives", "zlac", "--rpm", "120", "--yes", "--json"];
            on(
                &bench,
                &[&jog[..], &["--origins", origins.path()], way].concat(),
            )
        };
        let end = json_of(jog(&["--to", "0.25"]));
        assert_eq!(number(&end["position_counts"]), zero + 1_024, "{end}");
        let end = json_of(jog(&["--turns", "0.5"]));
        assert_eq!(number(&end["position_counts"]), zero + 3_072, "{end}");
        for way in [["--to", "2.1"], ["--turns", "1.9"]] {
            let (status, _, errors) = jog(&way);
            assert_eq!(status, Some(2), "{errors}");
            assert!(
                errors.contains("must stay within -0.5000..=2.0000 turns"),
                "{errors}"
            );
        }
        bench.signal(Signal::USR1);
        let read = ["read", "--drives", "zlac", "2010h", "--json"];
        wait_until("the drive is back", || {
            let (status, text, _) = on(&bench, &read);
            status == Some(0) && text.contains("\"value\": 0")
        });
        let (status, _, errors) = jog(&["--to", "0"]);
        assert_eq!(status, Some(2), "{errors}");
        assert!(
            errors.contains("the drive has lost its power since")
                && errors.contains("home it again"),
            "{errors}"
        );
        let (status, _, errors) = on(
            &bench,
            &[
                "jog",
                "--drives",
                "zlac:5",
                "--to",
                "0",
                "--origins",
                origins.path(),
                "--yes",
            ],
        );
        assert_eq!(status, Some(1), "{errors}");
    });
}

#[test]
fn a_search_without_a_reference_says_why_and_brings_the_current_back() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("hub-home-nothing", "zlac", &["--stops", "-0.2:3"]);
        let origins = OriginsFile::new("hub-nothing");
        let kept = ["--travel", "-9:9", "--origins", origins.path()];
        let short = [
            "--method",
            "stop",
            "--direction",
            "positive",
            "--max-turns",
            "0.2",
        ];
        ends(
            &bench,
            1,
            "nothing was found within 819 counts",
            &[&short[..], &kept].concat(),
        );
        let text = std::fs::read_to_string(origins.path()).expect("the file");
        assert!(!text.contains("[[wheel]]"), "{text}");
        // The torque is read as another unit, and with another sign.
        let milli = [&STOP[..], &["--current-unit", "mA"]].concat();
        ends(&bench, 1, "see --current-unit (Z25)", &milli);
        let reversed = [&STOP[..], &["--torque-reversed"]].concat();
        ends(&bench, 1, "try --torque-reversed", &reversed);
        assert_eq!(most_current(&bench), 300);
        let report = bench.stop();
        assert_eq!(report["drives"][0]["enabled"], false);
    });
}

#[test]
fn ctrl_c_slows_down_and_switches_off() {
    undisturbed(|| {
        let bench = BenchProcess::start("hub-home-ctrl-c", "zlac");
        let command = [
            "home",
            "--slcan",
            bench.path(),
            "--drives",
            "zlac",
            "--yes",
            "--method",
            "stop",
            "--direction",
            "positive",
            "--max-turns",
            "50",
        ];
        let child = start_and_wait_for(motionctl(&command), "Ctrl-C stops it");
        std::thread::sleep(std::time::Duration::from_secs(3));
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(130), "{errors}");
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(
            text.contains("stopped by the user. It is disabled"),
            "{text}"
        );
        assert_eq!(most_current(&bench), 300);
        let report = bench.stop();
        assert_eq!(report["drives"][0]["enabled"], false);
    });
}

#[test]
fn a_switch_is_found_by_the_lines_of_another_program_and_by_an_input_of_the_drive() {
    undisturbed(|| {
        let lines = scratch("hub-home-switch-lines");
        let _ = std::fs::remove_file(&lines);
        let lines_path = lines.to_str().expect("plain text");
        let options = ["--switch-at", "0.2", "--switch-lines", lines_path];
        let bench = BenchProcess::start_with("hub-home-switch", "zlac", &options);
        let switch = [
            "--method",
            "switch",
            "--direction",
            "positive",
            "--max-turns",
            "1",
            "--switch-input",
        ];
        let outcome = json_of(home(
            &bench,
            &[&switch[..], &[lines_path, "--json"]].concat(),
        ));
        let found = number(&outcome["found_counts"]);
        let uncertainty = number(&outcome["uncertainty_counts"]);
        assert!((found - 819).abs() <= uncertainty.max(60), "{outcome}");
        // The same switch hangs on the input X1 of the drive.
        let back = ["jog", "--drives", "zlac", "--turns", "-0.1", "--yes"];
        assert_eq!(on(&bench, &back).0, Some(0));
        let outcome = json_of(home(&bench, &[&switch[..], &["X1", "--json"]].concat()));
        let found = number(&outcome["found_counts"]);
        let uncertainty = number(&outcome["uncertainty_counts"]);
        assert!((found - 819).abs() <= uncertainty.max(60), "{outcome}");
        let expected = "input X0 of node 4 must have no function to be a switch, 2030h:02 is 9";
        ends(&bench, 2, expected, &[&switch[..], &["X0"]].concat());
        let nonsense = Scratch::new("hub-home-nonsense", "0\nopen\n");
        let expected = "expected 1 or 0 on a line of --switch-input, got \"open\"";
        ends(
            &bench,
            1,
            expected,
            &[&switch[..], &[nonsense.path()]].concat(),
        );
        let _ = std::fs::remove_file(&lines);
    });
}

#[test]
fn here_moves_nothing_and_the_drive_counts_from_there_on_request_only() {
    undisturbed(|| {
        let bench = BenchProcess::start("hub-home-here", "zlac");
        let jog = ["jog", "--drives", "zlac", "--turns", "0.1", "--yes"];
        assert_eq!(on(&bench, &jog).0, Some(0));
        let here = ["--method", "here", "--reference", "0.5", "--json"];
        let outcome = json_of(home(&bench, &here));
        let stands = number(&outcome["found_counts"]);
        assert!((stands - 410).abs() <= 1, "{outcome}");
        assert_eq!(number(&outcome["origin_counts"]), stands - 2_048);
        let outcome = json_of(home(&bench, &[&here[..], &["--in-drive"]].concat()));
        assert_eq!(
            (&outcome["origin_counts"], &outcome["axis_turns"]),
            (&(-2_048).into(), &0.5.into())
        );
        let report = bench.stop();
        let drive = &report["drives"][0];
        assert_eq!(
            (&drive["position_counts"], &drive["eeprom_writes"]),
            (&0.into(), &0.into())
        );
        assert_eq!(number(&drive["travel_counts"]), stands);
    });
}

#[test]
fn what_cannot_work_is_refused_before_anything_moves() {
    undisturbed(|| {
        let bench = BenchProcess::start("hub-home-ask", "zlac:4");
        let (status, _, errors) = on(&bench, &[&["home", "--drives", "zlac"], &STOP[..]].concat());
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("--yes") && errors.is_ascii(), "{errors}");
        for (options, expected) in [
            (
                ["--torque", "90"],
                "--torque must be below --max-torque, 80, it is 90",
            ),
            (
                ["--contact-degrees", "100"],
                "--contact-degrees must be below --max-degrees, 90",
            ),
            (
                ["--slow-rpm", "60"],
                "--slow-rpm must be below --rpm, 25, it is 60",
            ),
            (["--max-degrees", "20"], "--rpm must be at most"),
            (["--travel", "-1:0.01"], "which must be within its travel"),
        ] {
            let rest: Vec<&str> = QUICK
                .chunks(2)
                .filter(|pair| pair[0] != options[0])
                .flatten()
                .copied()
                .collect();
            let words = [
                &["home", "--drives", "zlac", "--yes"],
                &rest[..],
                &STOP,
                &options,
            ];
            let (status, _, errors) = on(&bench, &words.concat());
            assert_eq!(status, Some(2), "{options:?}: {errors}");
            assert!(errors.contains(expected), "{errors}");
        }
        let dry = [
            &["home", "--drives", "zlac", "--dry-run", "--json"],
            &STOP[..],
        ]
        .concat();
        let shown = json_of(on(&bench, &dry));
        let last = shown["frames"].as_array().and_then(|frames| frames.last());
        assert_eq!(last.expect("a frame")["hex"], "604#2B40600000000000");
        let report = bench.stop();
        assert_eq!(report["drives"][0]["travel_counts"], 0);
        assert_eq!(report["drives"][0]["rpdos"], 0);
    });
}

#[test]
fn drives_that_cannot_be_homed_say_why() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("hub-home-alarm", "zlac", &["--alarm", "zlac:4"]);
        ends(&bench, 1, "node 4 has a fault", &STOP);
        let silent = [&STOP[..], &["--drive", "9"]].concat();
        ends(&bench, 1, "node 9 does not answer", &silent);
        bench.stop();
        // It falls silent after 2010h and 2015h were written.
        let options = ["--silent-after-writes", "2"];
        let bench = BenchProcess::start_with("hub-home-silent", "zlac", &options);
        ends(&bench, 1, "do NOT have their values again", &STOP);
    });
}
