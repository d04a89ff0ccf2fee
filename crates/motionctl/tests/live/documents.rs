//! What the documents leave open, as a user meets it.

use std::io::{Read as _, Write as _};

use serde_json::Value;

use crate::bench::{BenchProcess, motionctl, status_and_errors};
use crate::undisturbed::undisturbed;

fn on(bench: &BenchProcess, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = bench.run(arguments);
    let (status, errors) = status_and_errors(&output);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    (status, text, errors)
}

fn parameter(bench: &BenchProcess, name: &str) -> Option<i64> {
    let (_, text, errors) = on(bench, &["read", "--drive", "3", "--json"]);
    let readings: Value = serde_json::from_str(&text).unwrap_or_else(|_| panic!("{text}{errors}"));
    let mut parameters = readings["parameters"].as_array()?.iter();
    parameters.find(|reading| reading["parameter"] == name)?["value"].as_i64()
}

#[test]
fn absolute_mode_and_range_127_need_a_confirmation_of_their_own() {
    undisturbed(|| {
        let bench = BenchProcess::start("side-effects", "3");
        bench.disable("3");
        for (setting, option, name, before, after) in [
            ("config=0x04", "--allow-absolute-mode", "config", 0, 4),
            (
                "on-position-range=127",
                "--allow-brake-output",
                "on-position-range",
                20,
                127,
            ),
        ] {
            let write = ["write", "--drive", "3", setting, "--yes"];
            let (status, _, errors) = on(&bench, &write);
            assert_eq!(status, Some(2), "{errors}");
            assert!(errors.contains(option), "{errors}");
            assert_eq!(parameter(&bench, name), Some(before));
            let (status, _, errors) = on(&bench, &[&write[..], &[option]].concat());
            assert_eq!(status, Some(0), "{errors}");
            assert_eq!(parameter(&bench, name), Some(after));
            // What is there already is not written, and needs no answer.
            let (status, text, errors) = on(&bench, &write);
            assert_eq!(status, Some(0), "{errors}");
            assert!(text.contains("is already"), "{text}");
        }
        // The option of the one does not answer for the other.
        let crossed = ["--yes", "--allow-absolute-mode", "on-position-range=127"];
        let (status, _, errors) = on(
            &bench,
            &[&["write", "--drive", "3", "on-position-range=20", "--yes"][..]].concat(),
        );
        assert_eq!(status, Some(0), "{errors}");
        let (status, _, errors) = on(&bench, &[&["write", "--drive", "3"][..], &crossed].concat());
        assert_eq!(status, Some(2), "{errors}");
    });
}

/// Runs a scan of CANopen nodes on a bus of this bit rate with one DYN drive, whose identifiers it meets: its exit status, what it
/// printed, and how many frames got there.
fn canopen_scan(name: &str, bus: &str, options: &[&str]) -> (Option<i32>, String, u64) {
    let bench = BenchProcess::start_with(name, "48", &["--bit-rate", bus]);
    let scan = ["scan", "--protocol", "canopen", "--yes"];
    let (status, text, errors) = on(&bench, &[&scan[..], options].concat());
    let report = bench.stop();
    // 8 bytes are no request of a DYN drive.
    let frames = &report["drives"][0]["refused_frames"];
    (status, text + &errors, frames.as_u64().expect("a count"))
}

#[test]
fn a_scan_of_canopen_nodes_uses_500_kbit_unless_told_otherwise() {
    undisturbed(|| {
        let (status, text, frames) = canopen_scan("canopen-500", "500", &[]);
        assert_eq!(status, Some(1), "{text}");
        assert!(frames > 20, "{frames} frames");
        assert!(
            text.contains("at 500 kbit/s") && text.contains("1000, 250, 125, 100"),
            "{text}"
        );
        let told = canopen_scan("canopen-told", "1000", &["--bit-rate", "1000"]);
        assert!(told.0 == Some(1) && told.2 > 20, "{told:?}");
    });
}

#[test]
fn a_scan_at_a_wrong_bit_rate_ends_and_says_that_nothing_gets_out() {
    undisturbed(|| {
        let (status, text, frames) = canopen_scan("canopen-wrong", "1000", &[]);
        assert_eq!((status, frames), (Some(3), 0), "{text}");
        assert!(text.contains("no frame gets out"), "{text}");
        let bench = BenchProcess::start_with("dyn-wrong", "1", &["--bit-rate", "500"]);
        let (status, text, errors) = on(&bench, &["scan"]);
        assert_ne!(status, Some(0));
        assert!((text + &errors).contains("bit rate"));
    });
}

