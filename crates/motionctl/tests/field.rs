//! Files as people have them: motions and logs that were once read wrongly, each with what is right.

mod tool;

use std::process::{Command, Stdio};

use serde_json::Value;
use tool::{Scratch, motionctl, text};

/// Runs a motion on simulated drives: what each drive received, axis by axis, and the whole summary.
fn moved(name: &str, file: &str, options: &[&str]) -> (Vec<i64>, Value) {
    let file = Scratch::new(name, file);
    let words = [&["sim", "--json", "--trajectory", file.as_str()], options].concat();
    let output = motionctl(&words);
    assert_eq!(output.status.code(), Some(0), "{name}: {output:?}");
    let json: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let axes = json["axes"].as_array().expect("axes").iter();
    let received = axes.map(|axis| axis["received_counts"].as_i64().expect("counts"));
    (received.collect(), json)
}

/// What a motion is refused with, behind the name of its file.
fn refused(name: &str, file: impl AsRef<[u8]>, options: &[&str]) -> String {
    let file = Scratch::new(name, file);
    let words = [&["sim", "--trajectory", file.as_str()], options].concat();
    let output = motionctl(&words);
    assert_eq!(output.status.code(), Some(2), "{name}: {output:?}");
    assert!(output.stdout.is_empty(), "nothing may run: {output:?}");
    let errors = text(&output.stderr);
    assert_eq!(errors.lines().count(), 1, "{errors}");
    let begin = format!("error: {}: ", file.as_str());
    errors
        .strip_prefix(&begin)
        .unwrap_or_else(|| panic!("{errors}"))
        .trim_end()
        .to_owned()
}

/// One turn of the factory setting.
const TURN: i64 = 16_384;

/// Counts of an angle, as the file means it.
fn degrees(angle: f64) -> i64 {
    (angle / 360.0 * TURN as f64).round() as i64
}

#[test]
fn the_column_named_time_is_time() {
    let text = "q1,q2,time\n0,0,0\n10,5,0.5\n20,0,1\n";
    let (received, json) = moved("time_last", text, &[]);
    assert_eq!(received, [degrees(20.0), 0]);
    assert_eq!(json["motion"]["time"]["name"], "time");
    assert_eq!(json["motion"]["time"]["column"], 3);
    assert_eq!(json["motion"]["duration_s"], 1.0);
    assert_eq!(json["motion"]["axes"][1]["name"], "q2");
}

#[test]
fn a_missing_value_is_an_error_with_its_line_and_column() {
    let pandas = ",t,a,b\n0,0.0,0,\n1,0.5,10,\n2,1.0,20,\n";
    let error = refused("pandas_index_nan", pandas, &[]);
    assert!(
        error.starts_with("line 2, column 4 (b): expected a number, got an empty field"),
        "{error}"
    );
    // The column without a name is an index of the tool that wrote the file: time is the one that says so.
    let (received, json) = moved("pandas_index", pandas, &["--columns", "a"]);
    assert_eq!(received, [degrees(20.0)]);
    assert_eq!(json["motion"]["time"]["name"], "t");
    assert_eq!(json["motion"]["left_out"][0]["column"], 1);
}

#[test]
fn empty_fields_keep_their_place() {
    let text = "0,,0\n0.5,,5\n1,,0\n";
    let error = refused("empty_col_nohdr", text, &[]);
    assert!(
        error.starts_with("line 1, column 2: expected a number, got an empty field"),
        "{error}"
    );
    let (_, json) = moved("empty_col", text, &["--time-column", "1", "--columns", "3"]);
    assert_eq!(json["motion"]["axes"][0]["column"], 3);
    let highest = json["motion"]["axes"][0]["highest"].as_f64();
    assert!(
        (highest.expect("degrees") - 5.0).abs() < 1e-6,
        "{highest:?}"
    );
    let gap = refused("gap_then_full", "0,1,,3\n0.5,2,,4\n1,3,5,6\n", &[]);
    assert!(
        gap.starts_with("line 1, column 3: expected a number, got an empty field"),
        "{gap}"
    );
}

