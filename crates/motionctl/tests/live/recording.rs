//! A motion on the drives of a bench, recorded: the same in every file, and never in the way of the motion.

use std::process::{Output, Stdio};

use serde_json::Value;

use crate::bench::{BenchProcess, Scratch, motionctl, status_and_errors};
use crate::tool::page::Page;
use crate::tool::screen::OnScreen;
use crate::tool::{Folder, motionctl as tool};
use crate::undisturbed::undisturbed;

/// Two axes, one turn and half a turn back, in half a second.
const SHORT: &str = "time_s,a,b\n0,0,0\n0.25,180,-90\n0.5,360,-180\n";

fn run(bench: &BenchProcess, motion: &str, arguments: &[&str]) -> Output {
    let words = [
        "run",
        "--slcan",
        bench.path(),
        "--trajectory",
        motion,
        "--yes",
    ];
    motionctl(&[&words, arguments].concat())
        .output()
        .expect("motionctl runs")
}

fn json(output: &Output) -> Value {
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{output:?}"))
}

#[test]
fn the_pages_of_run_of_its_log_and_of_the_simulation_show_the_same_positions() {
    undisturbed(|| {
        let folder = Folder::new("run-page");
        std::fs::create_dir_all(&folder.0).expect("a folder");
        let bench = BenchProcess::start("run-page-bench", "1,2");
        let motion = Scratch::new("run-page.csv", SHORT);
        let [log, mcap, csv] = ["run.log", "run.mcap", "run.csv"].map(|name| folder.file(name));
        let files = [
            "--report",
            folder.as_str(),
            "--candump",
            &log,
            "--mcap",
            &mcap,
            "--csv",
            &csv,
            "--json",
        ];
        let output = run(&bench, motion.path(), &files);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let summary = json(&output);
        let page = Page::in_folder(folder.as_str());
        assert_eq!(page.axes(), ["a", "b"]);
        same_as_its_log(&page, &log, &folder.file("decoded"));
        same_as_the_simulation(&page, motion.path(), &folder.file("simulated"));
        every_file_has_everything(&summary, &page, [&log, &mcap, &csv]);
        let report = bench.stop();
        for axis in 0..2 {
            let (start, _) = page.motion_start();
            let sent = page.sent(axis);
            let way = sent.last().expect("a cycle") - sent[start - 1];
            assert_eq!(
                Some(way),
                report["drives"][axis]["received_counts"].as_i64()
            );
            assert!(page.positions(axis).len() > 20, "positions that were read");
        }
    });
}

/// Set-points are whole counts on both sides, and the order on the bus is that of the log: every value that the page shows is one of
/// the log, in the same order, without a tolerance. A set-point that the adapter took after the end of its cycle shows in the next one.
fn same_as_its_log(page: &Page, log: &str, folder: &str) {
    let output = tool(&["decode", log, "--report", folder]);
    assert!(output.status.success(), "{output:?}");
    let of_log = Page::in_folder(folder);
    let date = |page: &Page| {
        page.data()["about"][2][1]
            .as_str()
            .expect("a date")
            .to_owned()
    };
    assert_eq!(date(page)[..10], date(&of_log)[..10], "the same day");
    let (start, _) = page.motion_start();
    for axis in 0..2 {
        let sent = page.sent(axis);
        let shown = without_repetitions(&sent[start - 1..]);
        let logged = without_repetitions(&of_log.sent(axis));
        assert!(is_part_of(&shown, &logged), "axis {axis}");
        assert_eq!(
            (shown.first(), shown.last()),
            (logged.first(), logged.last())
        );
        assert!(shown.len() > 400 && shown.len() * 10 > logged.len() * 9);
    }
}

fn without_repetitions(values: &[i64]) -> Vec<i64> {
    let mut values = values.to_vec();
    values.dedup();
    values
}

