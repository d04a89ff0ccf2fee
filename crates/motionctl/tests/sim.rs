//! `motionctl sim` as a user runs it: exit status, messages, files.

mod tool;

use std::process::{Command, Output};

use tool::page::Page;
use tool::{Folder, Scratch};

fn sim(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_motionctl"));
    command
        .arg("sim")
        .args(arguments)
        .output()
        .expect("motionctl runs")
}

fn refusal(arguments: &[&str]) -> String {
    let output = sim(arguments);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(output.stdout.is_empty(), "nothing may run: {output:?}");
    String::from_utf8(output.stderr).expect("plain text")
}

fn summary(arguments: &[&str]) -> (i32, serde_json::Value) {
    let output = sim(&[arguments, &["--json"]].concat());
    let json = serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{output:?}"));
    (output.status.code().expect("an exit status"), json)
}

/// Two axes, one turn and half a turn back, in 0.2 s.
const SHORT: &str = "time_s,a,b\n0,0,0\n0.1,180,-90\n0.2,360,-180\n";

#[test]
fn every_axis_receives_exactly_its_target() {
    let file = Scratch::new("short.csv", SHORT);
    let (status, json) = summary(&["--trajectory", file.as_str()]);
    assert_eq!(status, 0, "{json}");
    assert_eq!(json["promises_kept"], true);
    assert_eq!(json["late_cycles"], 0);
    let column = |name: &str| [&json["axes"][0][name], &json["axes"][1][name]].map(|v| v.as_i64());
    assert_eq!(column("target_counts"), [Some(16_384), Some(-8_192)]);
    assert_eq!(column("received_counts"), [Some(16_384), Some(-8_192)]);
    assert_eq!(column("position_error_counts"), [Some(0), Some(0)]);
}

#[test]
fn drives_may_be_in_any_order_and_of_either_revision() {
    let file = Scratch::new("order.csv", SHORT);
    let arguments = [
        "--trajectory",
        file.as_str(),
        "--drives",
        "9,4",
        "--revision",
        "1.2A",
        "--gear-ratio",
        "2,-1",
    ];
    let (status, json) = summary(&arguments);
    assert_eq!(status, 0, "{json}");
    assert_eq!(json["axes"][0]["drive"], 9);
    assert_eq!(json["axes"][0]["received_counts"], 32_768);
    assert_eq!(json["axes"][1]["received_counts"], 8_192);
}

#[test]
fn a_bus_that_cannot_carry_the_axes_is_refused_with_advice() {
    let file = Scratch::new("slow.csv", SHORT);
    let text = refusal(&["--trajectory", file.as_str(), "--bit-rate", "125"]);
    assert!(text.contains("set-point of drive 1 does not fit"), "{text}");
    assert!(text.contains("it would fit with 500 kbit/s"), "{text}");
}

#[test]
fn the_candump_log_has_one_line_a_frame_in_order() {
    let file = Scratch::new("dump.csv", SHORT);
    let log = Scratch::new("dump.log", "");
    let (status, _) = summary(&["--trajectory", file.as_str(), "--candump", log.as_str()]);
    assert_eq!(status, 0);
    let text = std::fs::read_to_string(&log.0).expect("the log");
    // The first frame is the echo request to drive 1 in the first cycle after the power-on wait.
    assert!(
        text.starts_with("(0.150"),
        "{}",
        text.lines().next().unwrap_or_default()
    );
    assert!(text.contains(" can0 03C#"), "set-points of drive 1");
    let times: Vec<f64> = text
        .lines()
        .map(|line| {
            line[1..line.find(')').expect("a time")]
                .parse()
                .expect("a number")
        })
        .collect();
    assert!(times.len() > 800 && times.is_sorted());
}

#[test]
fn a_broken_file_is_refused_with_its_line() {
    for (name, text, expected) in [
        (
            "text",
            "t,a\n0,0\n1,fast\n",
            "line 3, column 2 (a): expected a number, got \"fast\"",
        ),
        (
            "nan",
            "t,a\n0,0\n1,1\n2,NaN\n",
            "line 4, column 2 (a): expected a finite number, got NaN",
        ),
        (
            "back",
            "t,a\n0,0\n2,1\n1,2\n",
            "line 4, column 1 (t): time must increase, got 1 after 2",
        ),
        (
            "short",
            "t,a\n0,0\n1\n",
            "line 3: expected 2 columns as in line 1, got 1; column 2 (a) is missing",
        ),
        (
            "fast",
            "t,a\n0,0\n0.01,900\n",
            "line 3, column 2 (a): the axis would have to move",
        ),
        ("empty", "# nothing\n", "no line with numbers"),
    ] {
        let file = Scratch::new(name, text);
        let message = refusal(&["--trajectory", file.as_str(), "--max-step", "400"]);
        assert!(message.contains(expected), "{name}: {message}");
        assert!(
            message.contains(file.as_str()),
            "the file is named: {message}"
        );
    }
}

