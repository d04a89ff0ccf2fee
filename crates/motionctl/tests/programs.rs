//! Programs of G-code on simulated drives, judged by the frames on the bus: finite differences within the limits, and the distance to the
//! geometry that the programs were written from. The judge shares nothing with what makes the set-points.

#[path = "../../path/tests/independent/judge.rs"]
mod judge;
mod tool;

use core::f64::consts::TAU;
use core::fmt::Write as _;

use judge::{Ideal, judge};
use tool::{Scratch, bus, motionctl, text};

/// A screw of 5 mm with 16384 counts a turn.
const COUNTS_PER_MM: f64 = 3_276.8;
const TURN: f64 = 16_384.0;
const UM: f64 = 1_000.0;

/// Limits of every axis, in r/min, per second and per second².
#[derive(Clone, Copy)]
struct Motor {
    rpm: f64,
    acceleration: f64,
    jerk: f64,
}

const SLOW: Motor = Motor {
    rpm: 1_500.0,
    acceleration: 12_000.0,
    jerk: 300_000.0,
};
const FAST: Motor = Motor {
    rpm: 3_000.0,
    acceleration: 60_000.0,
    jerk: 2_400_000.0,
};

/// Text and ideal geometry, written side by side: millimetres.
struct Program {
    text: String,
    ideal: Ideal,
    at: [f64; 3],
}

impl Program {
    fn new(header: &str) -> Self {
        Self {
            text: format!("G21 G90 G17 {header}\n"),
            ideal: Ideal::at([0.0; 3]),
            at: [0.0; 3],
        }
    }

    fn to(&mut self, x: f64, y: f64, z: f64) {
        // As it is written, to a tenth of a micrometre.
        let [x, y, z] = [x, y, z].map(|value| (value * 1e4).round() / 1e4);
        let _ = writeln!(self.text, "G1 X{x:.4} Y{y:.4} Z{z:.4}");
        self.at = [x, y, z];
        self.ideal.line(self.at.map(|mm| mm * UM));
    }

    /// An arc around a centre; turns below one, positive counterclockwise.
    fn arc(&mut self, centre: [f64; 2], turns: f64, z: f64) {
        let [x, y, _] = self.at;
        let (i, j) = (
            ((centre[0] - x) * 1e4).round() / 1e4,
            ((centre[1] - y) * 1e4).round() / 1e4,
        );
        let centre = [x + i, y + j];
        let angle = (y - centre[1]).atan2(x - centre[0]) + turns * TAU;
        let radius = i.hypot(j);
        let end = [
            centre[0] + radius * angle.cos(),
            centre[1] + radius * angle.sin(),
            z,
        ];
        let end = if turns.abs() == 1.0 {
            [x, y, z]
        } else {
            end.map(|value| (value * 1e4).round() / 1e4)
        };
        let word = if turns > 0.0 { "G3" } else { "G2" };
        let _ = writeln!(
            self.text,
            "{word} X{:.4} Y{:.4} Z{:.4} I{i:.4} J{j:.4}",
            end[0], end[1], end[2]
        );
        self.at = end;
        let centre = centre.map(|mm| mm * UM);
        self.ideal.arc(centre, turns, end.map(|mm| mm * UM));
    }
}

fn options(motor: Motor) -> Vec<String> {
    [
        ("--mm-per-turn", 5.0),
        ("--axis-rpm", motor.rpm),
        ("--axis-acceleration", motor.acceleration),
        ("--axis-jerk", motor.jerk),
    ]
    .into_iter()
    .flat_map(|(name, value)| [name.to_owned(), value.to_string()])
    .collect()
}