/// Whether one list is the other one with some left out.
fn is_part_of(part: &[i64], all: &[i64]) -> bool {
    let mut all = all.iter();
    part.iter().all(|value| all.any(|other| other == value))
}

/// The plan is the same, and cycles are numbered alike: what the application wanted in a cycle agrees to the count.
fn same_as_the_simulation(page: &Page, motion: &str, folder: &str) {
    let output = tool(&["sim", "--trajectory", motion, "--report", folder]);
    assert!(output.status.success(), "{output:?}");
    let simulated = Page::in_folder(folder);
    let ((start, number), (first, first_number)) = (page.motion_start(), simulated.motion_start());
    for axis in 0..2 {
        let (target, wanted) = (page.target(axis), simulated.target(axis));
        let mut compared = 0;
        for place in start..target.len() {
            let cycle = page.numbers[place] - number;
            let same = simulated
                .numbers
                .iter()
                .position(|other| other - first_number == cycle);
            let Some(same) = same else { continue };
            assert_eq!(
                target[place] - target[start - 1],
                wanted[same] - wanted[first - 1],
                "axis {axis}, cycle {cycle}"
            );
            compared += 1;
        }
        assert!(compared > 400, "{compared}");
    }
}

fn every_file_has_everything(summary: &Value, page: &Page, [log, mcap, csv]: [&str; 3]) {
    let recording = &summary["recording"];
    let [cycles, frames] = ["cycles", "frames"].map(|what| recording[what].as_u64());
    assert_eq!(Some(page.times_us.len() as u64), cycles);
    assert_eq!(Some(page.frames() as u64), frames);
    let lines = |path: &str| {
        std::fs::read_to_string(path)
            .expect("a file")
            .lines()
            .count() as u64
    };
    assert_eq!(Some(lines(log)), frames);
    assert_eq!(Some(lines(csv) - 1), cycles);
    let bytes = std::fs::read(mcap).expect("the MCAP file");
    let messages = mcap::MessageStream::new(&bytes).expect("an MCAP file");
    let topics: Vec<String> = messages
        .map(|message| message.expect("a message").channel.topic.clone())
        .collect();
    let count = |topic: &str| Some(topics.iter().filter(|other| *other == topic).count() as u64);
    assert_eq!(
        [count("/cycle"), count("/axis/a"), count("/axis/b")],
        [cycles; 3]
    );
    assert_eq!(count("/frames"), frames);
}

#[test]
fn a_full_disk_ends_the_recording_and_never_the_motion() {
    undisturbed(|| {
        let bench = BenchProcess::start("run-full", "1,2");
        let motion = Scratch::new("run-full.csv", SHORT);
        let full = [
            "--candump",
            "/dev/full",
            "--mcap",
            "/dev/full",
            "--csv",
            "/dev/full",
            "--json",
        ];
        let output = run(&bench, motion.path(), &full);
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(1), "{errors}");
        let summary = json(&output);
        assert_eq!(summary["completed"], true, "{summary}");
        let files = summary["recording"]["files"].as_array().expect("files");
        assert_eq!(files.len(), 3);
        for file in files {
            assert!(
                file["stopped"]
                    .as_str()
                    .expect("why")
                    .contains("No space left"),
                "{file}"
            );
            let count = |counts: &str| file[counts]["frames"].as_u64().expect("a count");
            let all = summary["recording"]["frames"].as_u64().expect("a count");
            assert_eq!(count("recorded") + count("lost"), all, "{file}");
        }
        let said = errors.matches("/dev/full stopped: No space left").count();
        assert_eq!(said, 3, "once a file: {errors}");
        assert!(errors.contains("the motion goes on"), "{errors}");
        let report = bench.stop();
        let received = |drive: usize| report["drives"][drive]["received_counts"].as_i64();
        assert_eq!([received(0), received(1)], [Some(16_384), Some(-8_192)]);
    });
}

