//! `backup` and `restore` against a bench.

use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use rustix::process::Signal;
use serde_json::{Value, json};

use crate::bench::{
    BenchProcess, interrupt, motionctl, scratch, start_and_wait_for, status_and_errors,
};
use crate::undisturbed::undisturbed;

/// A file for a backup, which is not there yet.
pub(crate) struct Backup(PathBuf);

impl Backup {
    pub(crate) fn new(name: &str) -> Self {
        let path = scratch(&format!("{name}.toml"));
        let _ = std::fs::remove_file(&path);
        Self(path)
    }

    pub(crate) fn path(&self) -> &str {
        self.0.to_str().expect("plain text")
    }

    pub(crate) fn text(&self) -> String {
        std::fs::read_to_string(&self.0).expect("the file")
    }

    /// Replaces texts that are there.
    pub(crate) fn edit(&self, changes: &[(&str, &str)]) {
        let mut text = self.text();
        for (from, to) in changes {
            assert!(text.contains(from), "{from}: {text}");
            text = text.replacen(from, to, 1);
        }
        std::fs::write(&self.0, text).expect("the file");
    }
}

impl Drop for Backup {
    fn drop(&mut self) {
        // Nothing depends on it: the folder is temporary.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Runs a command with a link: its exit status, what it printed, its errors.
pub(crate) fn run(link: [&str; 2], arguments: &[&str]) -> (Option<i32>, String, String) {
    let (command, options) = arguments.split_first().expect("a command");
    let [kind, port] = link;
    let output = motionctl(&[&[*command, kind, port], options].concat())
        .output()
        .expect("motionctl runs");
    let (status, errors) = status_and_errors(&output);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    (status, text, errors)
}

pub(crate) fn on(bench: &BenchProcess, arguments: &[&str]) -> (Option<i32>, String, String) {
    run(["--slcan", bench.path()], arguments)
}

pub(crate) fn serial(bench: &BenchProcess, arguments: &[&str]) -> (Option<i32>, String, String) {
    run(["--serial", bench.serial_path()], arguments)
}

pub(crate) fn json_of((status, text, errors): (Option<i32>, String, String)) -> Value {
    assert_eq!(status, Some(0), "{text}{errors}");
    serde_json::from_str(&text).unwrap_or_else(|_| panic!("{text}"))
}

/// Backs up drives of a bench, which are disabled first.
pub(crate) fn backed_up(name: &str, bench: &BenchProcess, drives: &str) -> Backup {
    bench.disable(drives);
    let file = Backup::new(name);
    let (status, text, errors) = on(bench, &["backup", file.path(), "--drives", drives]);
    assert_eq!(status, Some(0), "{text}{errors}");
    file
}

/// The EEPROM writes of each drive of a bench that has ended.
pub(crate) fn eeprom_writes(report: &Value) -> Vec<Option<u64>> {
    let drives = report["drives"].as_array().expect("a list");
    let writes = drives.iter().map(|drive| drive["eeprom_writes"].as_u64());
    writes.collect()
}

fn change(parameter: &str, before: i64, value: i64, result: &str) -> Value {
    json!({ "parameter": parameter, "before": before, "value": value, "result": result })
}

fn value(bench: &BenchProcess, drive: &str, parameter: &str) -> Option<i64> {
    let readings = json_of(on(bench, &["read", "--drive", drive, "--json"]));
    let mut parameters = readings["parameters"].as_array().expect("a list").iter();
    let reading = parameters.find(|reading| reading["parameter"] == parameter);
    reading.expect("the parameter")["value"].as_i64()
}

#[test]
fn a_backup_is_restored_and_only_what_differs_is_written() {
    undisturbed(|| {
        let bench = BenchProcess::start("backup", "1,2");
        let file = backed_up("backup", &bench, "1,2");
        let text = file.text();
        for part in [
            concat!("tool = \"motionctl ", env!("CARGO_PKG_VERSION"), "\""),
            "date = 20",
            "id = 2",
            "revision = \"1.6A\"",
            "max-speed = 60  # 3028.8 rpm",
            "gear-number = 4096  # ratio 1.000, 16384 counts a turn",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
        let settings = ["main-gain=33", "gear-number=8192", "--yes"];
        json_of(on(
            &bench,
            &[&["write", "--drive", "1", "--json"], &settings[..]].concat(),
        ));
        let restore = ["restore", file.path()];
        let (status, text, _) = on(&bench, &[&restore[..], &["--compare"]].concat());
        assert_eq!(status, Some(1), "{text}");
        assert!(
            text.contains("8192 (ratio 0.500, 32768 counts a turn)"),
            "{text}"
        );
        let (status, _, errors) = on(&bench, &restore);
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("needs a confirmation"), "{errors}");
        assert_eq!(value(&bench, "1", "main-gain"), Some(33));

        let outcome = json_of(on(&bench, &[&restore[..], &["--yes", "--json"]].concat()));
        assert_eq!(outcome["complete"], true);
        let [one, two] = [&outcome["drives"][0], &outcome["drives"][1]];
        assert_eq!((&one["drive"], &one["same"]), (&json!(1), &json!(7)));
        assert_eq!(
            one["changes"],
            json!([
                change("main-gain", 33, 20, "written"),
                change("gear-number", 8_192, 4_096, "written"),
            ])
        );
        assert_eq!(
            (&one["eeprom_writes"], &two["eeprom_writes"]),
            (&json!(2), &json!(0))
        );
        assert_eq!((&two["same"], &two["changes"]), (&json!(9), &json!([])));
        let (status, text, _) = on(&bench, &[&restore[..], &["--yes"]].concat());
        assert_eq!(status, Some(0), "{text}");
        assert!(text.contains("EEPROM writes: 0"), "{text}");
        // What was stored outlasts the power.
        bench.signal(Signal::USR1);
        std::thread::sleep(std::time::Duration::from_millis(500));
        assert_eq!(value(&bench, "1", "main-gain"), Some(20));
        assert_eq!(eeprom_writes(&bench.stop()), [Some(4), Some(0)]);
    });
}

#[test]
fn a_backup_replaces_no_file_and_leaves_no_part_of_one() {
    undisturbed(|| {
        let bench = BenchProcess::start("backup-file", "1");
        let folder = scratch("backup-folder");
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir(&folder).expect("a folder");
        let there = |folder: &Path| std::fs::read_dir(folder).expect("a folder").count();
        let path = folder.join("drives.toml");
        let name = path.to_str().expect("plain text");
        let backup = ["backup", name, "--drives", "1"];
        // A drive that is silent leaves no file.
        let (status, _, errors) = on(&bench, &["backup", name, "--drives", "1,9"]);
        assert_eq!((status, there(&folder)), (Some(1), 0), "{errors}");
        assert!(errors.contains("drive 9 does not answer"), "{errors}");
        // A full disk neither: the system gives no room for a single byte.
        let no_room = "trap '' XFSZ; ulimit -f 0; exec \"$0\" \"$@\" 2>&1 | cat";
        let full_disk = |options: &[&str]| {
            let output = Command::new("sh")
                .args(["-c", no_room, env!("CARGO_BIN_EXE_motionctl")])
                .args([&backup[..], &["--slcan", bench.path()], options].concat())
                .output()
                .expect("a shell");
            String::from_utf8_lossy(&output.stdout).into_owned()
        };
        let errors = full_disk(&[]);
        assert!(
            errors.contains("cannot write") && errors.contains("No part of a file"),
            "{errors}"
        );
        assert_eq!(there(&folder), 0, "{errors}");
        std::fs::write(&path, "mine").expect("a file");
        let (status, _, errors) = on(&bench, &backup);
        assert_eq!(status, Some(2), "{errors}");
        assert!(
            errors.contains("exists") && errors.contains("--force"),
            "{errors}"
        );
        let errors = full_disk(&["--force"]);
        assert!(errors.contains("cannot write"), "{errors}");
        let content = || std::fs::read_to_string(&path).expect("a file");
        assert_eq!((content().as_str(), there(&folder)), ("mine", 1));
        let force = [&backup[..], &["--force", "--json"]].concat();
        let end = json_of(on(&bench, &force));
        assert_eq!(end["drives"][0]["drive"], 1);
        assert!(content().contains("[[drive]]"));
        assert_eq!(there(&folder), 1);
        assert_eq!(eeprom_writes(&bench.stop()), [Some(0)]);
        std::fs::remove_dir_all(&folder).expect("a folder");
    });
}

#[test]
fn a_dry_run_sends_nothing_and_shows_every_frame() {
    undisturbed(|| {
        let bench = BenchProcess::start_with_serial("dry-run", "1", &[]);
        let file = backed_up("dry-run", &bench, "1");
        file.edit(&[("main-gain = 20", "main-gain = 33")]);
        let frames_before = bench.stop()["frames_from_host"].as_u64();
        assert!(frames_before > Some(10));
        let bench = BenchProcess::start_with_serial("dry-run", "1", &[]);
        let path = file.path();
        // Identifier 032: drive 1, function 10h; 21h is 33. Packets of the manual: id, length and function, data, sum.
        for (arguments, on_can, on_line) in [
            (&["restore", path][..], "030#21000000", "01 90 A1 B2"),
            (
                &["write", "--drive", "1", "main-gain=33"],
                "030#21000000",
                "01 90 A1 B2",
            ),
            (
                &["backup", "other.toml", "--drives", "1"],
                "033#",
                "01 98 80 99",
            ),
            (
                &["assign-id", "--from", "0", "--to", "5"],
                "005#05",
                "00 85 85 8A",
            ),
            (
                &["assign-id", "--from", "1", "--to", "5"],
                "025#05",
                "01 85 85 8B",
            ),
            (
                &["origin", "--drive", "1", "--in-drive"],
                "020#AB",
                "01 80 80 81",
            ),
            (&["reset", "--drive", "1"], "03B#FE", ""),
            (&["probe", "--drive", "1"], "02B#1001", ""),
        ] {
            let dry = [arguments, &["--dry-run"]].concat();
            let (status, text, errors) = on(&bench, &dry);
            assert_eq!(status, Some(0), "{errors}");
            assert!(text.contains(on_can), "{text}");
            let frames = json_of(on(&bench, &[&dry[..], &["--json"]].concat()));
            assert_eq!(frames["dry_run"], true);
            let has = |hex: &str| {
                let mut frames = frames["frames"].as_array().expect("a list").iter();
                frames.any(|frame| frame["hex"] == hex && frame["words"] != "")
            };
            assert!(has(on_can), "{frames}");
            let (status, text, errors) = serial(&bench, &dry);
            // The serial protocol has neither reset nor probe.
            let expected = if on_line.is_empty() { 2 } else { 0 };
            assert_eq!(status, Some(expected), "{errors}");
            assert!(text.contains(on_line), "{text}");
        }
        assert!(!Path::new("other.toml").exists());
        let report = bench.stop();
        assert_eq!(report["frames_from_host"], 0, "{report}");
        assert_eq!(report["drives"][0]["serial_requests"], 0, "{report}");
    });
}

#[test]
fn settings_go_over_the_serial_port_too() {
    undisturbed(|| {
        let bench = BenchProcess::start_with_serial("serial-settings", "1,2", &[]);
        let file = Backup::new("serial-settings");
        let drives = ["--drives", "1,2"];
        let (status, _, errors) = serial(&bench, &[&["backup", file.path()], &drives[..]].concat());
        assert_eq!(status, Some(0), "{errors}");
        file.edit(&[
            ("speed-gain = 20", "speed-gain = 99"),
            ("max-speed = 60", "max-speed = 7"),
        ]);
        let restore = ["restore", file.path(), "--yes", "--json"];
        // The servo of a drive is on after power-on.
        let (status, _, errors) = serial(&bench, &restore);
        assert_eq!(status, Some(1), "{errors}");
        assert!(
            errors.contains("drive 2: expected a disabled drive"),
            "{errors}"
        );
        // Over CAN the revision must be known.
        let (status, _, errors) = on(&bench, &restore);
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("does not tell its revision"), "{errors}");
        bench.disable("1,2");
        let outcome = json_of(serial(&bench, &restore));
        assert_eq!(
            outcome["drives"][0]["changes"],
            json!([
                change("speed-gain", 20, 99, "written"),
                change("max-speed", 60, 7, "written"),
            ])
        );
        assert_eq!(value(&bench, "1", "speed-gain"), Some(99));
        // Two 7-bit bytes end at 16383: known before anything is sent.
        file.edit(&[
            ("gear-number = 4096", "gear-number = 16384"),
            ("main-gain = 20", "main-gain = 1"),
        ]);
        let (status, _, errors) = serial(&bench, &restore);
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("16384"), "{errors}");
        assert_eq!(eeprom_writes(&bench.stop()), [Some(2), Some(0)]);
    });
}