#[test]
fn names_decide_which_columns_are_positions() {
    let text = "t,pos,vel,acc\n0,0,0,0\n0.5,5,20,40\n1,20,40,0\n1.5,35,20,-40\n2,40,0,-40\n";
    let (received, json) = moved("pos_vel_acc", text, &[]);
    assert_eq!(received, [degrees(40.0)]);
    let left_out: Vec<_> = json["motion"]["left_out"]
        .as_array()
        .expect("a list")
        .iter()
        .map(|left| &left["name"])
        .collect();
    assert_eq!(left_out, ["vel", "acc"]);
}

#[test]
fn an_axis_may_be_the_derivative_of_another() {
    let rows = (0..=628).map(|step| {
        let t = f64::from(step) / 100.0;
        format!("{t},{},{}\n", 30.0 * t.sin(), 30.0 * t.cos())
    });
    let text = format!("t,joint1,joint2\n{}", rows.collect::<String>());
    let (received, json) = moved("circle_sin_cos", &text, &[]);
    assert_eq!(received.len(), 2);
    let lowest = json["motion"]["axes"][1]["lowest"]
        .as_f64()
        .expect("a number");
    assert!((lowest + 60.0).abs() < 0.01, "{lowest}");
}

#[test]
fn a_line_of_numbers_and_text_is_no_header() {
    let error = refused("first_row_bad", "0,x,0\n0.5,10,5\n1,20,0\n", &[]);
    assert!(
        error.starts_with(
            "line 1 mixes numbers and text: column 1 is the number 0, column 2 is \"x\""
        ),
        "{error}"
    );
}

#[test]
fn stamps_of_ros_are_refused_in_seconds_and_run_in_nanoseconds() {
    let text = "t,a\n1700000000000000000,0\n1700000000500000000,10\n1700000001000000000,20\n";
    let error = refused("ros_ns", text, &[]);
    assert!(
        error.starts_with(
            "line 3, column 1 (t): read in s the motion lasts 31.7 years, expected at most 3600 s"
        ) && error.contains("--time-unit")
            && error.contains("1 s in ns"),
        "{error}"
    );
    let (received, json) = moved("ros_ns_unit", text, &["--time-unit", "ns"]);
    assert_eq!(received, [degrees(20.0)]);
    assert_eq!(json["motion"]["duration_s"], 1.0);
    // rostopic echo -p
    let topic = "%time,field.header.seq,field.header.frame_id,field.name0,field.position0,field.velocity0\n1700000000000000000,1,base,j1,0,0\n1700000000500000001,2,base,j1,3.14159265358979,0\n";
    let (received, json) = moved("rostopic", topic, &["--time-unit", "ns", "--unit", "rad"]);
    assert_eq!(
        (received, &json["motion"]["duration_s"]),
        (vec![TURN / 2], &0.500_000_001.into())
    );
    let seconds = "t,a\n1700000000.000000000,0\n1700000000.000000250,0\n1700000000.5,10\n";
    assert_eq!(
        moved("epoch_s", seconds, &[]).1["motion"]["duration_s"],
        0.5
    );
}

#[test]
fn line_ends_of_windows_count_once() {
    let error = refused("crlf", "t,a\r\n0,0\r\n1,10\r\n2,x\r\n", &[]);
    assert!(
        error.starts_with("line 4, column 2 (a): expected a number, got \"x\""),
        "{error}"
    );
}

#[test]
fn a_column_that_nobody_wants_is_not_read() {
    let text = "t,name,a\n0,j1,2\n0.5,j1,2.5\n1,j1,3\n";
    for options in [&["--columns", "a"][..], &[]] {
        assert_eq!(moved("text_col", text, options).0, [degrees(1.0)]);
    }
}

