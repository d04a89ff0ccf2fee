//! Hub motors on a bench, recorded and watched: the same speeds in every file, and never in the way of the motion.

use std::process::Stdio;

use serde_json::Value;

use crate::bench::{BenchProcess, Scratch, motionctl, start_and_wait_for, status_and_errors};
use crate::tool::Folder;
use crate::tool::page::Page;
use crate::tool::screen::OnScreen;
use crate::undisturbed::undisturbed;

/// One wheel turns half a turn, the other one back.
const SHORT: &str = "time_s,left_rpm,right_rpm\n0,0,0\n0.25,60,-60\n0.5,60,-60\n0.75,0,0\n";

fn words<'a>(bench: &'a BenchProcess, motion: &'a str) -> Vec<&'a str> {
    let words = ["run", "--drives", "zlac:5,4", "--slcan", bench.path()];
    let motion = ["--trajectory", motion, "--yes"];
    [&words[..], &motion].concat()
}

/// The cells of a column; none where nothing is known.
fn column(table: &str, name: &str) -> Vec<Option<f64>> {
    let mut lines = table.lines();
    let names = lines.next().expect("a line of names");
    let place = names.split(',').position(|other| other == name);
    let place = place.unwrap_or_else(|| panic!("{name} in {names}"));
    lines
        .map(|line| line.split(',').nth(place).expect("a cell").parse().ok())
        .collect()
}

fn milli(rpm: &[Option<f64>]) -> Vec<i64> {
    let known = rpm.iter().flatten();
    known.map(|rpm| (rpm * 1e3).round() as i64).collect()
}

/// The speeds in the frames to a node, in thousandths of an r/min: a control word of two bytes is before them.
fn logged(log: &str, id: &str) -> Vec<i64> {
    let frames = log.lines().filter_map(|line| line.split_once(id));
    let speed = |(_, data): (&str, &str)| {
        let bytes = |at: usize| u8::from_str_radix(&data[at..at + 2], 16).expect("a byte");
        let speed = i32::from_le_bytes([4, 6, 8, 10].map(bytes));
        i64::from(speed) * 1_000
    };
    frames.map(speed).collect()
}

fn without_repetitions(mut values: Vec<i64>) -> Vec<i64> {
    values.dedup();
    values
}

#[test]
fn the_page_the_table_and_the_log_of_wheels_have_the_same_speeds() {
    undisturbed(|| {
        let folder = Folder::new("hub-run");
        std::fs::create_dir_all(&folder.0).expect("a folder");
        let bench = BenchProcess::start("hub-run-bench", "zlac:4,5");
        let motion = Scratch::new("hub-run.csv", SHORT);
        let [csv, log, mcap] = ["run.csv", "run.log", "run.mcap"].map(|name| folder.file(name));
        let files = ["--report", folder.as_str(), "--csv", &csv, "--mcap", &mcap];
        let all = [
            &words(&bench, motion.path())[..],
            &files,
            &["--candump", &log],
        ];
        let output = motionctl(&[&all.concat()[..], &["--json"]].concat()).output();
        let output = output.expect("motionctl runs");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        let page = Page::in_folder(folder.as_str());
        assert_eq!(page.data()["quantity"], "speed");
        assert_eq!(page.axes(), ["left_rpm", "right_rpm"]);
        let [table, text] = [&csv, &log].map(|path| std::fs::read_to_string(path).expect("a file"));
        let report = bench.stop();
        // The first column is for node 5.
        for (axis, node) in [5, 4].into_iter().enumerate() {
            let of = |name: &str| column(&table, &format!("node{node}_{name}"));
            assert_eq!(page.target(axis), milli(&of("target_rpm")));
            assert_eq!(page.sent(axis), milli(&of("sent_rpm")));
            let read: Vec<i64> = page.positions(axis).iter().map(|(_, rpm)| *rpm).collect();
            assert_eq!(read, milli(&of("speed_rpm")));
            assert!(read.len() > 20, "speeds that were read: {}", read.len());
            let most = read.iter().map(|rpm| rpm.abs()).max();
            assert!(most > Some(50_000), "{most:?}");
            let sent = without_repetitions(page.sent(axis));
            let wire = without_repetitions(logged(&text, &format!(" 30{node}#")));
            assert!(wire.starts_with(&[0]) && sent.len() > 20, "{sent:?}");
            assert_eq!((sent.first(), sent.last()), (wire.first(), wire.last()));
            assert!(sent.iter().all(|speed| wire.contains(speed)), "{wire:?}");
            let ways: Vec<f64> = of("read_position_counts").into_iter().flatten().collect();
            let way = ways.last().expect("a position") - ways[0];
            let place = usize::from(node == 5);
            let travel = report["drives"][place]["travel_counts"].as_f64();
            assert!(
                (way - travel.expect("counts")).abs() <= 2.0,
                "{way} {travel:?}"
            );
        }
        let recording = &summary["recording"];
        assert_eq!(recording["files"].as_array().map(Vec::len), Some(4));
        let lines = |text: &str| text.lines().count() as u64;
        assert_eq!(recording["cycles"].as_u64(), Some(lines(&table) - 1));
        assert_eq!(recording["frames"].as_u64(), Some(lines(&text)));
        assert_eq!(page.frames() as u64, lines(&text));
    });
}