#[test]
fn what_does_more_than_its_name_says_is_confirmed_on_its_own() {
    undisturbed(|| {
        let bench = BenchProcess::start("restore-effects", "1");
        let file = backed_up("restore-effects", &bench, "1");
        let original = file.text();
        let restore = |options: &[&str]| {
            let start = ["restore", file.path(), "--yes"];
            on(&bench, &[&start[..], options].concat())
        };
        for (from, to, option) in [
            ("config = 0x00", "config = 0x04", "--allow-absolute-mode"),
            (
                "on-position-range = 20",
                "on-position-range = 127",
                "--allow-brake-output",
            ),
        ] {
            std::fs::write(file.path(), &original).expect("the file");
            file.edit(&[(from, to)]);
            let (status, _, errors) = restore(&[]);
            assert_eq!(status, Some(2), "{errors}");
            assert!(errors.contains(option), "{errors}");
            let (status, _, errors) = restore(&[option]);
            assert_eq!(status, Some(0), "{errors}");
        }
        // A drive that its configuration keeps free is switched on by another configuration.
        json_of(on(
            &bench,
            &["write", "--drive", "1", "config=0x20", "--yes", "--json"],
        ));
        std::fs::write(file.path(), &original).expect("the file");
        file.edit(&[("main-gain = 20", "main-gain = 21")]);
        let (status, _, errors) = restore(&["--allow-absolute-mode", "--allow-brake-output"]);
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("--allow-servo-on"), "{errors}");
        let outcome = json_of(restore(&["--allow-servo-on", "--json"]));
        // Where the drive has power nothing else is written.
        assert_eq!(
            outcome["drives"][0]["changes"],
            json!([
                change("main-gain", 20, 21, "written"),
                change("on-position-range", 127, 20, "written"),
                change("config", 0x20, 0, "written"),
            ])
        );
        let report = bench.stop();
        assert_eq!(report["drives"][0]["enabled"], true);
        assert_eq!(report["drives"][0]["position_counts"], 0);
    });
}