#[test]
fn a_byte_order_mark_in_front_of_a_comment_is_no_text() {
    let text = "\u{feff}# Export, 28.11.2026\nt;a\n0;0\n0.5;10\n1;20\n";
    assert_eq!(moved("bom_comment", text, &[]).0, [degrees(20.0)]);
    let wide: Vec<u8> = "t,a\n0,0\n1,1\n"
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    let error = refused("utf16", [&[0xFF, 0xFE][..], &wide].concat(), &[]);
    assert!(
        error.starts_with("line 1: expected UTF-8 text, got UTF-16"),
        "{error}"
    );
}

#[test]
fn units_in_names_are_the_units_or_an_error() {
    let millimetres = "time_ms,x_mm\n0,0\n1000,10\n";
    let error = refused("x_mm", millimetres, &[]);
    assert!(
        error.contains("column 2 (x_mm) is in millimetres: give --mm-per-turn (or --pitch-mm)"),
        "{error}"
    );
    for option in ["--pitch-mm", "--mm-per-turn"] {
        let (received, json) = moved("x_mm_pitch", millimetres, &[option, "5"]);
        assert_eq!(received, [2 * TURN]);
        assert_eq!(json["motion"]["axes"][0]["unit"], "mm");
        assert_eq!(json["motion"]["time"]["unit"], "ms");
    }
    for option in [["--unit", "deg"], ["--time-unit", "s"]] {
        let error = refused("x_mm_conflict", millimetres, &option);
        assert!(
            error.contains("its name says") && error.contains("the option says --"),
            "{error}"
        );
    }
    let radians = format!("t,a_rad\n0,0\n1,{}\n", core::f64::consts::PI);
    assert_eq!(moved("a_rad", &radians, &[]).0, [TURN / 2]);
    let mixed = "t,a_rad,x_mm,c_deg,d_turns,e_counts\n0,0,0,0,0,0\n1,0,8,90,0.5,77\n";
    let (received, _) = moved(
        "mixed",
        mixed,
        &["--mm-per-turn=-,4,-,-,-", "--gear-ratio", "1,1,2,1,1"],
    );
    assert_eq!(received, [0, 2 * TURN, TURN / 2, TURN / 2, 77]);
    let error = refused("half", "t,a_rad,b\n0,0,0\n1,1,1\n", &[]);
    assert!(
        error.contains("the name of column 3 (b) has no unit; give --unit"),
        "{error}"
    );
    let error = refused("metres", "t,x_m\n0,0\n1,1\n", &[]);
    assert!(error.contains("column 2 (x_m): expected a unit of positions (counts, deg, rad, turns, mm), its name says \"m\""), "{error}");
    let error = refused("rpm", "t,left_rpm\n0,0\n1,1\n", &["--columns", "left_rpm"]);
    assert!(error.contains("its name says \"r/min\""), "{error}");
}

#[test]
fn the_motion_is_shown_before_anything_moves() {
    let file = Scratch::new(
        "shown",
        "time_s,shoulder_deg,vel\n0,0,0\n0.1,360,0\n0.2,0,0\n",
    );
    let output = motionctl(&[
        "sim",
        "--trajectory",
        file.as_str(),
        "--interpolation",
        "linear",
        "--gear-ratio",
        "4",
        "--drives",
        "7",
    ]);
    let notes = text(&output.stderr);
    let axis = notes
        .lines()
        .find(|line| line.contains("shoulder_deg"))
        .expect("the axis");
    for wanted in ["7", "0 to 360 deg", "2400.0", "80 % of 3000 r/min"] {
        assert!(axis.contains(wanted), "{wanted} in {notes}");
    }
    assert!(
        notes.contains("time is time_s in s") && notes.contains("not driven: vel (a speed)"),
        "{notes}"
    );
    let (_, json) = moved(
        "shown_json",
        "time_s,a\n0,0\n0.1,360\n0.2,0\n",
        &["--interpolation", "linear"],
    );
    let axis = &json["motion"]["axes"][0];
    assert!(
        (axis["peak_rpm"].as_f64().expect("a number") - 600.0).abs() < 1e-3,
        "{axis}"
    );
    // From -600 to 600 r/min within one cycle of 1 ms.
    assert!(
        (axis["peak_rpm_per_s"].as_f64().expect("a number") - 1.2e6).abs() < 1.0,
        "{axis}"
    );
}

