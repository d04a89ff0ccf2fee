//! What a simulation leaves behind: page, table, log and MCAP file of the same motion, and what becomes of them on a full disk.

mod tool;

use std::process::{Command, Stdio};

use serde_json::Value;
use tool::page::Page;
use tool::screen::OnScreen;
use tool::{Folder, Scratch, motionctl, text};

/// Two axes, one turn and half a turn back, in 0.4 s.
const SHORT: &str = "time_s,x_deg,y_mm\n0,10,0\n0.2,180,-9\n0.4,370,-18\n";
const SCALE: [&str; 2] = ["--mm-per-turn", "-,36"];

fn sim(arguments: &[&str]) -> (Option<i32>, Value, String) {
    let output = motionctl(&[&["sim", "--json"], arguments].concat());
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    let json = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{output:?}"));
    (output.status.code(), json, errors)
}

/// Runs the short motion with everything recorded.
fn recorded(folder: &Folder, more: &[&str]) -> Value {
    std::fs::create_dir_all(&folder.0).expect("a folder");
    let motion = folder.file("motion.csv");
    std::fs::write(&motion, SHORT).expect("a file");
    let (log, mcap, csv) = (
        folder.file("run.log"),
        folder.file("run.mcap"),
        folder.file("run.csv"),
    );
    let files = [
        "--trajectory",
        &motion,
        "--candump",
        &log,
        "--mcap",
        &mcap,
        "--csv",
        &csv,
        "--report",
        folder.as_str(),
    ];
    let (status, json, errors) = sim(&[&SCALE, &files[..], more].concat());
    assert_eq!(status, Some(0), "{json} {errors}");
    json
}

/// The page that `decode` makes of a log.
fn page_of_log(log: &str, folder: &str) -> Page {
    let output = motionctl(&["decode", log, "--report", folder]);
    assert!(output.status.success(), "{output:?}");
    assert!(
        !text(&output.stdout).contains("step by"),
        "no frames are shown"
    );
    Page::in_folder(folder)
}

#[test]
fn the_page_of_a_simulation_and_that_of_its_log_show_the_same_positions() {
    for (name, more) in [
        ("same-1", &[][..]),
        (
            "same-2",
            &[
                "--cycle-us",
                "2000",
                "--position-hz",
                "200",
                "--drives",
                "9,4",
            ],
        ),
    ] {
        let folder = Folder::new(name);
        recorded(&folder, more);
        let page = Page::in_folder(folder.as_str());
        let of_log = page_of_log(&folder.file("run.log"), &folder.file("decoded"));
        let (start, _) = page.motion_start();
        // The log knows drives alone, in ascending order.
        let drive = |page: &Page, axis: usize| page.data()["axes"][axis]["drive"].as_i64();
        for axis in 0..2 {
            let same = (0..2).find(|&other| drive(&of_log, other) == drive(&page, axis));
            let same = same.expect("the same drive");
            let (sent, summed) = (page.sent(axis), of_log.sent(same));
            // Set-points are whole counts on both sides: no tolerance.
            let mut compared = 0;
            let shown = page.times_us.iter().zip(&sent).skip(start);
            for (&at_us, &counts) in shown {
                let there = of_log.sent_at(&summed, at_us);
                assert_eq!(there, Some(counts), "{at_us} us");
                compared += 1;
            }
            assert!(compared > 300, "{compared}");
            let begin_us = page.times_us[start - 1];
            let rows = of_log.times_us.iter().filter(|at| **at > begin_us).count();
            assert_eq!(rows, compared, "a row for each cycle of the motion");
            // A position was read at some moment of the cycles around: the motor was there between their ends.
            let motor = page.positions(axis);
            assert_eq!(
                motor.len(),
                sent.len(),
                "a simulation knows it in every cycle"
            );
            let read = of_log.positions(same);
            assert!(read.len() > 10, "{}", read.len());
            for (row, counts) in read {
                let place = page
                    .times_us
                    .partition_point(|at| *at < of_log.times_us[row]);
                let around = &motor[place.saturating_sub(2)..(place + 2).min(motor.len())];
                let around = around.iter().map(|(_, counts)| *counts);
                let (least, most) = (around.clone().min(), around.max());
                assert!(
                    least <= Some(counts) && Some(counts) <= most,
                    "{least:?} {counts} {most:?}"
                );
            }
        }
    }
}