/// Runs a program and judges it. Returns the largest distance from the ideal path in counts, and the number of cycles.
fn run(name: &str, program: &Program, motor: Motor, tolerance_mm: f64) -> (f64, usize) {
    let file = Scratch::new(name, &program.text);
    let log = Scratch::new(&format!("{name}-log"), "");
    let options = options(motor);
    let mut words = vec![
        "sim",
        "--json",
        "--program",
        file.as_str(),
        "--candump",
        log.as_str(),
    ];
    words.extend(options.iter().map(String::as_str));
    let output = motionctl(&words);
    assert_eq!(
        output.status.code(),
        Some(0),
        "{name}: {}",
        text(&output.stderr)
    );
    let axes = bus::positions(log.as_str(), 3);
    let cycle_s = 1e-3;
    let limit = |value: f64, power: i32| value / 60.0 * TURN * f64::powi(cycle_s, power);
    let limits = [
        limit(motor.rpm, 1),
        limit(motor.acceleration, 2),
        limit(motor.jerk, 3),
    ];
    judge(name, &axes, &[limits; 3], 0.5);
    let places: Vec<[f64; 3]> = (0..axes[0].len())
        .map(|cycle| [0, 1, 2].map(|axis| axes[axis][cycle] / COUNTS_PER_MM * UM))
        .collect();
    let deviation_um = program.ideal.deviation(&places);
    // Rounding to whole counts moves a place by up to half a count in three directions.
    let rounding_um = 0.87 / COUNTS_PER_MM * UM;
    assert!(
        deviation_um <= tolerance_mm * UM + rounding_um + 0.1,
        "{name}: {deviation_um} um, the tolerance is {tolerance_mm} mm"
    );
    let end = places.last().expect("a place");
    for (end, target) in end.iter().zip(program.at) {
        assert!(
            (end - target * UM).abs() <= 0.6 / COUNTS_PER_MM * UM,
            "{name}: {end} {target}"
        );
    }
    (deviation_um / UM * COUNTS_PER_MM, axes[0].len())
}

#[test]
fn a_circle_is_within_two_counts() {
    let mut program = Program::new("F12000");
    program.arc([50.0, 0.0], -1.0, 0.0);
    let (deviation, cycles) = run("circle", &program, FAST, 0.0);
    assert!(deviation <= 2.0, "{deviation} counts");
    // 314 mm at 200 mm/s, and the time to get there.
    assert!((1_571..2_200).contains(&cycles), "{cycles}");
}

#[test]
fn a_square_is_within_its_tolerance() {
    for (name, header, tolerance) in [
        ("square-exact", "G61 F9000", 0.0),
        ("square-tight", "G64 P0.02 F9000", 0.02),
        ("square-wide", "G64 P0.5 F9000", 0.5),
    ] {
        let mut program = Program::new(header);
        for (x, y) in [(50.0, 0.0), (50.0, 50.0), (0.0, 50.0), (0.0, 0.0)] {
            program.to(x, y, 0.0);
        }
        let (deviation, _) = run(name, &program, FAST, tolerance);
        // The corners are blended indeed.
        assert!(
            deviation / COUNTS_PER_MM >= 0.5 * tolerance,
            "{name}: {deviation}"
        );
    }
}

/// Micrometre lines: a circle of 10 mm in chords, and a wave.
#[test]
fn micro_segments() {
    let mut program = Program::new("G64 P0.01 F1800");
    program.to(1.0, 0.0, 0.0);
    for k in 1..=900 {
        let angle = f64::from(k) * 0.007;
        program.to(1.0 + 5.0 * angle.sin(), 5.0 - 5.0 * angle.cos(), 0.0);
    }
    run("chords", &program, SLOW, 0.01);
    let mut program = Program::new("G64 P0.005 F1200");
    for k in 1..=1_500 {
        let x = f64::from(k) * 0.004;
        program.to(x, 0.3 * (3.0 * x).sin(), 0.05 * (2.0 * x).sin());
    }
    run("wave", &program, FAST, 0.005);
    let mut program = Program::new("G61 F600");
    for k in 1..=60 {
        program.to(f64::from(k) * 0.003, f64::from(k % 2) * 0.002, 0.0);
    }
    run("micro-exact", &program, FAST, 0.0);
    // Lines shorter than a count, and some of no length.
    let mut program = Program::new("G64 P0.01 F600");
    for k in 1..=300 {
        program.to(f64::from(k / 3) * 0.000_2, f64::from(k) * 0.000_1, 0.0);
    }
    run("below-a-count", &program, SLOW, 0.01);
}