/// Runs the tool with at most so much memory, and gives its exit status and errors.
#[cfg(unix)]
fn with_memory(kilobytes: u32, words: &[&str]) -> (Option<i32>, String) {
    let script = format!("ulimit -v {kilobytes}; exec \"$0\" \"$@\"");
    let mut command = Command::new("sh");
    command.args(["-c", &script, env!("CARGO_BIN_EXE_motionctl")]);
    let output = command.args(words).output().expect("a shell");
    (output.status.code(), text(&output.stderr).to_owned())
}

#[test]
#[cfg(unix)]
fn no_size_of_input_takes_more_memory_than_its_points() {
    const KILOBYTES: u32 = 300_000;
    let refused = |name: &str, file: &str, expected: &str| {
        let file = Scratch::new(name, file);
        let (status, errors) = with_memory(KILOBYTES, &["sim", "--trajectory", file.as_str()]);
        assert_eq!(status, Some(2), "{name}: {errors}");
        assert!(errors.contains(expected), "{name}: {errors}");
    };
    refused("years", "t,a\n0,0\n1e18,1\n", "years");
    refused("huge", "t,a\n0,0\n1e22,1\n", "years");
    refused("day", "t,a\n0,0\n86400,1\n", "the motion lasts 24.0 h");
    refused("far", "t,a\n0,0\n1,1e300\n", "28-bit travel");
    let columns = vec!["a"; 40_000].join(",");
    refused(
        "wide",
        &columns,
        "line 1: expected a line of at most 65536 bytes",
    );
    for words in [["sim", "--trajectory=/dev/zero"], ["decode", "/dev/zero"]] {
        let (status, errors) = with_memory(KILOBYTES, &words);
        assert_eq!((status, errors.lines().count()), (Some(2), 1), "{errors}");
    }
    let (status, errors) = with_memory(KILOBYTES, &["sim", "--faults=/dev/zero"]);
    assert_eq!(status, Some(2), "{errors}");
    assert!(errors.contains("at most 1048576 bytes"), "{errors}");
    let script = format!("ulimit -v {KILOBYTES}; yes noise | head -c 30000000 | \"$0\" decode -");
    let mut shell = Command::new("sh");
    let output = shell
        .args(["-c", &script, env!("CARGO_BIN_EXE_motionctl")])
        .output();
    let output = output.expect("a shell");
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert_eq!(text(&output.stderr).lines().count(), 1, "{output:?}");
    // A day of points far apart runs through its check in the memory of two points.
    let day = Scratch::new("day_allowed", "t,a\n0,0\n86400,2800000\n");
    let words = [
        &[
            "sim",
            "--trajectory",
            day.as_str(),
            "--max-duration",
            "86400",
        ][..],
        &["--cycle-us", "100000", "--max-step", "200"],
    ]
    .concat();
    let (status, errors) = with_memory(KILOBYTES, &words);
    assert_eq!(status, Some(2), "{errors}");
    assert!(errors.contains("raise --max-step"), "{errors}");
}

/// The frames of a log as the tool reads them: time in milliseconds, identifier, data; everything else by its kind.
fn frames(name: &str, log: impl AsRef<[u8]>, status: i32) -> Vec<String> {
    let log = Scratch::new(name, log);
    let output = motionctl(&["decode", "--json", log.as_str()]);
    assert_eq!(output.status.code(), Some(status), "{name}: {output:?}");
    let lines = text(&output.stdout)
        .lines()
        .map(|line| serde_json::from_str::<Value>(line).expect("JSON"));
    lines
        .filter(|line| matches!(line["kind"].as_str(), Some("frame" | "other" | "error")))
        .map(|line| {
            let ms = line["time_s"]
                .as_f64()
                .map_or("-".to_owned(), |s| format!("{:.3}", s * 1e3));
            match line["kind"].as_str() {
                Some("frame") => {
                    let remote = if line["remote"] == true {
                        " remote"
                    } else {
                        ""
                    };
                    format!(
                        "{ms} {:X} {}{remote}",
                        line["id"].as_u64().expect("an id"),
                        line["data"].as_str().expect("data")
                    )
                }
                Some("other") => format!(
                    "{ms} {}",
                    line["text"]
                        .as_str()
                        .expect("a text")
                        .split(':')
                        .next()
                        .unwrap_or_default()
                ),
                _ => format!("error in line {}", line["line"]),
            }
        })
        .collect()
}

