//! The power of the drives after the tool has ended, whatever ended it: read from the drives of the bench.

use std::fs::OpenOptions;
use std::process::Child;
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};

use crate::bench::{BenchProcess, Scratch, motionctl, start_and_wait_for, status_and_errors};
use crate::undisturbed::undisturbed;

/// Two axes, one turn and half a turn back, in half a second.
const SHORT: &str = "time_s,a,b\n0,0,0\n0.25,180,-90\n0.5,360,-180\n";
/// Two axes that go on for a minute.
const LONG: &str = "time_s,a,b\n0,0,0\n60,36000,-36000\n";

/// Drive 1 is off, drive 2 is on, and so they shall be left.
fn one_off_one_on(name: &str) -> BenchProcess {
    let bench = BenchProcess::start(name, "1,2");
    bench.disable("1");
    bench
}

fn run<'a>(bench: &'a BenchProcess, file: &'a Scratch) -> Vec<&'a str> {
    vec![
        "run",
        "--slcan",
        bench.path(),
        "--trajectory",
        file.path(),
        "--max-turns",
        "100",
        "--yes",
    ]
}

/// Power and alarm of each drive, and whether it was moved.
fn drives(bench: BenchProcess) -> Vec<(bool, bool, bool)> {
    let report = bench.stop();
    let drives = report["drives"].as_array().expect("a list");
    let state = |drive: &serde_json::Value| {
        (
            drive["enabled"] == true,
            !drive["alarm"].is_null(),
            drive["received_counts"] != 0,
        )
    };
    drives.iter().map(state).collect()
}

fn ends(mut child: Child) -> Option<i32> {
    child.wait().expect("its end").code()
}

#[test]
fn closed_pipes_do_not_stop_the_tool_from_switching_off() {
    undisturbed(|| {
        let file = Scratch::new("pipe.csv", SHORT);
        for stage in ["at the start", "in the motion"] {
            let bench = one_off_one_on("pipe");
            let command = motionctl(&run(&bench, &file));
            let mut child = match stage {
                "at the start" => {
                    let mut command = command;
                    command.spawn().expect("motionctl starts")
                }
                _ => start_and_wait_for(command, "the motion starts"),
            };
            drop((child.stdout.take(), child.stderr.take()));
            assert_eq!(ends(child), Some(0), "{stage}");
            let left = [(false, false, true), (true, false, true)];
            assert_eq!(drives(bench), left, "{stage}");
        }
    });
}

#[test]
fn closed_pipes_do_not_stop_jog_and_enable_from_switching_off() {
    undisturbed(|| {
        let bench = one_off_one_on("pipe-jog");
        let jog = ["jog", "--drive", "1", "--turns", "0.25", "--yes"];
        let enable = ["enable", "--drives", "1,2", "--for", "1", "--yes"];
        for arguments in [&jog[..], &enable] {
            let link = ["--slcan", bench.path()];
            let mut child = motionctl(&[arguments, &link].concat())
                .spawn()
                .expect("motionctl starts");
            drop((child.stdout.take(), child.stderr.take()));
            assert_eq!(ends(child), Some(0), "{arguments:?}");
        }
        let left = [(false, false, true), (true, false, false)];
        assert_eq!(drives(bench), left);
    });
}

#[test]
fn a_full_disk_is_told_after_the_drives_are_off() {
    undisturbed(|| {
        let file = Scratch::new("full.csv", SHORT);
        let bench = one_off_one_on("full-disk");
        let full = OpenOptions::new().write(true).open("/dev/full");
        let output = motionctl(&run(&bench, &file))
            .stdout(full.expect("/dev/full"))
            .output()
            .expect("motionctl runs");
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("cannot write the summary"), "{errors}");
        let left = [(false, false, true), (true, false, true)];
        assert_eq!(drives(bench), left);
    });
}

#[test]
fn every_signal_in_every_stage_leaves_the_drives_as_they_were() {
    undisturbed(|| {
        let file = Scratch::new("signal.csv", LONG);
        for signal in [Signal::INT, Signal::TERM, Signal::HUP] {
            // The drives are read, enabled, moved.
            let stages = [
                ("limits:", 0),
                ("limits:", 300),
                ("limits:", 700),
                ("the motion starts", 0),
                ("the motion starts", 300),
            ];
            for (text, wait_ms) in stages {
                let bench = one_off_one_on("signal");
                let child = start_and_wait_for(motionctl(&run(&bench, &file)), text);
                std::thread::sleep(Duration::from_millis(wait_ms));
                kill_process(Pid::from_child(&child), signal).expect("the process is there");
                assert_eq!(
                    ends(child),
                    Some(130),
                    "{signal:?} {wait_ms} ms after {text}"
                );
                let power: Vec<_> = drives(bench)
                    .iter()
                    .map(|(on, alarm, _)| (*on, *alarm))
                    .collect();
                assert_eq!(
                    power,
                    [(false, false), (true, false)],
                    "{signal:?} {wait_ms} ms after {text}"
                );
            }
        }
    });
}