#[test]
fn tiny_arcs() {
    for (name, header, tolerance) in [
        ("tiny-arcs", "G64 P0.005 F1200", 0.005),
        ("tiny-arcs-exact", "G61 F1200", 0.0),
    ] {
        let mut program = Program::new(header);
        for k in 0..40 {
            let x = f64::from(k) * 0.06;
            program.arc(
                [x + 0.03, program.at[1]],
                if k % 2 == 0 { 0.5 } else { -0.5 },
                0.0,
            );
        }
        run(name, &program, FAST, tolerance);
    }
    let mut program = Program::new("G64 P0.02 F3000");
    for k in 0..24 {
        let [x, y, _] = program.at;
        program.arc([x, y + 0.1], 1.0, 0.0);
        program.to(0.5 * f64::from(k + 1), 0.0, 0.0);
    }
    run("beads", &program, SLOW, 0.02);
}

#[test]
fn sharp_corners_and_reversals() {
    let mut program = Program::new("G64 P0.05 F12000");
    for k in 1..=24 {
        let angle = f64::from(k) * 2.2;
        program.to(15.0 * angle.cos() - 15.0, 15.0 * angle.sin(), 0.0);
    }
    run("star", &program, FAST, 0.05);
    let mut program = Program::new("G64 P0.05 F12000");
    for k in 1..=24 {
        let angle = f64::from(k) * 3.05;
        program.to(8.0 * angle.cos() - 8.0, 8.0 * angle.sin(), 0.0);
    }
    run("needles", &program, SLOW, 0.05);
    let mut program = Program::new("G64 P0.05 F12000");
    for k in 0..20 {
        program.to(if k % 2 == 0 { 4.0 } else { 0.0 }, 0.0, 0.0);
    }
    run("reversals", &program, FAST, 0.0);
    let mut program = Program::new("G64 P0.1 F12000");
    for k in 1..=40 {
        program.to(
            f64::from(k) * 0.5,
            f64::from(k % 2) * 6.0,
            f64::from(k % 3) * 0.7,
        );
    }
    run("zigzag", &program, FAST, 0.1);
    let mut program = Program::new("G64 P0.1 F12000");
    for k in 1..=60_i32 {
        // From micrometres to centimetres and back.
        let length = 10_f64.powi((k % 7) - 4 + i32::from(k % 7 > 4) * (4 - k % 7));
        let angle = f64::from(k) * 1.3;
        let [x, y, _] = program.at;
        program.to(x + length * angle.cos(), y + length * angle.sin(), 0.0);
    }
    run("mixed-lengths", &program, SLOW, 0.1);
}

#[test]
fn spirals_and_helices() {
    let mut program = Program::new("G64 P0.02 F6000");
    program.to(0.5, 0.0, 0.0);
    for k in 1..=2_400 {
        let angle = f64::from(k) * 0.05;
        let radius = 0.5 + 0.01 * angle;
        program.to(radius * angle.cos(), radius * angle.sin(), 0.001 * angle);
    }
    run("spiral", &program, FAST, 0.02);
    let mut program = Program::new("G64 P0.02 F6000");
    for k in 0..30 {
        program.arc([6.0, 0.0], 1.0, f64::from(k + 1) * 0.4);
    }
    run("helix", &program, FAST, 0.02);
    let mut program = Program::new("G64 P0.02 F6000");
    for k in 0..24 {
        // Half circles that grow: a spiral of arcs, whose curvature jumps.
        let [x, y, z] = program.at;
        let radius = 1.0 + 0.3 * f64::from(k);
        let side = if k % 2 == 0 { 1.0 } else { -1.0 };
        program.arc([x + side * radius, y], 0.5, z + 0.05);
    }
    run("arc-spiral", &program, SLOW, 0.02);
}

#[test]
fn lines_into_arcs() {
    for (name, header, tolerance) in [
        ("slot", "G64 P0.01 F6000", 0.01),
        ("slot-exact", "G61 F6000", 0.0),
    ] {
        let mut program = Program::new(header);
        program.to(30.0, 0.0, 0.0);
        program.arc([30.0, 8.0], 0.5, 0.0);
        program.to(0.0, 16.0, 1.0);
        program.arc([0.0, 8.0], 0.5, 0.0);
        run(name, &program, FAST, tolerance);
    }
    let mut program = Program::new("G64 P0.05 F6000");
    for k in 0..12 {
        let [x, y, _] = program.at;
        program.to(x + 3.0, y, 0.0);
        program.arc(
            [x + 3.0, y + 1.0],
            if k % 2 == 0 { 0.75 } else { 0.25 },
            0.0,
        );
    }
    run("keyholes", &program, SLOW, 0.05);
}