/// Starts a restore of three values and waits until the first is in the drive.
fn half_way(bench: &BenchProcess, file: &Backup) -> std::process::Child {
    file.edit(&[
        ("main-gain = 20", "main-gain = 31"),
        ("speed-gain = 20", "speed-gain = 32"),
        ("integration-gain = 10", "integration-gain = 33"),
    ]);
    let arguments = [
        "restore",
        file.path(),
        "--slcan",
        bench.path(),
        "--yes",
        "--json",
    ];
    start_and_wait_for(motionctl(&arguments), "main-gain = 31 is in the drive")
}

/// The end of a restore that failed: exit status, results in their order, errors.
fn end_of(mut child: std::process::Child) -> (Option<i32>, Vec<String>, String) {
    let mut errors = String::new();
    let stream = child.stderr.as_mut().expect("it is piped");
    stream.read_to_string(&mut errors).expect("its errors");
    let output = child.wait_with_output().expect("its output");
    let outcome: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(outcome["complete"], false);
    let changes = outcome["drives"][0]["changes"].as_array().expect("a list");
    let result = |change: &Value| change["result"].as_str().expect("a word").to_owned();
    (
        output.status.code(),
        changes.iter().map(result).collect(),
        errors,
    )
}

#[test]
fn an_adapter_that_is_lost_half_way_is_said_with_what_was_written() {
    undisturbed(|| {
        let mut bench = BenchProcess::start("restore-lost", "1");
        let file = backed_up("restore-lost", &bench, "1");
        let child = half_way(&bench, &file);
        bench.kill();
        let (status, results, errors) = end_of(child);
        assert_eq!(status, Some(4), "{errors}");
        // The second was under way.
        assert_eq!(results, ["written", "unknown", "not-written"]);
        assert!(errors.contains("the link failed"), "{errors}");
        assert!(errors.contains("NOT complete"), "{errors}");
    });
}

