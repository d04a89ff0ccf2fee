//! `assign-id`, `origin`, `reset` and `probe` against a bench.

use std::time::Duration;

use rustix::process::Signal;
use serde_json::json;

use crate::bench::BenchProcess;
use crate::settings::{eeprom_writes, json_of, on, run, serial};
use crate::undisturbed::undisturbed;

const ASSIGN: [&str; 6] = ["assign-id", "--from", "0", "--to", "5", "--yes"];

fn power_cycle(bench: &BenchProcess) {
    bench.signal(Signal::USR1);
    std::thread::sleep(Duration::from_millis(500));
}

#[test]
fn a_lone_fresh_drive_gets_its_id_as_its_revision_says() {
    undisturbed(|| {
        let bench = BenchProcess::start_with("fresh-1.6A", "", &["--fresh"]);
        let (status, _, errors) = on(&bench, &ASSIGN[..5]);
        assert_eq!(status, Some(2), "{errors}");
        let end = json_of(on(&bench, &[&ASSIGN[..], &["--json"]].concat()));
        assert_eq!(
            end,
            json!({ "from": 0, "to": 5, "active": 0, "needs_power_cycle": true, "revision": "1.6A" })
        );
        assert_eq!(on(&bench, &["scan"]).0, Some(1));
        power_cycle(&bench);
        let found = json_of(on(&bench, &["scan", "--json"]));
        assert_eq!(found["drives"][0]["drive"], 5);
        let (status, _, errors) = on(&bench, &ASSIGN);
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("id 5 is in use"), "{errors}");
        assert_eq!(eeprom_writes(&bench.stop()), [Some(1)]);

        let bench = BenchProcess::start_with("fresh-1.2A", "", &["--fresh", "--revision", "1.2A"]);
        let (status, text, errors) = on(&bench, &ASSIGN);
        assert_eq!(status, Some(0), "{errors}");
        assert_eq!(text, "the drive has id 5 now, and answers under it\n");
        let readings = json_of(on(&bench, &["read", "--drive", "5", "--json"]));
        assert_eq!(readings["protocol"], "CAN 1.2A");
    });
}

#[test]
fn an_id_is_not_given_where_another_drive_would_take_it() {
    undisturbed(|| {
        for (drives, options, words) in [
            (
                "",
                &["--fresh", "2"][..],
                "more than one drive answers as drive 0",
            ),
            ("7", &["--fresh"], "drive 7 is there too"),
            ("5", &["--fresh"], "id 5 is in use"),
            ("63", &[], "drive 63 is there too"),
        ] {
            let bench = BenchProcess::start_with("in-the-way", drives, options);
            let (status, _, errors) = on(&bench, &ASSIGN);
            assert_eq!(status, Some(1), "{errors}");
            assert!(errors.contains(words), "{errors}");
            assert!(errors.contains("nothing was changed"), "{errors}");
            let report = bench.stop();
            assert!(
                eeprom_writes(&report)
                    .iter()
                    .all(|writes| *writes == Some(0)),
                "{report}"
            );
        }
        let bench = BenchProcess::start_with("rename", "1,2,4", &["--twin", "4"]);
        let rename = |from, to| on(&bench, &["assign-id", "--from", from, "--to", to, "--yes"]);
        for (from, to, status, words) in [
            ("1", "2", 1, "id 2 is in use"),
            ("4", "9", 1, "more than one drive answers as drive 4"),
            ("8", "9", 1, "drive 8 does not answer"),
            ("1", "1", 2, "nothing to do"),
            ("1", "64", 2, "must be 1..=63, got 64"),
            ("1", "0", 2, "must be 1..=63, got 0"),
            ("-1", "3", 2, "error"),
        ] {
            let (ended, _, errors) = rename(from, to);
            assert_eq!(ended, Some(status), "{errors}");
            assert!(errors.contains(words), "{errors}");
        }
        let (status, text, errors) = rename("1", "9");
        assert_eq!(status, Some(0), "{errors}");
        assert!(
            text.contains("has id 1 until its power is switched off and on"),
            "{text}"
        );
        assert_eq!(
            eeprom_writes(&bench.stop()),
            [Some(1), Some(0), Some(0), Some(0)]
        );
    });
}

