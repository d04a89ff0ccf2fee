//! `motionctl decode` as a user runs it: words, JSON, damaged logs, exit status.

mod tool;

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Command, Output, Stdio};

use tool::{Scratch, text};

fn motionctl(words: &[&str], file: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_motionctl"));
    command
        .args(words)
        .arg(file)
        .output()
        .expect("motionctl runs")
}

/// The log of a simulated run of two axes.
fn simulated_run(name: &str) -> Scratch {
    let motion = Scratch::new(
        &format!("{name}.csv"),
        b"time_s,a,b\n0,0,0\n0.1,180,-90\n0.2,360,-180\n",
    );
    let log = Scratch::new(&format!("{name}.log"), b"");
    let path = motion.0.to_str().expect("a path of plain text");
    let arguments = ["sim", "--trajectory", path, "--json", "--candump"];
    let output = motionctl(&arguments, &log.0);
    assert!(output.status.success(), "{output:?}");
    log
}

#[test]
fn a_simulated_run_is_put_into_words_without_one_unknown() {
    let log = simulated_run("words");
    let output = motionctl(&["decode"], &log.0);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(output.stderr.is_empty(), "{output:?}");
    let words = text(&output.stdout);
    for unwanted in [
        "unknown",
        "does not decode",
        "not of a drive",
        "nobody asked",
        "without a reply",
    ] {
        assert!(!words.contains(unwanted), "{unwanted}");
    }
    for wanted in [
        "to drive 1    Echo_Function: send back",
        "from drive 2  Read_Param_Group3: on-position range 20 (0.44 degrees), gear number 4096",
        "to drive 1    Read_Drive_Config: read the configuration",
        "to drive 2    Go_Relative_Pos_PD: step by",
        "from drive 1  General_Read: position",
        " 0 did not decode, 0 look like trouble, 0 error frames, 0 CAN FD frames",
        "\n0 damaged lines\n",
    ] {
        assert!(words.contains(wanted), "{wanted}");
    }
    let lines_of_log = std::fs::read_to_string(&log.0)
        .expect("the log")
        .lines()
        .count();
    let lines_of_frames = words
        .lines()
        .filter(|line| line.contains("  can0 "))
        .count();
    assert_eq!(lines_of_frames, lines_of_log);
}

#[test]
fn json_has_one_object_a_line_with_the_statistics_at_the_end() {
    let log = simulated_run("json");
    let output = motionctl(&["decode", "--json"], &log.0);
    let lines: Vec<serde_json::Value> = text(&output.stdout)
        .lines()
        .map(|line| serde_json::from_str(line).expect("JSON"))
        .collect();
    let steps = |drive: u8| -> i64 {
        let of_drive = lines.iter().filter(|line| line["drive"] == drive);
        of_drive
            .filter_map(|line| line["step_counts"].as_i64())
            .sum()
    };
    // One turn of 16384 counts, and half a turn back: the log alone tells it.
    assert_eq!((steps(1), steps(2)), (16_384, -8_192));
    assert_eq!(lines.last().expect("a line")["kind"], "end");
    let last = &lines[lines.len() - 2];
    assert_eq!(
        (&last["kind"], &last["undecodable_frames"]),
        (&"statistics".into(), &0.into())
    );
    let frames = lines.iter().filter(|line| line["kind"] == "frame").count();
    assert_eq!(last["frames"], frames);
}

#[test]
fn only_what_is_asked_for_is_shown() {
    let log = simulated_run("filter");
    let one = motionctl(&["decode", "--drive", "2"], &log.0);
    let words = text(&one.stdout);
    assert!(words.contains("drive 2  ") && !words.contains("to drive 1  "));
    let none = motionctl(&["decode", "--statistics-only"], &log.0);
    assert!(!text(&none.stdout).contains("drive 2  "));
    assert!(text(&none.stdout).contains("Go_Relative_Pos_PD"));

    let trouble = Scratch::new(
        "trouble.log",
        b"(1.000000) can0 03C#88\n(1.000090) can0 03C#88\n(1.001000) can0 03C#88\n(1.001500) can0 03D#EE\n",
    );
    let output = motionctl(&["decode", "--trouble"], &trouble.0);
    let shown: Vec<&str> = text(&output.stdout)
        .lines()
        .filter(|line| line.contains("drive 1"))
        .collect();
    assert_eq!(shown.len(), 2, "{shown:?}");
    assert!(shown[0].contains("the same frame as 0.090 ms before") && shown[1].contains("ALARM"));
    assert!(text(&output.stdout).contains("2 look like trouble"));
}