#[test]
fn trc_by_the_names_of_its_columns() {
    let log = "; $FILEVERSION$\n;$FILEVERSION=2.1\n;$STARTTIME=46062.4\n;$COLUMNS=N,O,T,B,I,d,L,D\n      1         0.000 DT 1     0029 Rx 0    \n      2         0.621 DT 1     0029 Rx 1    00\n      3        10.000 DT 1     003C Tx 2    01 7F\n      4        11.000 DT 1     002E Rx 3    02 80 00\n";
    assert_eq!(
        frames("trc21_no_reserved", log, 0),
        [
            "0.000 29 ",
            "0.621 29 00",
            "10.000 3C 017F",
            "11.000 2E 028000"
        ]
    );
    let unknown = log.replace("N,O,T,B,I,d,L,D", "N,O,T,B,I,X,L,D");
    let file = Scratch::new("trc21_unknown", unknown);
    let output = motionctl(&["decode", file.as_str()]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let errors = text(&output.stderr);
    assert!(
        output.stdout.is_empty() && errors.lines().count() == 1,
        "{output:?}"
    );
    assert!(
        errors.contains(": line 4: expected the columns O, T, I"),
        "{errors}"
    );
}

#[test]
fn trc_of_peak() {
    let log = ";$FILEVERSION=1.1\n;$STARTTIME=46062.4\n;\n     1)         0.0  Tx         0029  0  \n     2)         0.6  Rx         0029  1  00 \n";
    assert_eq!(frames("trc11", log, 0), ["0.000 29 ", "0.600 29 00"]);
}

#[test]
fn classic_frames_and_errors_of_an_fd_channel() {
    let log = "date Sat Nov 28 10:00:00.000 am 2026\nbase hex  timestamps absolute\ninternal events logged\n// version 9.0.0\n   0.001132 CANFD   1 Tx         29  ReadStatus                        0 0 0  0   242136  60   200000      dbc 46500250 460a0250 20011736 20010205\n   0.001771 CANFD   1 Rx         29  Status                            0 0 1  1 21   230199  70   220000     62e7 46500250 460a0250 20011736 20010205\n   0.002900 CANFD   1 Rx ErrorFrame Not Acknowledge error, dominant error flag fffe c7 31ca Arb. 556 44 0 0 f 0 0 0 0 0 0 0 0 0\n";
    assert_eq!(
        frames("canoe_fd_channel", log, 0),
        ["1.132 29 ", "1.771 29 21", "2.900 error frame"]
    );
}

#[test]
fn events_of_an_asc_log() {
    let log = "date Sat Nov 28 10:00:00.000 2026\nbase hex  timestamps absolute\ninternal events logged\nBegin Triggerblock Sat Nov 28 10:00:00.000 2026\n   0.000000 Start of measurement\n   0.001000 1  29              Tx   d 0\n   0.001621 1  29              Rx   d 1 00\n   0.002 1 29 Tx r Length = 1704000 BitCount = 145 ID = 41\n   0.003 1 29 Rx d 9 00 01 02 03 04 05 06 07\n   0.004 1 29 Rx d F 00 01 02 03 04 05 06 07\n   0.005 CANFD   1 Rx  29   0 0 1 1 00 0 0 1000 0 0 0 0 0\n   0.006 CANFD   1 Rx  29   0 0 1 1 00 0 0 0 0 0 0 0 0\n   0.007 1  SomeTool FEE3p 6 0 0 - Rx d 1 00\n   0.008 2 OverloadFrame\n   0.009 CAN 1 Status:chip status error active\n   0.010 Log Trigger event\n   0.011 1 29 Rx d 1 00 Length = 111 BitCount = 57 ID = 41\nEnd TriggerBlock\n";
    assert_eq!(
        frames("asc_events", log, 0),
        [
            "1.000 29 ",
            "1.621 29 00",
            "2.000 29  remote",
            "3.000 29 0001020304050607",
            "4.000 29 0001020304050607",
            "5.000 CAN FD frame",
            "6.000 29 00",
            "8.000 overload frame",
            "9.000 the controller told its state",
            "11.000 29 00",
        ]
    );
}

#[test]
fn candump_without_times_has_an_order_only_and_says_so() {
    let log = "  can0  029   [0] \n  can0  029   [1]  00\n  can0  03C   [1]  82\n";
    assert_eq!(
        frames("candump_plain", log, 0),
        ["- 29 ", "- 29 00", "- 3C 82"]
    );
    let file = Scratch::new("candump_plain_words", log);
    let output = motionctl(&["decode", file.as_str()]);
    assert!(text(&output.stderr).contains("no times in this log: the order of its frames counts"));
    let words = text(&output.stdout);
    assert!(
        words.contains("can0: 3 frames; ") && !words.contains("after the request"),
        "{words}"
    );
}

#[test]
fn candump_with_dates_differences_and_colours() {
    let log = " (2026-11-28 10:00:00.000000)  \u{1b}[1m\u{1b}[34mcan0\u{1b}[0m  029   [0] \n (2026-11-28 10:00:00.000621)  \u{1b}[1m\u{1b}[34mcan0\u{1b}[0m  029   [1]  00\n";
    assert_eq!(
        frames("candump_ta", log, 0),
        ["1795860000000.000 29 ", "1795860000000.621 29 00"]
    );
    let log = " (000.000000)  can0  029   [0] \n (000.000621)  can0  029   [1]  00\n (000.019000)  can0  029   [0] \n (000.000622)  can0  029   [1]  00\n";
    assert_eq!(
        frames("candump_td", log, 0),
        ["0.000 29 ", "0.621 29 00", "19.621 29 ", "20.243 29 00"]
    );
}

#[test]
fn a_byte_order_mark_does_not_cost_the_first_line() {
    assert_eq!(
        frames(
            "bom_candump",
            "\u{feff}(0.0) can0 029#\n(0.1) can0 029#00\n",
            0
        ),
        ["0.000 29 ", "100.000 29 00"]
    );
}

#[test]
fn length_codes_of_candump() {
    let log = "(1.249713) can0 029#\n(1.250313) can0 029#00\n(1.251313) can0 03C#1122334455667788_B\n(1.252313) can0 029#R8_C\n(1.253313) can0 20000004#000C000000000000\n(1.254313) can0 029##100\n(1.255313) can0 00000029#00\n";
    assert_eq!(
        frames("candump_L_mixed", log, 0),
        [
            "1249.713 29 ",
            "1250.313 29 00",
            "1251.313 3C 1122334455667788",
            "1252.313 29  remote",
            "1253.313 error frame",
            "1254.313 CAN FD frame",
            "1255.313 29 00",
        ]
    );
}

#[test]
fn lines_of_a_log_count_as_an_editor_counts_them() {
    let log = "(0.0) can0 029#\r\n(0.1) can0 029#0\r\n\r\n(0.2) can0 029#0\r\n";
    assert_eq!(
        frames("crlf_log", log, 1),
        ["0.000 29 ", "error in line 2", "error in line 4"]
    );
    let long = format!(
        "(0.0) can0 029#\n{}\n(0.1) can0 029#0\n",
        "x".repeat(20_000)
    );
    assert_eq!(
        frames("long_line", long, 1),
        ["0.000 29 ", "error in line 2", "error in line 3"]
    );
}

#[test]
fn a_wrong_file_is_one_error() {
    let thousands = "42\n".repeat(5_000);
    let cases: [(&str, Vec<u8>); 8] = [
        ("numbers", thousands.clone().into()),
        ("ini", format!(";settings\n{thousands}").into()),
        (
            "asc",
            format!("date Sat Nov 28\n{}", "noise and more\n".repeat(5_000)).into(),
        ),
        ("printer", format!("Timestamp: now\n{thousands}").into()),
        ("brackets", "(see above)\n".repeat(5_000).into()),
        ("blf", b"LOGG\x90\0\0\0".repeat(500)),
        (
            "utf16",
            [&[0xFF, 0xFE][..], &b"(\x000\0)\0\n\0".repeat(500)].concat(),
        ),
        ("binary", b"\xA5".repeat(20_000)),
    ];
    for (name, bytes) in cases {
        for json in [false, true] {
            let log = Scratch::new(name, &bytes);
            let mut words = vec!["decode", log.as_str()];
            words.extend(json.then_some("--json"));
            let output = motionctl(&words);
            assert_eq!(output.status.code(), Some(2), "{name}: {output:?}");
            assert!(output.stdout.is_empty(), "{name}: {output:?}");
            let errors = text(&output.stderr);
            assert_eq!(errors.lines().count(), 1, "{name}: {errors}");
            assert!(
                errors.contains(": line ") && errors.contains("expected"),
                "{name}: {errors}"
            );
        }
    }
    // Behind frames that are read, noise is told in a few lines.
    let log = Scratch::new(
        "noise_behind",
        format!("(0.0) can0 029#\n{thousands}(0.1) can0 029#00\n"),
    );
    let output = motionctl(&["decode", log.as_str()]);
    assert_eq!(output.status.code(), Some(1));
    let errors = text(&output.stderr);
    assert_eq!(errors.lines().count(), 11, "{errors}");
    assert!(
        errors.contains(":12: and 4990 more, up to line 5001, cannot be read either"),
        "{errors}"
    );
    assert!(text(&output.stdout).contains("5000 damaged lines"));
}

#[test]
fn a_reader_that_has_seen_enough_ends_decode_quietly() {
    let log = Scratch::new("head", "(0.0) can0 029#\n(0.1) can0 029#0\n".repeat(50_000));
    let mut child = Command::new(env!("CARGO_BIN_EXE_motionctl"))
        .args(["decode", log.as_str()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("motionctl runs");
    // Both pipes are closed at once, as by `2>&1 | head -1`.
    drop(child.stdout.take());
    drop(child.stderr.take());
    let status = child.wait().expect("an end");
    assert_eq!(status.code(), Some(0));
    let mut child = Command::new(env!("CARGO_BIN_EXE_motionctl"))
        .args(["decode", "--json", log.as_str()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("motionctl runs");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("an end");
    assert_eq!((output.status.code(), text(&output.stderr)), (Some(0), ""));
}

#[test]
fn the_table_of_formats_names_tests_that_exist() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let readme = std::fs::read_to_string(root.join("README.md")).expect("the README");
    let table = readme
        .lines()
        .skip_while(|line| !line.starts_with("| File | Written by |"));
    let rows: Vec<&str> = table
        .skip(2)
        .take_while(|line| line.starts_with('|'))
        .collect();
    assert!(rows.len() >= 10, "{rows:?}");
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        assert!(!cells[2].is_empty(), "no program writes {row}");
        let names: Vec<&str> = cells[3].split('`').skip(1).step_by(2).collect();
        let [file, tests @ ..] = &names[..] else {
            panic!("no test reads {row}");
        };
        let code = std::fs::read_to_string(root.join(file)).expect("a file of tests");
        assert!(!tests.is_empty(), "{row}");
        for test in tests {
            assert!(
                code.contains(&format!("#[test]\nfn {test}()")),
                "no test {test} in {file}"
            );
        }
    }
}
