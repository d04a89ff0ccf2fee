//! `motionctl run` against `motionctl bench` as users run them, and what happens when the bus is not what it should be.

use crate::bench::{
    BenchProcess, Scratch, interrupt, motionctl, scratch, start_and_wait_for, status_and_errors,
};
use crate::undisturbed::undisturbed;
use std::time::Duration;

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use serde_json::Value;

/// Two axes, one turn and half a turn back, in half a second.
const SHORT: &str = "time_s,a,b\n0,0,0\n0.25,180,-90\n0.5,360,-180\n";
/// Two axes that go on for a minute.
const LONG: &str = "time_s,a,b\n0,0,0\n60,36000,-36000\n";

fn run(arguments: &[&str]) -> std::process::Output {
    motionctl(&[&["run"], arguments].concat())
        .output()
        .expect("motionctl runs")
}

fn numbers(list: &Value, field: &str) -> Vec<i64> {
    let entries = list.as_array().expect("a list");
    let number = |entry: &Value| entry[field].as_i64().expect("a number");
    entries.iter().map(number).collect()
}

#[test]
fn both_sides_have_the_same_sums_and_the_time_is_accounted_for() {
    undisturbed(|| {
        let bench = BenchProcess::start("sums", "1-3");
        // Drive 1 is off before, drive 3 is on.
        bench.disable("1");
        let file = Scratch::new("sums.csv", SHORT);
        // The axes are not in the order of their drives, and drive 2 is left alone.
        let output = run(&[
            "--slcan",
            bench.path(),
            "--trajectory",
            file.path(),
            "--drives",
            "3,1",
            "--yes",
            "--json",
        ]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(summary["completed"], true);
        for sums in ["target_counts", "sent_counts", "read_counts"] {
            assert_eq!(numbers(&summary["axes"], sums), [16_384, -8_192], "{sums}");
        }
        let report = bench.stop();
        assert_eq!(
            numbers(&report["drives"], "received_counts"),
            [-8_192, 0, 16_384]
        );
        assert_eq!(
            numbers(&report["drives"], "position_counts"),
            [-8_192, 0, 16_384]
        );
        let enabled: Vec<_> = (0..3)
            .map(|drive| report["drives"][drive]["enabled"].as_bool())
            .collect();
        // Each is as it was before.
        assert_eq!(enabled, [Some(false), Some(true), Some(true)]);
        assert_eq!(summary["disabled"], serde_json::json!([1]));
        assert_eq!(summary["left_enabled"], serde_json::json!([3]));
        let sent = numbers(&summary["axes"], "set_points");
        let received = numbers(&report["drives"], "set_points");
        assert_eq!((sent[0], sent[1]), (received[2], received[0]));
        let pace = |field: &str| summary["pace"][field].as_u64().expect("a count");
        // Half a second of motion and half a second of rest, whatever the machine did meanwhile.
        assert!(pace("cycles") + pace("merged") >= 1_000, "{summary}");
        assert!(pace("late") <= pace("cycles"));
    });
}

#[test]
fn ctrl_c_ramps_down_and_disables() {
    undisturbed(|| {
        let bench = BenchProcess::start("interrupt", "1,2");
        bench.disable("1,2");
        let file = Scratch::new("interrupt.csv", LONG);
        let arguments = [
            "run",
            "--slcan",
            bench.path(),
            "--trajectory",
            file.path(),
            "--max-turns",
            "100",
            "--yes",
            "--json",
        ];
        // As JSON the motion begins without a word, within a second.
        let child = motionctl(&arguments).spawn().expect("motionctl starts");
        std::thread::sleep(Duration::from_secs(3));
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(130), "{output:?}");
        let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(summary["outcome"], "stopped by the user", "{summary}");
        assert_eq!(summary["disabled"], serde_json::json!([1, 2]), "{summary}");
        let report = bench.stop();
        for (axis, drive) in report["drives"]
            .as_array()
            .expect("a list")
            .iter()
            .enumerate()
        {
            // The steps of the ramp are among them.
            assert_eq!(
                summary["axes"][axis]["sent_counts"], drive["received_counts"],
                "{summary} {report}"
            );
            assert_eq!(drive["enabled"], false);
            assert_ne!(drive["received_counts"], 0, "it had moved");
            let count = |field: &str| drive[field].as_i64().expect("a count");
            // A motor that is let go at the end of its ramp may coast by a count or two.
            let coasted = count("received_counts") - count("position_counts");
            assert!(coasted.abs() <= 16, "{drive}");
            assert_eq!(drive["alarm"], Value::Null);
        }
    });
}