#[test]
fn the_bench_counts_what_it_refuses() {
    undisturbed(|| {
        let bench = BenchProcess::start("refusals", "3");
        let mut adapter = std::fs::File::options()
            .read(true)
            .write(true)
            .open(bench.path())
            .expect("the terminal");
        // Bit rate, open; a step beyond 16384, a read with a surplus byte; a frame without its data, an unknown command.
        adapter
            .write_all(b"S8\rO\rt07C24001\rt069100\rt07C2\rX\r")
            .expect("it is written");
        let mut answers = Vec::new();
        while answers.iter().filter(|&&byte| byte == 7).count() < 2 {
            let mut byte = [0];
            adapter.read_exact(&mut byte).expect("its answers");
            answers.push(byte[0]);
        }
        // The frames have left before the bench is asked to end.
        std::thread::sleep(std::time::Duration::from_millis(200));
        let report = bench.stop();
        let count = |value: &Value| value.as_u64().expect("a count");
        assert_eq!(count(&report["drives"][0]["refused_frames"]), 2, "{report}");
        assert_eq!(count(&report["drives"][0]["data_errors"]), 1, "{report}");
        assert_eq!(count(&report["refused_by_adapter"]), 1, "{report}");
        assert_eq!(count(&report["refused_commands"]), 1, "{report}");
    });
}

#[test]
fn monitor_says_how_old_the_last_answer_of_a_silent_drive_is() {
    undisturbed(|| {
        let bench = BenchProcess::start("silent", "1");
        let monitor = [
            "monitor",
            "--drives",
            "1,5",
            "--count",
            "1",
            "--every-ms",
            "900",
        ];
        let (status, text, errors) = on(&bench, &monitor);
        assert_eq!(status, Some(0), "{errors}");
        let mut lines = text.lines();
        let first = lines.next().unwrap_or_default();
        assert!(
            first.contains("age of status ") && !first.contains('?'),
            "{text}"
        );
        let second = lines.next().unwrap_or_default();
        assert!(second.ends_with("does not answer, it never did"), "{text}");
    });
}

#[test]
fn a_bit_rate_that_dyn_drives_do_not_know_is_refused_with_those_that_they_do() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("kbit100", "1", &[]);
        let arguments = [
            "monitor",
            "--slcan",
            bench.path(),
            "--drives",
            "1",
            "--bit-rate",
            "100",
        ];
        let output = motionctl(&arguments).output().expect("motionctl runs");
        let (status, errors) = status_and_errors(&output);
        assert_ne!(status, Some(0));
        assert!(
            errors.contains("DYN drives know 10, 20, 50, 125,") && errors.contains("not 100"),
            "{errors}"
        );
    });
}

#[test]
fn a_gear_number_that_fits_both_byte_orders_is_refused_until_the_user_says_which() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("both-orders", "3", &["--revision", "1.2A"]);
        bench.disable("3");
        // 4104 is 1008h, and read the other way round 2064.
        let both = "the gear number is 4104 or 2064";
        let write = ["write", "--drive", "3", "gear-number=4104", "--yes"];
        let (status, _, errors) = on(&bench, &write);
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains(both), "{errors}");
        let read = ["read", "--drive", "3", "--json"];
        let (status, _, errors) = on(&bench, &read);
        assert_eq!(status, Some(1), "{errors}");
        assert!(
            errors.contains(both) && errors.contains("--group3-order"),
            "{errors}"
        );
        for (order, gear) in [("msb-first", 4_104), ("lsb-first", 2_064)] {
            let (status, text, errors) =
                on(&bench, &[&read[..], &["--group3-order", order]].concat());
            assert_eq!(status, Some(0), "{errors}");
            let readings: Value = serde_json::from_str(&text).expect("JSON");
            let mut parameters = readings["parameters"].as_array().expect("a list").iter();
            let reading = parameters.find(|reading| reading["parameter"] == "gear-number");
            assert_eq!(reading.expect("it is read")["value"], gear);
        }
        let jog = ["jog", "--drive", "3", "--turns", "0.1", "--yes"];
        let (status, _, errors) = on(&bench, &jog);
        assert_ne!(status, Some(0), "{errors}");
        let report = bench.stop();
        assert_eq!(report["drives"][0]["set_points"], 0, "{report}");
        assert_eq!(report["drives"][0]["enabled"], false, "{report}");
    });
}