#[test]
fn a_wrong_option_is_refused_and_says_what_is_right() {
    let file = Scratch::new("options.csv", SHORT);
    let with = |option: &str, value: &str| refusal(&["--trajectory", file.as_str(), option, value]);
    assert!(
        with("--columns", "elbow")
            .contains("there is no column \"elbow\"; the file has time_s, a, b")
    );
    assert!(
        with("--axes", "3").contains("line 1: expected time and 3 axes, got 2 columns beside time")
    );
    assert!(with("--drives", "1,64").contains("drive id must be 1..=63, got 64"));
    assert!(with("--drives", "1").contains("expected 2 ids for 2 axes, got 1"));
    assert!(with("--drives", "5,5").contains("drive 5"));
    assert!(with("--gear-ratio", "nan").contains("expected a finite number other than 0"));
    assert!(with("--response-spread", "101").contains("must be 0..=100 percent, got 101"));
    assert!(with("--bit-rate", "333").contains("333"));
    // At 0 a motion would have no end.
    for cycle_us in ["0", "1", "100"] {
        assert!(with("--cycle-us", cycle_us).contains("250..=1000000"));
    }
    assert!(
        refusal(&["--trajectory", "no-such-file.csv"]).contains("cannot read no-such-file.csv")
    );
}

#[test]
fn the_report_has_every_frame_and_the_table_every_cycle() {
    let file = Scratch::new("report.csv", SHORT);
    let (log, table) = (
        Scratch::new("report.log", ""),
        Scratch::new("table.csv", ""),
    );
    let folder = Folder::new("report");
    let output = sim(&[
        "--trajectory",
        file.as_str(),
        "--report",
        folder.as_str(),
        "--csv",
        table.as_str(),
        "--candump",
        log.as_str(),
    ]);
    assert!(output.status.success(), "{output:?}");
    let page = std::fs::read_to_string(folder.0.join("index.html")).expect("the page");
    let frames = std::fs::read_to_string(&log.0)
        .expect("the log")
        .lines()
        .count();
    let page = Page::of(&page);
    assert_eq!(page.frames(), frames);
    assert_eq!(page.axes(), ["a", "b"]);
    let rows: Vec<csv::StringRecord> = csv::Reader::from_path(&table.0)
        .expect("the table")
        .records()
        .collect::<Result<_, _>>()
        .expect("rows");
    let last = rows.last().expect("a row");
    // Behind time, load and late: target, sent and drive of drive 1, eight columns for each drive.
    let column = |number: usize| last[number].parse::<i64>().expect("a number");
    assert_eq!([column(3), column(4), column(5)], [16_384; 3]);
    assert_eq!([column(11), column(12), column(13)], [-8_192; 3]);
    let end_s: f64 = last[0].parse().expect("a number");
    assert_eq!(rows.len(), (end_s * 1e3).round() as usize);
}

#[test]
fn a_fault_script_shows_what_the_master_does() {
    let file = Scratch::new("faults.csv", SHORT);
    let run = |name: &str, script: &str| {
        let script = Scratch::new(name, script);
        summary(&["--trajectory", file.as_str(), "--faults", script.as_str()])
    };
    let (status, json) = run(
        "alarm.toml",
        "[[alarm]]\nat_s = 0.1\ndrive = 2\nalarm = \"over-current\"\n",
    );
    assert_eq!(status, 1, "{json}");
    assert_eq!(json["axes"][1]["fault"], "the status shows: over-current");
    let advice = json["axes"][1]["advice"].as_str().expect("what to do");
    for part in ["drive 2: alarm, over-current", "Remove the cause"] {
        assert!(advice.contains(part), "{advice}");
    }
    // The other one stopped because of it, and says so without advice of its own.
    assert!(json["axes"][0]["advice"].is_null(), "{json}");
    assert_eq!(
        json["axes"][0]["fault"],
        "another axis of the group has a fault"
    );

    // Missed cycles cost time and no position.
    let (status, json) = run("missed.toml", "[[miss_cycles]]\nat_s = 0.1\ncycles = 2\n");
    assert_eq!((status, &json["late_cycles"]), (1, &2.into()), "{json}");
    assert_eq!(
        json["late_hand_overs"], 0,
        "the application was not there to hand over"
    );
    assert_eq!(json["axes"][0]["received_counts"], 16_384);

    // The drive has one step twice: the master sees it at standstill.
    let (status, json) = run(
        "twice.toml",
        "[[repeat_set_point]]\nat_s = 0.1\ndrive = 1\n",
    );
    assert_eq!(status, 1, "{json}");
    assert!(
        json["axes"][0]["received_counts"].as_i64() > Some(16_384),
        "{json}"
    );

    let late = "[[disable]]\nat_s = 0.05\ndrive = 1\n[[block]]\nat_s = 9.0\nfor_s = 0.1\n";
    let (_, json) = run("late.toml", late);
    assert_eq!(json["faults_not_reached"], 1);

    let (_, json) = run("disturb.toml", "[[disturb]]\nat_s = 0.1\nfor_s = 0.05\n");
    assert_eq!(
        json["axes"][0]["fault"],
        "the bus failed, the fate of the latest set-points is unknown"
    );
}