#[test]
fn the_page_has_names_units_and_what_tells_the_run_from_others() {
    let folder = Folder::new("facts");
    let summary = recorded(&folder, &["--seed", "7"]);
    let page = Page::in_folder(folder.as_str());
    assert_eq!(page.axes(), ["x_deg", "y_mm"]);
    let axis = &page.data()["axes"][1];
    assert_eq!(
        (axis["unit"].as_str(), axis["drive"].as_i64()),
        (Some("mm"), Some(2))
    );
    // 16384 counts a turn of 36 mm.
    let counts = axis["countsPerUnit"].as_f64().expect("a scale");
    assert!((counts - 16_384.0 / 36.0).abs() < 1e-9);
    assert_eq!(page.data()["axes"][0]["start"], 10.0);
    let about = page.data()["about"].to_string();
    for wanted in [
        "motionctl sim --json",
        "--seed 7",
        env!("CARGO_PKG_VERSION"),
        "UTC",
        "[\"seed\",\"7\"]",
    ] {
        assert!(about.contains(wanted), "{wanted} in {about}");
    }
    let sums = |axis: usize| *page.sent(axis).last().expect("a cycle");
    assert_eq!([sums(0), sums(1)], [16_384, -8_192]);
    assert_eq!(summary["axes"][1]["sent_counts"], -8_192);
}

#[test]
fn the_mcap_file_has_every_cycle_and_frame_with_a_schema() {
    let folder = Folder::new("mcap");
    let summary = recorded(&folder, &[]);
    let bytes = std::fs::read(folder.file("run.mcap")).expect("the file");
    let mut counts = std::collections::BTreeMap::<String, u64>::new();
    for message in mcap::MessageStream::new(&bytes).expect("an MCAP file") {
        let message = message.expect("a message");
        let schema = message.channel.schema.as_ref().expect("a schema");
        assert_eq!(schema.encoding, "jsonschema");
        *counts.entry(message.channel.topic.clone()).or_default() += 1;
    }
    let recording = &summary["recording"];
    let cycles = recording["cycles"].as_u64().expect("a count");
    for topic in ["/cycle", "/axis/x_deg", "/axis/y_mm"] {
        assert_eq!(counts.get(topic), Some(&cycles), "{topic}");
    }
    assert_eq!(counts.get("/frames").copied(), recording["frames"].as_u64());
    let log = std::fs::read_to_string(folder.file("run.log")).expect("the log");
    assert_eq!(counts["/frames"], log.lines().count() as u64);
    let table = std::fs::read_to_string(folder.file("run.csv")).expect("the table");
    assert_eq!(cycles + 1, table.lines().count() as u64);
}

#[test]
fn a_full_disk_stops_the_recording_and_not_the_simulation() {
    let motion = Scratch::new("full.csv", SHORT);
    for option in ["--candump", "--csv", "--mcap"] {
        let arguments = [
            &SCALE[..],
            &["--trajectory", motion.as_str(), option, "/dev/full"],
        ];
        let (status, json, errors) = sim(&arguments.concat());
        assert_eq!(status, Some(1), "{option}: {errors}");
        assert_eq!(json["promises_kept"], true, "{option}");
        let file = &json["recording"]["files"][0];
        assert!(
            file["stopped"]
                .as_str()
                .expect("a reason")
                .contains("No space left"),
            "{file}"
        );
        let of = |counts: &str, what: &str| file[counts][what].as_u64().expect("a count");
        for what in ["cycles", "frames"] {
            let all = json["recording"][what].as_u64().expect("a count");
            assert_eq!(
                of("recorded", what) + of("lost", what),
                all,
                "{option} {what}"
            );
            assert!(of("lost", what) > 0);
        }
        let said = "the recording /dev/full stopped: No space left on device";
        assert_eq!(errors.matches(said).count(), 1, "{errors}");
        assert!(errors.contains("the simulation goes on"), "{errors}");
        assert!(errors.contains("frames lost"), "{errors}");
    }
}