#[test]
fn a_full_disk_stops_the_table_and_never_the_wheels() {
    undisturbed(|| {
        let bench = BenchProcess::start("hub-full", "zlac:4,5");
        let motion = Scratch::new("hub-full.csv", SHORT);
        let all = [
            &words(&bench, motion.path())[..],
            &["--csv", "/dev/full", "--json"],
        ]
        .concat();
        let output = motionctl(&all).output().expect("motionctl runs");
        let (status, errors) = status_and_errors(&output);
        let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!((status, &summary["complete"]), (Some(1), &true.into()));
        assert!(errors.contains("/dev/full"), "{errors}");
        let stopped = &summary["recording"]["files"][0]["stopped"];
        assert!(stopped.is_string(), "{summary}");
        let report = bench.stop();
        let travel = report["drives"][1]["travel_counts"].as_i64();
        assert!(travel > Some(1_900), "{travel:?}");
    });
}

#[test]
fn wheels_that_cannot_end_as_they_should_leave_a_page_that_says_why() {
    undisturbed(|| {
        let folder = Folder::new("hub-cut");
        std::fs::create_dir_all(&folder.0).expect("a folder");
        let mut bench = BenchProcess::start("hub-cut-bench", "zlac:4,5");
        let motion = Scratch::new(
            "hub-cut.csv",
            "time_s,a,b\n0,0,0\n1,60,60\n60,60,60\n61,0,0\n",
        );
        let log = folder.file("run.log");
        let files = ["--report", folder.as_str(), "--candump", &log];
        let all = [&words(&bench, motion.path())[..], &files].concat();
        let mut command = motionctl(&all);
        command.stdin(Stdio::null());
        let child = start_and_wait_for(command, "Ctrl-C slows them down");
        crate::bench::wait_until("the wheels turn", || {
            std::fs::read_to_string(&log)
                .is_ok_and(|text| logged(&text, " 304#").last() > Some(&9_000))
        });
        bench.kill();
        let output = child.wait_with_output().expect("its output");
        assert_ne!(output.status.code(), Some(0), "{output:?}");
        let page = Page::in_folder(folder.as_str());
        let about = page.data().to_string();
        assert!(about.contains("NOT complete: "), "{about}");
        assert!(page.sent(0).last() > Some(&9_000), "until the end");
    });
}

#[test]
fn the_live_view_shows_wheels_on_a_bus_and_stops_them() {
    undisturbed(|| {
        let bench = BenchProcess::start("hub-live", "zlac:4,5");
        let motion = Scratch::new(
            "hub-live.csv",
            "time_s,a,b\n0,0,0\n1,60,60\n60,60,60\n61,0,0\n",
        );
        let all = [&words(&bench, motion.path())[..], &["--live"]].concat();
        let mut view = OnScreen::start(&all, 80, 24);
        let screen = view.wait_for("two streaming wheels", |text| {
            text.matches("streaming").count() >= 2
        });
        for wanted in [
            "node",
            "wheel",
            "r/min",
            "on the bus",
            "s stop",
            "q stop and leave",
        ] {
            assert!(screen.contains(wanted), "{wanted} in\n{screen}");
        }
        assert!(!screen.contains("pause"), "speeds have no path:\n{screen}");
        view.press("s");
        view.wait_for("the end", |text| {
            text.contains("Stopped by the user") && text.contains("q leave the view")
        });
        view.press("q");
        let (status, shown) = view.wait();
        assert_eq!(status.code(), Some(130), "{shown}");
    });
}

#[test]
fn the_frames_of_wheels_that_the_bus_cannot_carry_are_in_the_log() {
    undisturbed(|| {
        let folder = Folder::new("hub-too-many");
        std::fs::create_dir_all(&folder.0).expect("a folder");
        let nodes: Vec<String> = (1..=12).map(|node: u8| node.to_string()).collect();
        let drives = format!("zlac:{}", nodes.join(","));
        let rate = ["--bit-rate", "100"];
        let bench = BenchProcess::start_with("hub-too-many-bench", &drives, &rate);
        let row = |time: &str, rpm: &str| format!("{time}{}\n", format!(",{rpm}").repeat(12));
        let names: String = nodes.iter().map(|node| format!(",w{node}_rpm")).collect();
        let text = format!("time_s{names}\n{}{}", row("0", "0"), row("1", "0"));
        let motion = Scratch::new("hub-too-many.csv", &text);
        let log = folder.file("run.log");
        let words = ["run", "--drives", &drives, "--slcan", bench.path()];
        let motion = ["--trajectory", motion.path(), "--yes", "--candump", &log];
        let all = [&words[..], &rate, &motion].concat();
        let output = motionctl(&all).output().expect("motionctl runs");
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(2), "{errors}");
        assert!(
            errors.contains("the bus carries more than it can"),
            "{errors}"
        );
        let text = std::fs::read_to_string(&log).expect("a log");
        // Each was asked what it is.
        for node in 1..=12 {
            assert!(text.contains(&format!(" {:03X}#", 0x600 + node)), "{node}");
        }
        drop(bench);
    });
}