#[test]
fn a_frozen_adapter_is_an_error_that_names_the_drives() {
    undisturbed(|| {
        let file = Scratch::new("frozen.csv", LONG);
        let bench = one_off_one_on("frozen-bench");
        let child = start_and_wait_for(motionctl(&run(&bench, &file)), "the motion starts");
        std::thread::sleep(Duration::from_millis(300));
        bench.signal(Signal::STOP);
        let output = child.wait_with_output().expect("its output");
        bench.signal(Signal::CONT);
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(3), "{errors}");
        assert!(
            errors.contains("the bus or its adapter stands still"),
            "{errors}"
        );
        let text = String::from_utf8_lossy(&output.stdout);
        assert!(
            errors.contains("drive 1 did not confirm that it is DISABLED"),
            "{errors}"
        );
        assert!(text.contains("drive 2 was enabled before"), "{text}");
        assert!(!text.contains("completed"), "{text}");
        // As it was said.
        assert!(drives(bench)[0].0, "it is still on");
    });
}

#[test]
fn an_alarm_before_enabling_is_named_and_the_others_are_left_as_they_were() {
    undisturbed(|| {
        let bench = BenchProcess::start("alarm-before", "1-3");
        bench.disable("2");
        // Faster than the simulated motor can follow.
        let fast = Scratch::new("alarm-before.csv", "time_s,a\n0,0\n0.2,6600\n");
        let all = ["--max-rpm", "20000", "--max-acceleration", "1e6", "--yes"];
        let motion = ["run", "--trajectory", fast.path(), "--max-turns", "20"];
        let output = bench.run(&[&motion[..], &all].concat());
        assert_eq!(output.status.code(), Some(1), "{output:?}");

        let file = Scratch::new("alarm-after.csv", "time_s,a,b,c\n0,0,0,0\n1,90,90,90\n");
        let output = bench.run(&["run", "--trajectory", file.path(), "--yes"]);
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(1), "{errors}");
        assert!(errors.contains("drive 1: alarm, lost phase"), "{errors}");
        assert!(errors.contains("Nothing was switched"), "{errors}");
        let drives = drives(bench);
        assert!(drives[0].1, "it is still in alarm");
        assert_eq!(drives[1..], [(false, false, false), (true, false, false)]);
    });
}

#[test]
fn a_scale_of_another_gear_number_is_refused_and_the_right_one_told() {
    undisturbed(|| {
        let bench = BenchProcess::start("gear", "1,2");
        bench.disable("2");
        let write = ["write", "--drive", "2", "gear-number=8192", "--yes"];
        assert_eq!(bench.run(&write).status.code(), Some(0));
        let file = Scratch::new("gear.csv", SHORT);
        let motion = ["run", "--trajectory", file.path(), "--yes"];
        let (status, errors) = status_and_errors(&bench.run(&motion));
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("drive 2 has gear number 8192"), "{errors}");
        assert!(
            errors.contains("it would turn 0.500 times as far as meant"),
            "{errors}"
        );
        let fitting = "--counts-per-turn 16384,32768";
        assert!(errors.contains(fitting), "{errors}");
        let scale: Vec<_> = fitting.split(' ').collect();
        let output = bench.run(&[&motion[..], &scale].concat());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let report = bench.stop();
        // 180 degrees back, of a gear number that makes 32768 counts a turn; and nothing of the motion that was refused.
        assert_eq!(report["drives"][1]["received_counts"], -16_384);
        assert_eq!(report["drives"][0]["received_counts"], 16_384);
    });
}

#[test]
fn a_reader_that_has_enough_ends_a_monitor_without_a_word() {
    undisturbed(|| {
        let bench = one_off_one_on("head");
        let arguments = ["monitor", "--slcan", bench.path(), "--drives", "1,2"];
        let mut child = motionctl(&[&arguments[..], &["--every-ms", "50"]].concat())
            .spawn()
            .expect("motionctl starts");
        let mut first = [0; 1];
        let mut lines = child.stdout.take().expect("it is piped");
        std::io::Read::read_exact(&mut lines, &mut first).expect("a line");
        drop(lines);
        let output = child.wait_with_output().expect("its output");
        let (status, errors) = status_and_errors(&output);
        assert_eq!((status, errors.as_str()), (Some(0), ""));
        let left = [(false, false, false), (true, false, false)];
        assert_eq!(drives(bench), left);
    });
}