#[test]
fn a_fault_script_that_cannot_be_played_is_refused() {
    let file = Scratch::new("refused.csv", SHORT);
    let script = Scratch::new("refused.toml", "[[unplug]]\nat_s = 0.1\ndrive = 3\n");
    let with = |path: &str| refusal(&["--trajectory", file.as_str(), "--faults", path]);
    let message = with(script.as_str());
    assert!(message.contains("refused.toml: line 1: drive 3 takes no part; the drives are 1 2"));
    assert!(with("no-such-script.toml").contains("cannot read no-such-script.toml"));
}

#[test]
fn the_live_view_needs_a_terminal() {
    let message = refusal(&["--live"]);
    assert!(
        message.contains("the live view needs a terminal"),
        "{message}"
    );
}

#[test]
fn the_table_agrees_with_the_samples_from_which_the_plots_are_drawn() {
    let file = Scratch::new("agree.csv", SHORT);
    for (name, script) in [
        ("agree-0.toml", ""),
        ("agree-1.toml", "[[block]]\nat_s = 0.2\nfor_s = 0.004\n"),
        (
            "agree-2.toml",
            "[[drop_replies]]\nat_s = 0.1\ndrive = 2\ncount = 3\n",
        ),
    ] {
        let script = Scratch::new(name, script);
        let table = Scratch::new(&format!("{name}.csv"), "");
        let (_, json) = summary(&[
            "--trajectory",
            file.as_str(),
            "--faults",
            script.as_str(),
            "--csv",
            table.as_str(),
        ]);
        let mut reader = csv::Reader::from_path(&table.0).expect("the table");
        let names = reader.headers().expect("a header").clone();
        let rows: Vec<csv::StringRecord> =
            reader.records().collect::<Result<_, _>>().expect("rows");
        // The motion is what is summed up, and nothing comes behind it.
        let cycles = json["cycles"].as_u64().expect("a number") as usize;
        let motion = &rows[rows.len() - cycles..];
        let column = |name: String| {
            let place = names.iter().position(|other| other == name);
            let place = place.unwrap_or_else(|| panic!("no column {name}"));
            motion
                .iter()
                .filter_map(|row| row[place].parse::<f64>().ok())
                .collect::<Vec<f64>>()
        };
        let most = |values: Vec<f64>| values.into_iter().map(f64::abs).fold(0.0, f64::max);
        for axis in json["axes"].as_array().expect("axes") {
            let drive = &axis["drive"];
            let of = |what: &str| column(format!("drive{drive}_{what}"));
            let told = |what: &str| axis[what].as_f64().expect("a number");
            let named = format!("{name}, drive {drive}");
            assert_eq!(
                told("largest_backlog_counts"),
                most(of("backlog_counts")),
                "{named}"
            );
            assert_eq!(
                told("worst_status_age_ms"),
                most(of("status_age_us")) / 1e3,
                "{named}"
            );
            assert_eq!(
                told("worst_position_age_ms"),
                most(of("position_age_us")) / 1e3,
                "{named}"
            );
            let last = *of("error_counts").last().expect("a row");
            assert_eq!(told("position_error_counts"), last, "{named}");
        }
        let late = column("late".into()).iter().sum::<f64>();
        assert_eq!(json["late_cycles"].as_f64(), Some(late), "{name}");
        let peak = json["peak_bus_load"].as_f64().expect("a number");
        assert!(
            (peak - most(column("bus_load".into()))).abs() < 1e-4,
            "{name}: {peak}"
        );
    }
}