#[test]
fn a_reader_that_has_gone_or_reads_nothing_never_delays_the_motion() {
    undisturbed(|| {
        let bench = BenchProcess::start("run-gone", "1,2");
        let motion = Scratch::new("run-gone.csv", SHORT);
        let words = [
            "run",
            "--slcan",
            bench.path(),
            "--trajectory",
            motion.path(),
            "--yes",
            "--candump",
            "/dev/stdout",
        ];
        let mut child = motionctl(&words)
            .stdout(Stdio::piped())
            .spawn()
            .expect("it starts");
        drop(child.stdout.take());
        let (status, errors) = status_and_errors(&child.wait_with_output().expect("its output"));
        assert_eq!(status, Some(0), "{errors}");
        assert!(
            errors.contains("/dev/stdout stopped: Broken pipe"),
            "{errors}"
        );
        let report = bench.stop();
        assert_eq!(report["drives"][0]["received_counts"], 16_384);
    });
}

#[test]
fn the_live_view_of_a_motion_shows_fourteen_axes_in_80_columns_and_24_lines_and_stops_it() {
    let names: Vec<String> = (1..=14).map(|axis| format!("joint{axis}")).collect();
    let row = |time: u32, value: u32| format!("{time}{}\n", format!(",{value}").repeat(14));
    let text = format!("time_s,{}\n{}{}", names.join(","), row(0, 0), row(60, 360));
    let motion = Scratch::new("run-live.csv", &text);
    undisturbed(|| {
        let bench = BenchProcess::start("run-live", "1-14");
        let words = [
            "run",
            "--live",
            "--slcan",
            bench.path(),
            "--trajectory",
            motion.path(),
            "--yes",
            "--cycle-us",
            "10000",
        ];
        let mut view = OnScreen::start(&words, 80, 24);
        let screen = view.wait_for("fourteen streaming axes", |text| {
            text.matches("streaming").count() >= 14
        });
        for (number, name) in (1..).zip(&names) {
            let line = screen.lines().find(|line| {
                let mut words = line.split_whitespace();
                words.next() == Some(name.as_str()) && words.next() == Some(&number.to_string())
            });
            assert!(line.is_some(), "{name} in\n{screen}");
        }
        for wanted in [
            "up/down select",
            "space pause",
            "+ - 1 speed",
            "s stop on the path",
            "Ctrl-C stop",
            "q stop and leave",
            "bus load",
            "backlog",
            "motor",
        ] {
            assert!(screen.contains(wanted), "{wanted} in\n{screen}");
        }
        // The keys mean what they mean without the view.
        view.press("--");
        view.wait_for("a slower motion", |text| text.contains("at 80 %"));
        view.press(" ");
        view.wait_for("a pause", |text| {
            text.contains("at 0 %") && text.contains("PAUSED")
        });
        // Ctrl-C is a signal and no key, even here: it works when the view hangs.
        view.press("\u{3}");
        view.wait_for("the end", |text| {
            text.contains("stopped by the user") && text.contains("q leave the view")
        });
        view.press("q");
        let (status, text) = view.wait();
        assert_eq!(status.code(), Some(130), "{text}");
        assert!(
            text.contains("STAY ENABLED"),
            "what was told meanwhile is there:\n{text}"
        );
    });
}

#[test]
fn what_was_heard_before_a_motion_that_did_not_begin_is_in_the_log() {
    undisturbed(|| {
        let folder = Folder::new("run-missing");
        std::fs::create_dir_all(&folder.0).expect("a folder");
        // Drive 2 is not there.
        let bench = BenchProcess::start("run-missing-bench", "1");
        let motion = Scratch::new("run-missing.csv", SHORT);
        let log = folder.file("run.log");
        let output = run(&bench, motion.path(), &["--candump", &log]);
        assert_ne!(output.status.code(), Some(0), "{output:?}");
        let text = std::fs::read_to_string(&log).expect("the log");
        assert!(text.contains(" 029#"), "a request to drive 1: {text}");
    });
}