#[test]
fn a_reader_that_has_gone_stops_the_recording_and_is_no_failure() {
    let motion = Scratch::new("gone.csv", SHORT);
    let mut child = Command::new(env!("CARGO_BIN_EXE_motionctl"))
        .args([
            "sim",
            "--trajectory",
            motion.as_str(),
            "--candump",
            "/dev/stdout",
        ])
        .args(SCALE)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("motionctl starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("its output");
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{errors}");
    assert!(
        errors.contains("the recording /dev/stdout stopped: Broken pipe"),
        "{errors}"
    );
}

#[test]
fn a_recording_is_written_over_no_file_of_the_same_command() {
    let motion = Scratch::new("over.csv", SHORT);
    let refused = |more: &[&str]| {
        let output =
            motionctl(&[&["sim", "--trajectory", motion.as_str()], &SCALE[..], more].concat());
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        assert!(
            text(&output.stderr).contains("is given twice"),
            "{output:?}"
        );
        assert_eq!(std::fs::read_to_string(&motion.0).expect("the file"), SHORT);
    };
    refused(&["--csv", motion.as_str()]);
    let other = Folder::new("over");
    refused(&["--csv", other.as_str(), "--mcap", other.as_str()]);
}

#[test]
fn a_log_that_tells_no_motion_in_time_has_no_page() {
    let folder = Folder::new("no-page");
    let log = Scratch::new("no-times.log", "  can0  029   [0]\n  can0  029   [1]  00\n");
    let output = motionctl(&["decode", log.as_str(), "--report", folder.as_str()]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(
        text(&output.stderr).contains("no frames with times"),
        "{output:?}"
    );
    let output = motionctl(&[
        "decode",
        log.as_str(),
        "--report",
        folder.as_str(),
        "--protocol",
        "canopen",
    ]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
}

#[test]
fn each_interface_of_a_log_has_its_page() {
    let folder = Folder::new("two-buses");
    let log = Scratch::new(
        "two.log",
        "(1700000000.001000) can0 03C#02\n(1700000000.001500) can1 05C#03\n(1700000000.002000) can0 03C#02\n",
    );
    let output = motionctl(&["decode", log.as_str(), "--report", folder.as_str()]);
    assert!(output.status.success(), "{output:?}");
    assert_eq!(Page::in_folder(&folder.file("can0")).sent(0), [2, 4]);
    assert_eq!(Page::in_folder(&folder.file("can1")).sent(0), [3]);
}

#[test]
fn the_live_view_shows_fourteen_axes_and_every_key_in_80_columns_and_24_lines() {
    let names: Vec<String> = (1..=14).map(|axis| format!("joint{axis}")).collect();
    let row = |time: u32, value: u32| format!("{time}{}\n", format!(",{value}").repeat(14));
    let text = format!("time_s,{}\n{}{}", names.join(","), row(0, 0), row(30, 360));
    let motion = Scratch::new("fourteen.csv", text);
    let words = [
        "sim",
        "--live",
        "--trajectory",
        motion.as_str(),
        "--cycle-us",
        "4000",
    ];
    let mut view = OnScreen::start(&words, 80, 24);
    let screen = view.wait_for("fourteen streaming axes", |text| {
        text.matches("streaming").count() >= 14
    });
    let lines: Vec<&str> = screen.lines().collect();
    assert!(lines.len() <= 24, "{screen}");
    for (number, name) in (1..).zip(&names) {
        let line = lines.iter().find(|line| {
            let mut words = line.split_whitespace();
            words.next() == Some(name.as_str()) && words.next() == Some(&number.to_string())
        });
        assert!(
            line.is_some_and(|line| line.contains("streaming")),
            "{name} in\n{screen}"
        );
    }
    for wanted in [
        "up/down select",
        "a alarm",
        "p pull/plug",
        "s stop",
        "space pause",
        "+ - 1 speed",
        "f [ ] time",
        "q quit",
        "bus load",
        "events;  keys a and p are for drive 1",
        "target",
        "motor",
        "error",
        "backlog",
    ] {
        assert!(screen.contains(wanted), "{wanted} in\n{screen}");
    }
    view.press("jp");
    view.wait_for("drive 2 off the bus", |text| {
        text.contains("keys a and p are for drive 2")
    });
    view.press("q");
    let (status, text) = view.wait();
    // A drive that was pulled off is a promise broken.
    assert_eq!(status.code(), Some(1), "{text}");
}

#[test]
fn manual_pages_are_there_for_every_command() {
    let folder = Folder::new("man");
    let output = motionctl(&["man", "--folder", folder.as_str()]);
    assert!(output.status.success(), "{output:?}");
    for page in ["motionctl.1", "motionctl-run.1", "motionctl-record.1"] {
        let text = std::fs::read_to_string(folder.file(page)).expect(page);
        assert!(text.contains(".TH") && text.contains("SYNOPSIS"), "{text}");
    }
    let output = motionctl(&["man", "run"]);
    assert!(text(&output.stdout).contains("mcap"), "{output:?}");
}

#[test]
fn two_simulated_buses_start_together_and_are_recorded_apart() {
    let folder = Folder::new("sim-buses");
    std::fs::create_dir_all(&folder.0).expect("a folder");
    let motion = Scratch::new(
        "sim-buses.csv",
        "t,x,y,z\n0,0,0,0\n0.2,90,-90,45\n0.4,180,0,90\n",
    );
    let [csv, page] = ["run.csv", "page"].map(|name| folder.file(name));
    let words = [
        "--trajectory",
        motion.as_str(),
        "--bus",
        "a=2,1",
        "--bus",
        "b=1",
        "--csv",
        &csv,
        "--report",
        &page,
    ];
    let (status, summary, errors) = sim(&words);
    assert_eq!(status, Some(0), "{summary} {errors}");
    let axes = |bus: usize| summary["buses"][bus]["axes"].as_array().expect("axes");
    let received = |bus: usize| -> Vec<i64> {
        let all = axes(bus)
            .iter()
            .map(|axis| axis["received_counts"].as_i64());
        all.map(|counts| counts.expect("a number")).collect()
    };
    // 180, 0 and 90 degrees of 16384 counts.
    assert_eq!((received(0), received(1)), (vec![8_192, 0], vec![4_096]));
    assert_eq!(axes(0)[0]["drive"], 2);
    let pages = ["page-a", "page-b"].map(|name| Page::in_folder(&folder.file(name)));
    assert_eq!(pages[0].axes(), ["x", "y"]);
    assert_eq!(pages[1].axes(), ["z"]);
    assert_eq!(pages[0].motion_start(), pages[1].motion_start());
    for name in ["run-a.csv", "run-b.csv"] {
        let text = std::fs::read_to_string(folder.file(name)).expect("a table");
        assert_eq!(text.lines().count(), pages[0].times_us.len() + 1, "{name}");
    }
}

#[test]
fn buses_that_cannot_be_simulated_are_refused() {
    for (words, wanted) in [
        (&["--bus", "a=1,2", "--bus", "a=3,4"][..], "given twice"),
        (&["--bus", "a=1", "--bus", "b=2"], "4 "),
        (&["--bus", "a b=1"], "NAME=IDS"),
        (&["--bus", "a=1,2,3,4", "--live"], "cannot be used with"),
    ] {
        let output = motionctl(&[&["sim"], words].concat());
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        let errors = text(&output.stderr);
        assert!(errors.contains(wanted), "{wanted} in {errors}");
    }
}