#[test]
fn a_drive_that_ignores_its_id_is_not_taken_for_one_that_has_it() {
    undisturbed(|| {
        let options = [
            "--fresh",
            "--revision",
            "1.2A",
            "--ignore-settings-after",
            "0",
        ];
        let bench = BenchProcess::start_with("ignores-id", "", &options);
        let (status, _, errors) = on(&bench, &ASSIGN);
        assert_eq!(status, Some(1), "{errors}");
        assert!(
            errors.contains("confirms it neither as drive 5"),
            "{errors}"
        );
        assert_eq!(eeprom_writes(&bench.stop()), [Some(0)]);
    });
}

#[test]
fn an_id_goes_over_the_serial_port_to_a_drive_alone_on_its_line() {
    undisturbed(|| {
        let bench = BenchProcess::start_with_serial("serial-id", "", &["--fresh"]);
        let (status, text, errors) = serial(&bench, &ASSIGN);
        assert_eq!(status, Some(0), "{errors}");
        assert!(
            text.contains("has id 0 until its power is switched off and on"),
            "{text}"
        );
        power_cycle(&bench);
        let readings = json_of(serial(&bench, &["read", "--drive", "5", "--json"]));
        assert_eq!(readings["drive"], 5);
        assert_eq!(eeprom_writes(&bench.stop()), [Some(1)]);

        let bench = BenchProcess::start_with_serial("serial-id-2", "7", &["--fresh"]);
        let (status, _, errors) = serial(&bench, &ASSIGN);
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("drive 7 is there too"), "{errors}");
        assert_eq!(eeprom_writes(&bench.stop()), [Some(0), Some(0)]);

        let bench = BenchProcess::start_with_serial("serial-id-3", "", &["--fresh", "2"]);
        let (status, _, errors) = serial(&bench, &ASSIGN);
        assert_eq!(status, Some(1), "{errors}");
        assert!(
            errors.contains("more than one drive answers as drive 0"),
            "{errors}"
        );
        assert_eq!(eeprom_writes(&bench.stop()), [Some(0), Some(0)]);
    });
}

#[test]
fn an_origin_is_where_the_drive_stands_and_is_stored_on_request_only() {
    undisturbed(|| {
        for (turns, counts) in [("0.25", 4_096), ("-0.25", -4_096)] {
            let bench = BenchProcess::start_with_serial("origin", "1", &[]);
            let jog = [
                "jog", "--drive", "1", "--turns", turns, "--rpm", "100", "--yes",
            ];
            assert_eq!(on(&bench, &jog).0, Some(0));
            let origin = ["origin", "--drive", "1", "--json"];
            for end in [
                json_of(on(&bench, &origin)),
                json_of(serial(&bench, &origin)),
            ] {
                assert_eq!(end["software_origin_counts"], counts);
                assert_eq!(
                    (&end["in_drive"], &end["eeprom_writes"]),
                    (&json!(false), &json!(0))
                );
            }
            let in_drive = [&origin[..], &["--in-drive", "--yes"]].concat();
            let (status, _, errors) = on(&bench, &in_drive);
            assert_eq!(status, Some(2), "{errors}");
            assert!(errors.contains("drive 1 is enabled"), "{errors}");
            bench.disable("1");
            let (status, _, errors) = on(&bench, &[&origin[..], &["--in-drive"]].concat());
            assert_eq!(status, Some(2), "{errors}");
            let end = json_of(on(&bench, &in_drive));
            assert_eq!(
                end,
                json!({ "drive": 1, "software_origin_counts": 0, "before_counts": counts, "in_drive": true, "eeprom_writes": 1 })
            );
            assert_eq!(eeprom_writes(&bench.stop()), [Some(1)]);
        }
        let options = ["--ignore-settings-after", "0", "--twin", "2"];
        let bench = BenchProcess::start_with_serial("origin-ignored", "1,2", &options);
        let jog = [
            "jog", "--drive", "1", "--turns", "0.25", "--rpm", "100", "--yes",
        ];
        assert_eq!(on(&bench, &jog).0, Some(0));
        bench.disable("1");
        let in_drive = ["origin", "--drive", "1", "--in-drive", "--yes"];
        for link in [["--slcan", bench.path()], ["--serial", bench.serial_path()]] {
            let (status, _, errors) = run(link, &in_drive);
            assert_eq!(status, Some(1), "{errors}");
            assert!(
                errors.contains("it reports 4096 counts: it has not taken"),
                "{errors}"
            );
        }
        for (drive, words) in [("2", "more than one drive"), ("9", "does not answer")] {
            let (status, _, errors) = on(&bench, &["origin", "--drive", drive]);
            assert_eq!(status, Some(1), "{errors}");
            assert!(errors.contains(words), "{errors}");
        }
    });
}

