//! What `restore` refuses, with nothing written anywhere.

use serde_json::Value;

use crate::bench::BenchProcess;
use crate::settings::{Backup, backed_up, eeprom_writes, on};
use crate::undisturbed::undisturbed;

#[test]
fn nothing_is_written_when_one_drive_refuses() {
    undisturbed(|| {
        let options = ["--alarm", "3", "--twin", "4"];
        let bench = BenchProcess::start_with("refusals-restore", "1-5", &options);
        let file = backed_up("refusals-restore", &bench, "1,5");
        let text = file.text();
        let start = text.find("[[drive]]").expect("a drive");
        let (head, drives) = text.split_at(start);
        let one = drives.split_once("\n\n").expect("two drives").0;
        let one = one.replacen("main-gain = 20", "main-gain = 44", 1);
        let with_id = |id: u8| one.replacen("id = 1", &format!("id = {id}"), 1);
        let mut all = head.to_owned();
        for id in [1, 2, 3, 4, 6] {
            all += &format!("{}\n\n", with_id(id));
        }
        all += &with_id(5).replacen("1.6A", "1.2A", 1);
        std::fs::write(file.path(), &all).expect("the file");
        let restore = ["restore", file.path(), "--yes"];
        let (status, _, errors) = on(&bench, &restore);
        assert_eq!(status, Some(1), "{errors}");
        for words in [
            "nothing was written to any drive",
            "drive 2: expected a disabled drive, it is enabled: `motionctl disable` first",
            "drive 3: expected no alarm, it has one: over-current",
            "more than one drive answers as drive 4",
            "drive 6 does not answer",
            "drive 5: expected revision 1.2A, as in the file, it is of revision 1.6A",
        ] {
            assert!(errors.contains(words), "{words}: {errors}");
        }
        assert!(!errors.contains("drive 1"), "{errors}");
        // Each of them alone refuses for all.
        for bad in ["2", "3", "4", "5", "6"] {
            let ids = format!("1,{bad}");
            let (status, _, errors) = on(&bench, &[&restore[..], &["--drives", &ids]].concat());
            assert_eq!(status, Some(1), "{bad}: {errors}");
        }
        let report = bench.stop();
        assert_eq!(eeprom_writes(&report), [Some(0); 6], "{report}");
        let disabled = &report["drives"][1]["enabled"];
        assert_eq!(disabled, &Value::Bool(true));
    });
}

#[test]
fn a_wrong_file_is_refused_before_anything_is_sent() {
    undisturbed(|| {
        let source = BenchProcess::start("wrong-source", "1");
        let good = backed_up("wrong-source", &source, "1");
        drop(source);
        let bench = BenchProcess::start("wrong-file", "1");
        let file = Backup::new("wrong-file");
        let text = good.text();
        let line_of = |key: &str| {
            let line = text.lines().position(|line| line.starts_with(key));
            line.expect("the key") + 1
        };
        let restore = |options: &[&str]| {
            let start = ["restore", file.path(), "--yes"];
            on(&bench, &[&start[..], options].concat())
        };
        let place = |key: &str, column: usize| {
            format!("wrong-file.toml: line {}, column {column}:", line_of(key))
        };
        for (from, to, place, words) in [
            (
                "main-gain = 20",
                "main-gain = 200",
                place("main-gain", 13),
                "from 1 to 127, got 200",
            ),
            (
                "main-gain = 20",
                "main-gian = 20",
                place("main-gain", 1),
                "\"main-gian\"",
            ),
            (
                "max-speed = 60",
                "",
                place("[[drive]]", 1),
                "got nothing; add it",
            ),
            ("id = 1", "id = 64", place("id", 6), "got 64"),
            (
                "format = 1",
                "format = 2",
                place("format", 10),
                "got format = 2",
            ),
            ("[[drive]]", "[[drive", place("[[drive]]", 8), "TOML"),
        ] {
            assert!(text.contains(from), "{from}");
            std::fs::write(file.path(), text.replacen(from, to, 1)).expect("the file");
            let (status, _, errors) = restore(&[]);
            assert_eq!(status, Some(2), "{to}: {errors}");
            assert!(errors.contains(&place), "{place} {errors}");
            assert!(errors.contains(words), "{words} {errors}");
        }
        std::fs::write(file.path(), &text).expect("the file");
        let (status, _, errors) = restore(&["--drives", "2"]);
        assert_eq!(status, Some(2), "{errors}");
        assert!(
            errors.contains("has no drive 2: expected one of 1"),
            "{errors}"
        );
        // A fresh drive has no address on CAN, and a file may be anything.
        std::fs::write(file.path(), text.replacen("id = 1", "id = 0", 1)).expect("the file");
        let (status, _, errors) = restore(&[]);
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("0 is every drive on CAN"), "{errors}");
        std::fs::write(file.path(), b"format = 1\n\xFF").expect("the file");
        let (status, _, errors) = restore(&[]);
        assert_eq!(status, Some(2), "{errors}");
        assert!(
            errors.contains("line 2, column 1: expected UTF-8, got byte 0xFF"),
            "{errors}"
        );
        for no_file in ["/dev/zero", "/no/such/file.toml"] {
            let (status, _, errors) = on(&bench, &["restore", no_file, "--yes"]);
            assert_eq!(status, Some(2), "{errors}");
            assert!(errors.contains("cannot read"), "{errors}");
        }
        let report = bench.stop();
        assert_eq!(report["frames_from_host"], 0, "{report}");
    });
}

#[test]
fn a_line_number_is_not_removed_by_guessing() {
    undisturbed(|| {
        let bench = BenchProcess::start("line-number", "1");
        let file = backed_up("line-number", &bench, "1");
        file.edit(&[("line-number = 0", "line-number = 2500")]);
        let restore = ["restore", file.path(), "--yes"];
        let (status, text, errors) = on(&bench, &restore);
        assert_eq!(status, Some(0), "{errors}");
        assert!(text.contains("line-number = 2500  written"), "{text}");
        file.edit(&[("line-number = 2500", "line-number = 0")]);
        let (status, _, errors) = on(&bench, &restore);
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("no command removes one"), "{errors}");
        assert_eq!(eeprom_writes(&bench.stop()), [Some(1)]);
    });
}