#[test]
fn a_damaged_log_is_read_to_its_end_and_every_damage_is_named() {
    let log = Scratch::new(
        "damaged.log",
        b"(1.000000) can0 029#\n(1.000500) can0 029#0\n\xFF\xFE\n(1.000700) can0 029#02\n(0.900000) can0 03C#88\n(1.00",
    );
    let output = motionctl(&["decode"], &log.0);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let path = log.0.display();
    let errors: Vec<&str> = text(&output.stderr).lines().collect();
    assert_eq!(
        errors,
        [
            format!("{path}:2: expected a data byte, got \"0\""),
            format!("{path}:3: expected a time in brackets, got \"\u{fffd}\u{fffd}\""),
            format!(
                "{path}:5: time goes back from 1.000700 s to 0.900000 s: replies may be taken for others"
            ),
            format!("{path}:6: expected a time in brackets, got \"(1.00\""),
        ]
    );
    let words = text(&output.stdout);
    assert!(
        words.contains("on position, disabled, no alarm (0.700 ms after the request)"),
        "{words}"
    );
    assert!(
        words.contains("3 frames in") && words.contains("4 damaged lines"),
        "{words}"
    );
}

#[test]
fn each_interface_is_a_bus_of_its_own() {
    let log = Scratch::new(
        "two.log",
        b"(1.000000) can0 02E#1B\n(1.000100) can1 02E#1E\n(1.000600) can0 02E#0A\n(1.000700) can1 02E#0A\n",
    );
    let output = motionctl(&["decode"], &log.0);
    let words = text(&output.stdout);
    for wanted in [
        "can0  02E 0A                       from drive 1  General_Read: position 10 counts",
        "can1  02E 0A                       from drive 1  General_Read: torque 10 of 981",
        "can0: 2 frames",
        "can1: 2 frames",
    ] {
        assert!(words.contains(wanted), "{wanted} in\n{words}");
    }
}

#[test]
fn what_comes_through_a_pipe_is_shown_before_the_pipe_ends() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_motionctl"))
        .args(["decode", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .expect("motionctl runs");
    let mut log = child.stdin.take().expect("a pipe");
    let mut words = BufReader::new(child.stdout.take().expect("a pipe"));
    writeln!(log, "(1.000000) can0 03C#88").expect("a line");
    let mut line = String::new();
    // Waits for ever, and so fails, if the line is kept back: the log has not ended yet.
    words.read_line(&mut line).expect("a line");
    assert!(line.contains("step by -120 counts"), "{line}");
    drop(log);
    assert!(child.wait().expect("an end").success());
}

#[test]
fn what_is_no_log_is_refused() {
    let few = Scratch::new("few.txt", b"time_s,a,b\n0,0,0\n");
    let binary = Scratch::new("binary.blf", [0xA5; 200_000]);
    for file in [&few, &binary] {
        let output = motionctl(&["decode"], &file.0);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        let errors: Vec<&str> = text(&output.stderr).lines().collect();
        assert_eq!(errors.len(), 1, "one error for a wrong file: {errors:?}");
        assert!(errors[0].contains(": line 1: expected a "), "{errors:?}");
        assert!(output.stdout.is_empty(), "{output:?}");
    }
    let missing = motionctl(&["decode"], Path::new("no-such-file.log"));
    assert_eq!(missing.status.code(), Some(2));
    assert!(text(&missing.stderr).contains("cannot read no-such-file.log"));
}

#[test]
fn a_log_without_a_frame_says_so() {
    for (name, bytes) in [
        ("empty.log", &b""[..]),
        ("blank.log", b"\n\n"),
        (
            "header.trc",
            b";$FILEVERSION=1.1\n;   Start time: 28.11.2026\n",
        ),
    ] {
        let log = Scratch::new(name, bytes);
        let output = motionctl(&["decode"], &log.0);
        assert_eq!(output.status.code(), Some(0), "{name}: {output:?}");
        let errors = text(&output.stderr);
        assert_eq!(
            errors, "note: no frame and no error of a bus, so there is nothing to show\n",
            "{name}"
        );
    }
}

#[test]
fn options_that_no_bus_has_are_refused() {
    let log = Scratch::new("options.log", b"(1.0) can0 029#\n");
    for (option, value, range) in [
        ("--drive", "128", "0..=127"),
        ("--bit-rate", "0", "1..=1000"),
    ] {
        let output = motionctl(&["decode", option, value], &log.0);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        let errors = text(&output.stderr);
        assert!(
            errors.contains(&format!("{value} is not in {range}")),
            "{errors}"
        );
    }
}
