//! `motionctl keyframes`: what the board plays with the file that was written, beside the set-points of the same program on the bus.

mod tool;

use tool::{Scratch, bus, motionctl, text};

/// As a configuration of the firmware includes it.
mod board {
    include!("../../../firmware-tests/configs/slot.rs");
}

const FILE: &str = "firmware-tests/configs/slot.rs";
const PROGRAM: &str = "examples/programs/slot.ngc";
const OPTIONS: [&str; 10] = [
    "--axes",
    "2",
    "--mm-per-turn",
    "5",
    "--axis-rpm",
    "1500",
    "--axis-acceleration",
    "12000",
    "--axis-jerk",
    "300000",
];

/// A path from the root of the project.
fn rooted(path: &str) -> String {
    format!("{}/../../{path}", env!("CARGO_MANIFEST_DIR"))
}

/// Between the board, from a cycle on, and the bus.
fn worst_difference(axes: &[Vec<f64>], start: u64) -> f64 {
    let mut worst = 0.0_f64;
    for axis in 0..2 {
        for (cycle, on_the_bus) in (0_u64..).zip(&axes[axis]) {
            let at = board::MOTION.position(cycle.saturating_sub(start) * 1_000);
            worst = worst.max((f64::from(at[axis]) - on_the_bus).abs());
        }
    }
    worst
}

#[test]
fn the_board_plays_the_program() {
    let log = Scratch::new("keyframes.log", "");
    let program = rooted(PROGRAM);
    let mut words = vec!["sim", "--program", &program, "--candump", log.as_str()];
    words.extend(OPTIONS);
    let output = motionctl(&words);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let axes = bus::positions(log.as_str(), 2);
    let cycles = axes[0].len();
    let duration = usize::try_from(board::MOTION.duration_us() / 1_000).expect("a short one");
    assert!((1_000..cycles).contains(&duration), "{cycles} {duration}");
    // The drives are held for some cycles before the motion starts.
    let starts = (0..200).map(|start| (worst_difference(&axes, start), start));
    let (worst, start) = starts.min_by(|a, b| a.0.total_cmp(&b.0)).expect("one");
    assert_eq!(worst, 1.0, "with {start} cycles before it");
    let peaks = board::MOTION.peak_step_counts(1_000);
    let mut before = [0, 0];
    for cycle in 0..duration as u64 {
        let at = board::MOTION.position(cycle * 1_000);
        for axis in 0..2 {
            assert!(u64::from(at[axis].abs_diff(before[axis])) <= peaks[axis]);
        }
        before = at;
    }
    assert_eq!(board::MOTION.position(u64::MAX), [0, 0]);
    assert_eq!(board::MOTION_DRIVES, [(1, 4_096), (2, 4_096)]);
}

#[test]
fn the_file_is_what_the_command_writes() {
    let written = Scratch::new("slot.rs", "");
    let program = rooted(PROGRAM);
    let mut words = vec![
        "keyframes",
        written.as_str(),
        "--force",
        "--json",
        "--program",
        &program,
    ];
    words.extend(OPTIONS);
    let output = motionctl(&words);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let bytes = json["flash_bytes"].as_u64().expect("a number");
    let keyframes = json["keyframes"].as_u64().expect("a number");
    // A time, and for each of two motors a position and a velocity.
    assert_eq!(bytes, 20 * keyframes);
    assert!(keyframes < 120, "{keyframes}");
    assert_eq!(json["worst_difference_counts"], 1);
    let [new, committed] = [written.as_str(), &rooted(FILE)].map(|path| {
        let file = std::fs::read_to_string(path).expect("a file");
        file.replace(&program, PROGRAM)
    });
    assert_eq!(
        new, committed,
        "make {FILE} anew with `motionctl keyframes`"
    );
}

fn refused(program: &str, more: &[&str]) -> String {
    let file = Scratch::new("refused.ngc", program);
    let target = Scratch::new("refused.rs", "unchanged");
    let mut words = vec!["keyframes", target.as_str(), "--program", file.as_str()];
    words.extend(["--axes", "1", "--mm-per-turn", "5"]);
    words.extend(more);
    let output = motionctl(&words);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let content = std::fs::read_to_string(target.as_str()).expect("the file");
    assert_eq!(content, "unchanged");
    text(&output.stderr).to_owned()
}

#[test]
fn what_the_board_cannot_play_is_refused_and_nothing_is_written() {
    let back = "G1 X5 F600\nG28\n";
    assert!(refused(back, &[]).contains("--force"));
    let forced = |program: &str, more: &[&str]| refused(program, &[&["--force"], more].concat());
    let error = forced("G1 X5 F600\n", &[]);
    assert!(error.contains("X ends 16384 counts from there"), "{error}");
    let error = forced("G1 X5 F600\nG7\n", &[]);
    assert!(
        error.contains("line 2, column 1: G7 is not known"),
        "{error}"
    );
    let error = forced(back, &["--cycle-us", "333"]);
    assert!(
        error.contains("they stand at whole milliseconds"),
        "{error}"
    );
    let error = forced(back, &["--tolerance-counts", "0.1"]);
    assert!(error.contains("expected 0.75 to 100 counts"), "{error}");
    let output = motionctl(&["keyframes", "/tmp/none.rs"]);
    assert!(
        text(&output.stderr).contains("expected --program FILE"),
        "{output:?}"
    );
}