fn refused(name: &str, program: &str, more: &[&str]) -> String {
    let file = Scratch::new(name, program);
    let options = options(SLOW);
    let mut words = vec!["sim", "--program", file.as_str()];
    words.extend(options.iter().map(String::as_str));
    words.extend(more);
    let output = motionctl(&words);
    assert_eq!(output.status.code(), Some(2), "{name}: {output:?}");
    assert!(output.stdout.is_empty(), "nothing may run: {output:?}");
    text(&output.stderr)
        .replace(file.as_str(), "FILE")
        .trim()
        .to_owned()
}

#[test]
fn a_long_program_runs_in_bounded_memory_and_a_broken_one_does_not_start() {
    let mut program = String::from("G21 G90 G64 P0.01 F24000\n");
    for k in 0..100_000 {
        let _ = writeln!(
            program,
            "G1 X{:.3} Y{:.3}",
            f64::from(k % 200) * 0.005,
            f64::from(k / 200 % 50) * 0.02
        );
    }
    let file = Scratch::new("long", &program);
    let options = options(FAST);
    let mut words = vec![
        "sim",
        "--json",
        "--program",
        file.as_str(),
        "--max-duration",
        "86400",
        "--status-hz",
        "1",
        "--position-hz",
        "1",
    ];
    words.extend(options.iter().map(String::as_str));
    let output = motionctl(&words);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(json["motion"]["lines"], 100_001);
    // The last line, with an unknown word.
    program.push_str("G1 X1 Q5\n");
    assert_eq!(
        refused("broken", &program, &["--max-duration", "86400"]),
        "error: FILE: line 100002, column 7: Q is not known: expected one of F G I J K M N P R X Y Z"
    );
}

#[test]
fn what_cannot_be_run_is_refused_before_anything_moves() {
    assert_eq!(
        refused("unknown", "G0 X1\nG1 X2 F100\nG5 X3\n", &[]),
        "error: FILE: line 3, column 1: G5 is not known: expected G0 to G4, G17 to G21, G28, G61, G64, G90, G91, M0, M2 or M30"
    );
    assert_eq!(
        refused("axis", "G0 X1\nG0 Z2\n", &["--axes", "2"]),
        "error: FILE: line 2, column 4: the machine has no axis Z"
    );
    assert!(refused("pause", "G0 X1\nM0\n", &[]).contains("line 2: M0 waits"));
    assert!(refused("dwells", "G4 P3600\nG4 P3600\n", &[]).contains("lasts longer than 3600 s"));
    assert!(
        refused("far", "G0 X50000\n", &["--max-duration", "86400"]).contains("X must stay within")
    );
    assert!(
        refused("step", "G0 X100\n", &["--max-step", "100"])
            .contains("at most 100 counts in a cycle")
    );
    let output = motionctl(&["sim", "--program", "/nowhere.ngc", "--mm-per-turn", "5"]);
    assert_eq!(output.status.code(), Some(2));
    let file = Scratch::new("no-scale", "G0 X1\n");
    let output = motionctl(&["sim", "--program", file.as_str()]);
    assert!(text(&output.stderr).contains("--mm-per-turn"), "{output:?}");
}

#[test]
fn a_byte_order_mark_and_other_ends_of_lines_mean_nothing() {
    let file = Scratch::new("windows", "\u{feff}G21 G90\r\nG1 X1 F600\r\nM2\r\n");
    let mut words = vec!["sim", "--json", "--program", file.as_str()];
    let options = options(SLOW);
    words.extend(options.iter().map(String::as_str));
    let output = motionctl(&words);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(json["motion"]["moves"], 1);
    // Only in front of everything.
    assert_eq!(
        refused("mark", "G21\n\u{feff}G1 X1 F600\n", &[]),
        "error: FILE: line 2, column 1: '\\u{feff}' belongs to no word"
    );
}