#[test]
fn each_of_several_buses_has_its_own_recording() {
    undisturbed(|| {
        let folder = Folder::new("run-buses");
        std::fs::create_dir_all(&folder.0).expect("a folder");
        let benches = [
            BenchProcess::start("run-bus-a", "1"),
            BenchProcess::start("run-bus-b", "1"),
        ];
        let motion = Scratch::new("run-buses.csv", SHORT);
        let [csv, log, page] = ["run.csv", "run.log", "page"].map(|name| folder.file(name));
        let buses = benches
            .each_ref()
            .map(|bench| format!("slcan:{}=1", bench.path()));
        let words = [
            "run",
            "--bus",
            &buses[0],
            "--bus",
            &buses[1],
            "--trajectory",
            motion.path(),
            "--yes",
            "--json",
            "--csv",
            &csv,
            "--candump",
            &log,
            "--report",
            &page,
        ];
        let output = motionctl(&words).output().expect("motionctl runs");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let summary = json(&output);
        for (place, (bench, axis)) in benches.into_iter().zip(["a", "b"]).enumerate() {
            let tail = bench.path().rsplit('/').next().expect("a name").to_owned();
            let page = Page::in_folder(&folder.file(&format!("page-{tail}")));
            assert_eq!(page.axes(), [axis]);
            let recording = &summary["buses"][place]["recording"];
            let lines = |name: &str| {
                let path = folder.file(name);
                let text = std::fs::read_to_string(&path).expect("a file");
                text.lines().count() as u64
            };
            assert_eq!(
                recording["cycles"].as_u64(),
                Some(lines(&format!("run-{tail}.csv")) - 1)
            );
            assert_eq!(
                recording["frames"].as_u64(),
                Some(lines(&format!("run-{tail}.log")))
            );
            let (start, _) = page.motion_start();
            let sent = page.sent(0);
            let way = sent.last().expect("a cycle") - sent[start - 1];
            let report = bench.stop();
            assert_eq!(Some(way), report["drives"][0]["received_counts"].as_i64());
        }
    });
}

#[test]
fn a_view_and_a_sender_never_share_a_keyboard() {
    let words = [
        "run",
        "--live",
        "--slcan",
        "/dev/null",
        "--drives",
        "1",
        "--stream",
        "-",
        "--yes",
    ];
    let view = OnScreen::start(&words, 80, 24);
    let (status, text) = view.wait();
    assert_eq!(status.code(), Some(2), "{text}");
    assert!(text.contains("--live reads keys"), "{text}");
}

#[test]
fn a_program_on_a_bus_is_recorded_in_millimetres() {
    undisturbed(|| {
        let folder = Folder::new("run-program-page");
        let bench = BenchProcess::start("run-program", "1,2");
        let program = Scratch::new("run-program.ngc", "G21 G91 F600\nG1 X5\nG1 Y-5\nM2\n");
        let words = [
            "run",
            "--slcan",
            bench.path(),
            "--program",
            program.path(),
            "--axes",
            "2",
            "--mm-per-turn",
            "20",
            "--yes",
            "--report",
            folder.as_str(),
        ];
        let output = motionctl(&words).output().expect("motionctl runs");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let page = Page::in_folder(folder.as_str());
        assert_eq!(page.axes(), ["X", "Y"]);
        let (start, _) = page.motion_start();
        // A quarter of a turn: 5 of 20 mm.
        for (axis, way) in [4_096, -4_096].into_iter().enumerate() {
            assert_eq!(page.data()["axes"][axis]["unit"], "mm");
            let target = page.target(axis);
            let last = target.last().expect("a cycle");
            assert_eq!(last - target[start - 1], way);
            let counts = page.data()["axes"][axis]["countsPerUnit"].as_f64();
            assert_eq!(counts, Some(819.2));
        }
    });
}