#[test]
fn an_adapter_that_vanishes_ends_the_motion_with_a_clear_message() {
    undisturbed(|| {
        let mut bench = BenchProcess::start("vanish", "1,2");
        let file = Scratch::new("vanish.csv", LONG);
        let arguments = [
            "run",
            "--slcan",
            bench.path(),
            "--trajectory",
            file.path(),
            "--max-turns",
            "100",
            "--yes",
        ];
        let child = start_and_wait_for(motionctl(&arguments), "the motion starts");
        bench.kill();
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(3), "{output:?}");
        let (_, errors) = status_and_errors(&output);
        let text = String::from_utf8_lossy(&output.stdout);
        for text in [errors.as_str(), &text] {
            let said = "the link failed: the adapter is gone";
            assert!(text.contains(said), "{output:?}");
        }
        assert!(errors.contains("may still be ENABLED"), "{errors}");
    });
}

/// Finding 1: the motion would have ended while the adapter was frozen.
#[test]
fn an_adapter_that_froze_in_motion_does_not_complete_it() {
    undisturbed(|| {
        let bench = BenchProcess::start("freeze", "1,2");
        let file = Scratch::new("freeze.csv", "time_s,a,b\n0,0,0\n3,1800,-1800\n");
        let arguments = [
            "run",
            "--slcan",
            bench.path(),
            "--trajectory",
            file.path(),
            "--yes",
        ];
        let child = start_and_wait_for(motionctl(&arguments), "the motion starts");
        std::thread::sleep(Duration::from_millis(500));
        bench.freeze(true);
        std::thread::sleep(Duration::from_secs(8));
        bench.freeze(false);
        let output = child.wait_with_output().expect("its output");
        let text = String::from_utf8_lossy(&output.stdout);
        let report = bench.stop();
        assert_ne!(
            output.status.code(),
            Some(0),
            "nothing got through for 8 s in motion, and the tool says:\n{text}\nthe drives say: {}",
            report["drives"]
        );
    });
}

#[test]
fn a_busy_port_is_named() {
    undisturbed(|| {
        let bench = BenchProcess::start("busy", "1,2");
        let file = Scratch::new("busy.csv", SHORT);
        // What programs that share ports with care do.
        let other = std::fs::File::open(bench.path()).expect("the terminal");
        other.try_lock().expect("nobody else has it");
        let arguments = [
            "--slcan",
            bench.path(),
            "--trajectory",
            file.path(),
            "--yes",
        ];
        let (status, errors) = status_and_errors(&run(&arguments));
        assert_eq!(status, Some(3), "{errors}");
        assert!(errors.contains("in use by another program"), "{errors}");
        drop(other);
        assert_eq!(run(&arguments).status.code(), Some(0));
    });
}

#[test]
fn a_wrong_device_is_refused_before_anything_is_sent() {
    undisturbed(|| {
        let file = Scratch::new("wrong.csv", SHORT);
        let refused = |port: &str| {
            let output = run(&["--slcan", port, "--trajectory", file.path(), "--yes"]);
            let (status, errors) = status_and_errors(&output);
            assert_eq!(status, Some(3), "{port}: {errors}");
            assert!(output.stdout.is_empty(), "{output:?}");
            errors
        };
        assert!(refused("/dev/no-such-port").contains("there is no port /dev/no-such-port"));
        assert!(refused("/dev/null").contains("cannot be used as a serial port"));
        assert!(refused(file.path()).contains("cannot be used as a serial port"));
        // A terminal behind which nobody is.
        let device = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).expect("a pseudo-terminal");
        grantpt(&device).expect("granted");
        unlockpt(&device).expect("unlocked");
        let name = ptsname(&device, Vec::new()).expect("a name");
        let silent = refused(name.to_str().expect("plain text"));
        assert!(
            silent.contains("no Lawicel (slcan) adapter answers"),
            "{silent}"
        );
        assert!(silent.contains("stayed silent"), "{silent}");
    });
}