#[test]
fn a_restore_that_is_stopped_says_what_was_written() {
    undisturbed(|| {
        let bench = BenchProcess::start("restore-stop", "1");
        let file = backed_up("restore-stop", &bench, "1");
        let child = half_way(&bench, &file);
        interrupt(&child);
        let (status, results, errors) = end_of(child);
        assert_eq!(status, Some(4), "{errors}");
        // One that was under way is ended.
        let written = results.iter().filter(|result| *result == "written").count();
        assert!((1..=2).contains(&written), "{results:?}");
        assert!(
            results[written..]
                .iter()
                .all(|result| result == "not-written"),
            "{results:?}"
        );
        assert!(errors.contains("stopped by the user"), "{errors}");
        assert_eq!(eeprom_writes(&bench.stop()), [Some(written as u64)]);
    });
}

#[test]
fn a_drive_that_does_not_store_is_said_with_what_was_written() {
    undisturbed(|| {
        for (takes, status, results) in [
            ("1", 4, ["written", "not-taken", "not-written"]),
            ("0", 1, ["not-taken", "not-written", "not-written"]),
        ] {
            let options = ["--ignore-settings-after", takes];
            let bench = BenchProcess::start_with("restore-stubborn", "1", &options);
            let file = backed_up("restore-stubborn", &bench, "1");
            file.edit(&[
                ("main-gain = 20", "main-gain = 31"),
                ("speed-gain = 20", "speed-gain = 32"),
                ("gear-number = 4096", "gear-number = 8192"),
            ]);
            let (ended, text, errors) = on(&bench, &["restore", file.path(), "--yes", "--json"]);
            assert_eq!(ended, Some(status), "{errors}");
            let outcome: Value = serde_json::from_str(&text).expect("JSON");
            let changes = outcome["drives"][0]["changes"].as_array().expect("a list");
            let actual: Vec<_> = changes
                .iter()
                .map(|change| change["result"].as_str())
                .collect();
            assert_eq!(actual, results.map(Some));
            assert!(errors.contains("it reads back 20"), "{errors}");
            assert_eq!(eeprom_writes(&bench.stop()), [takes.parse().ok()]);
        }
    });
}