#[test]
fn a_reset_clears_an_alarm_and_leaves_the_drive_off() {
    undisturbed(|| {
        let bench = BenchProcess::start_with_serial("reset", "1,2", &["--alarm", "1"]);
        let reset = |drive| ["reset", "--drive", drive, "--yes", "--json"];
        let end = json_of(on(&bench, &reset("1")));
        assert_eq!(end["alarm_before"], "over-current");
        assert_eq!(end["alarm_after"], json!(null));
        assert_eq!(end["was_switched_on"], true);
        let readings = json_of(on(&bench, &["read", "--drive", "1", "--json"]));
        assert_eq!(readings["state"]["enabled"], false);
        assert_eq!(readings["state"]["alarm"], json!(null));
        for (arguments, status, words) in [
            (&reset("2")[..], 2, "drive 2 is enabled"),
            (&reset("9"), 1, "drive 9 does not answer"),
            (&["reset", "--drive", "1"], 2, "needs a confirmation"),
            (
                &["reset", "--drive", "0", "--yes"],
                2,
                "0 is every drive on CAN",
            ),
        ] {
            let (ended, _, errors) = on(&bench, arguments);
            assert_eq!(ended, Some(status), "{errors}");
            assert!(errors.contains(words), "{errors}");
        }
        let (status, _, errors) = serial(&bench, &reset("1"));
        assert_eq!(status, Some(2), "{errors}");
        assert!(
            errors.contains("the serial protocol has no reset"),
            "{errors}"
        );
        let report = bench.stop();
        assert_eq!(report["drives"][0]["enabled"], false, "{report}");
        assert_eq!(report["drives"][1]["enabled"], true, "{report}");

        let old = ["--alarm", "1", "--revision", "1.2A"];
        let bench = BenchProcess::start_with("reset-old", "1", &old);
        let (status, _, errors) = on(&bench, &reset("1"));
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("revision 1.2A has no reset"), "{errors}");
        let report = bench.stop();
        assert_eq!(report["drives"][0]["alarm"], "over-current", "{report}");
    });
}

#[test]
fn a_probe_tells_the_orders_and_moves_nothing() {
    undisturbed(|| {
        let options = ["--revision", "1.2A", "--alarm", "3", "--twin", "4"];
        let bench = BenchProcess::start_with_serial("probe", "1-4", &options);
        let probe = |drive| ["probe", "--drive", drive, "--yes"];
        for (drive, status, words) in [
            ("1", 2, "drive 1 is enabled"),
            ("3", 1, "alarm, over-current"),
            ("4", 1, "more than one drive answers as drive 4"),
            ("9", 1, "drive 9 does not answer"),
        ] {
            let (ended, _, errors) = on(&bench, &probe(drive));
            assert_eq!(ended, Some(status), "{errors}");
            assert!(errors.contains(words), "{errors}");
        }
        bench.disable("1");
        let end = json_of(on(&bench, &[&probe("1")[..], &["--json"]].concat()));
        assert_eq!(end["numbers"], "msb-first");
        assert_eq!(end["group3"], "msb-first");
        assert_eq!(end["group3_lsb_first"], json!(null));
        // 4104 is 1008h, and 2064 the other way round: other commands refuse such a drive.
        let gear = ["write", "--drive", "1", "gear-number=4104", "--yes"];
        assert_eq!(serial(&bench, &gear).0, Some(0));
        assert_eq!(on(&bench, &["read", "--drive", "1"]).0, Some(1));
        let (status, text, errors) = on(&bench, &probe("1"));
        assert_eq!(status, Some(0), "{errors}");
        assert!(
            text.contains("4104 with msb-first and 2064 with lsb-first"),
            "{text}"
        );
        let (status, _, errors) = serial(&bench, &probe("1"));
        assert_eq!(status, Some(2), "{errors}");
        let report = bench.stop();
        let drive = &report["drives"][0];
        assert_eq!(
            (&drive["enabled"], &drive["position_counts"]),
            (&json!(false), &json!(0))
        );
        // 4097 in each of the two probes.
        assert_eq!(drive["data_errors"], 2, "{drive}");
    });
}