#[test]
fn an_interface_that_is_not_there_is_refused() {
    undisturbed(|| {
        for command in [
            ["run", "--can", "no-such-can", "--yes"].as_slice(),
            &["scan", "--can", "no-such-can"],
            &["decode", "--can", "no-such-can"],
        ] {
            let output = motionctl(command).output().expect("motionctl runs");
            let (status, errors) = status_and_errors(&output);
            assert_eq!(status, Some(3), "{command:?}: {errors}");
            // Asking for an interface loads the modules where there are any, so the kernel is looked at afterwards.
            let expected = if cfg!(not(target_os = "linux")) {
                "only Linux has CAN network interfaces"
            } else if std::path::Path::new("/proc/net/can").exists() {
                "there is no CAN interface no-such-can"
            } else {
                "this kernel has no CAN support"
            };
            assert!(errors.contains(expected), "{command:?}: {errors}");
        }
    });
}

#[test]
fn nothing_moves_without_a_confirmation() {
    undisturbed(|| {
        let bench = BenchProcess::start("confirm", "1,2");
        let file = Scratch::new("confirm.csv", SHORT);
        let output = run(&["--slcan", bench.path(), "--trajectory", file.path()]);
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("needs a confirmation"), "{errors}");
        assert_eq!(bench.stop()["frames_from_host"], 0);
    });
}

#[test]
fn a_drive_that_is_not_there_stops_all_and_leaves_the_others_as_they_were() {
    undisturbed(|| {
        let bench = BenchProcess::start("missing", "1");
        let file = Scratch::new("missing.csv", SHORT);
        let output = run(&[
            "--slcan",
            bench.path(),
            "--trajectory",
            file.path(),
            "--yes",
            "--json",
        ]);
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(1), "{output:?}");
        assert!(
            errors.contains("drive 2: the drive does not answer"),
            "{errors}"
        );
        assert!(errors.contains("Nothing was switched"), "{errors}");
        let report = bench.stop();
        // As it was.
        assert_eq!(report["drives"][0]["enabled"], true);
        assert_eq!(report["drives"][0]["set_points"], 0);
    });
}

#[test]
fn a_motor_that_cannot_follow_stops_all_and_leaves_nobody_enabled() {
    undisturbed(|| {
        let bench = BenchProcess::start("fast", "1,2");
        bench.disable("1,2");
        // 5500 rpm; the simulated motor ends at 3028 rpm.
        let file = Scratch::new("fast.csv", "time_s,a,b\n0,0,0\n0.2,6600,10\n");
        let motion = ["--trajectory", file.path(), "--yes"];
        let slow = [&["run"][..], &motion].concat();
        let (status, errors) = status_and_errors(&bench.run(&slow));
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("drive 1 needs a speed of"), "{errors}");
        assert!(errors.contains("allow it with --max-rpm"), "{errors}");
        let all = [
            "--max-rpm",
            "20000",
            "--max-acceleration",
            "1e6",
            "--max-turns",
            "20",
        ];
        let output = bench.run(&[&slow[..], &all].concat());
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(1), "{output:?}");
        // The drive's own alarm or the master's own limit, whichever comes first.
        let reasons = [
            "drive 1: alarm, lost phase",
            "counts off its set-points while moving",
        ];
        assert!(
            reasons.iter().any(|reason| errors.contains(reason)),
            "{errors}"
        );
        // The cause is told, and once.
        assert!(!errors.contains("another axis"), "{errors}");
        let report = bench.stop();
        assert_eq!(report["drives"][0]["enabled"], false);
        assert_eq!(report["drives"][1]["enabled"], false);
    });
}

#[test]
fn a_bench_does_not_overwrite_what_is_there() {
    undisturbed(|| {
        let file = Scratch::new("precious", "precious");
        let output = motionctl(&["bench", "--slcan", file.path()])
            .output()
            .expect("motionctl runs");
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(2), "{errors}");
        assert!(
            errors.contains("exists: choose a path that does not"),
            "{errors}"
        );
        assert_eq!(
            std::fs::read_to_string(scratch("precious")).expect("it is there"),
            "precious"
        );
    });
}
