//! `motionctl run --program` against `motionctl bench`: to its end, with orders on the way, and what is refused.

use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::process::Child;

use serde_json::Value;

use crate::bench::{
    BenchProcess, Scratch, interrupt, motionctl, scratch, start_and_wait_for, status_and_errors,
    wait_until,
};
use crate::undisturbed::undisturbed;

/// A screw of 5 mm with 16384 counts a turn.
const COUNTS_PER_MM: f64 = 3_276.8;
/// 10 mm/s in X and half of it in Y: X is always twice Y.
const LINE: &str = "G21 G90\nG1 X60 Y30 F670\nM2\n";

fn arguments<'a>(bench: &'a BenchProcess, file: &'a Scratch) -> Vec<&'a str> {
    vec![
        "run",
        "--slcan",
        bench.path(),
        "--program",
        file.path(),
        "--axes",
        "2",
        "--mm-per-turn",
        "5",
        "--max-rpm",
        "500",
        "--max-acceleration",
        "10000",
        "--max-turns",
        "20",
        "--yes",
    ]
}

fn received(report: &Value) -> [i64; 2] {
    [0, 1].map(|drive: usize| {
        let counts = &report["drives"][drive]["received_counts"];
        counts.as_i64().expect("a number")
    })
}

fn counts(mm: f64) -> i64 {
    (mm * COUNTS_PER_MM).round() as i64
}

/// On the line, to the rounding of either axis.
fn is_on_the_line([x, y]: [i64; 2]) -> bool {
    (x - 2 * y).abs() <= 2
}

/// Orders at the socket of a run.
struct Orders(BufReader<UnixStream>);

impl Orders {
    fn ask(&mut self, order: &str) -> String {
        writeln!(self.0.get_mut(), "{order}").expect("it listens");
        let mut answer = String::new();
        self.0.read_line(&mut answer).expect("it answers");
        answer.trim().to_owned()
    }

    /// The cycle of the motion.
    fn cycle(&mut self) -> u64 {
        let status = self.ask("status");
        let mut words = status.split_whitespace();
        let cycle = words.find_map(|word| word.strip_prefix("cycle="));
        cycle.and_then(|cycle| cycle.parse().ok()).expect("a cycle")
    }

    fn until(&mut self, what: &str) {
        wait_until(what, || self.ask("status").contains(what));
    }
}

/// A run that listens at a socket, once it moves.
fn with_orders(bench: &BenchProcess, file: &Scratch, name: &str, more: &[&str]) -> (Child, Orders) {
    let socket = scratch(name);
    let place = format!("unix:{}", socket.display());
    let mut words = arguments(bench, file);
    words.extend(["--control", &place]);
    words.extend(more);
    let child = start_and_wait_for(motionctl(&words), "the motion starts");
    let stream = UnixStream::connect(&socket).expect("it listens");
    (child, Orders(BufReader::new(stream)))
}

#[test]
fn a_program_runs_to_its_end() {
    undisturbed(|| {
        let bench = BenchProcess::start("program", "1,2");
        let file = Scratch::new(
            "program.ngc",
            "G21 G90 G64 P0.2\nG1 X5 F900\nY5\nG3 X0 Y5 I-2.5 J0\nG1 X1 Y1\nM2\n",
        );
        let mut words = arguments(&bench, &file);
        words.push("--json");
        let output = motionctl(&words).output().expect("motionctl runs");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let summary: Value = serde_json::from_slice(&output.stdout).expect("JSON");
        assert_eq!(summary["completed"], true, "{summary}");
        assert_eq!(received(&bench.stop()), [counts(1.0); 2]);
    });
}

/// Two motors on X, and a play of Y that is given back at the end.
#[test]
fn a_program_runs_on_a_gantry() {
    undisturbed(|| {
        let bench = BenchProcess::start("program-gantry", "1-3");
        let file = Scratch::new(
            "program-gantry.ngc",
            "G21 G90 G64 P0.2\nG1 X3 Y1 F600\nY0\nM2\n",
        );
        let motor = |drive: u8, axis: char, more: &str| {
            format!("[[motor]]\ndrive = {drive}\naxis = \"{axis}\"\ncounts-per-mm = {more}\n")
        };
        let machine = Scratch::new(
            "program-gantry.toml",
            &[
                "machine = \"gantry\"\n",
                &motor(1, 'X', "3276.8"),
                &motor(2, 'X', "-3276.8"),
                &motor(3, 'Y', "3276.8\nbacklash-mm = 0.05"),
            ]
            .concat(),
        );
        let mut words = vec!["run", "--slcan", bench.path(), "--program", file.path()];
        words.extend(["--machine", machine.path(), "--yes", "--json"]);
        words.extend(["--max-acceleration", "10000"]);
        let output = motionctl(&words).output().expect("motionctl runs");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let report = bench.stop();
        let received = [0, 1, 2].map(|drive: usize| {
            let counts = &report["drives"][drive]["received_counts"];
            counts.as_i64().expect("a number")
        });
        assert_eq!(received, [counts(3.0), -counts(3.0), 0]);
    });
}

#[test]
fn a_program_is_paused_and_overridden_and_arrives_all_the_same() {
    undisturbed(|| {
        let bench = BenchProcess::start("program-orders", "1,2");
        let file = Scratch::new("program-orders.ngc", LINE);
        let (child, mut orders) = with_orders(
            &bench,
            &file,
            "program-orders.socket",
            &["--max-override", "200"],
        );
        assert_eq!(orders.ask("override 50"), "ok 1");
        orders.until("speed=50 asked=50 paused=false");
        orders.ask("pause");
        orders.until("speed=0 asked=50 paused=true");
        orders.ask("resume");
        orders.ask("override 200");
        orders.until("speed=200 asked=200 paused=false");
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        assert_eq!(received(&bench.stop()), [counts(60.0), counts(30.0)]);
    });
}

#[test]
fn a_stop_by_order_or_by_ctrl_c_ends_on_the_path() {
    undisturbed(|| {
        let bench = BenchProcess::start("program-stop", "1,2");
        let file = Scratch::new("program-stop.ngc", LINE);
        let (child, mut orders) = with_orders(&bench, &file, "program-stop.socket", &[]);
        // More than was checked: held.
        orders.ask("override 150");
        orders.until("speed=100 asked=150");
        // By then it moves, however fast the orders came.
        wait_until("300 cycles", || orders.cycle() >= 300);
        orders.ask("stop");
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(130), "{output:?}");
        let end = received(&bench.stop());
        assert!(end[0] > 0 && is_on_the_line(end), "{end:?}");
        let bench = BenchProcess::start("program-ctrl-c", "1,2");
        let child = start_and_wait_for(motionctl(&arguments(&bench, &file)), "the motion starts");
        std::thread::sleep(std::time::Duration::from_millis(500));
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(130), "{output:?}");
        let end = received(&bench.stop());
        assert!(end[0] > 0 && end[0] < counts(60.0), "{end:?}");
    });
}

#[test]
fn a_broken_program_is_refused_before_anything_is_sent() {
    undisturbed(|| {
        let bench = BenchProcess::start("program-broken", "1,2");
        for (text, says) in [
            ("G21 G90\nG1 X5 F900\nG5 X1\n", "line 3, column 1: G5"),
            ("G21 G90\nG1 X5 F900\n  G1 X1 Z2\n", "line 3, column 9: "),
            (
                "G21 G90\nG1 X5 F900\nG2 X9 Y9 I1 J0\n",
                "line 3, column 4: the centre is",
            ),
        ] {
            let file = Scratch::new("program-broken.ngc", text);
            let output = motionctl(&arguments(&bench, &file)).output();
            let (status, errors) = status_and_errors(&output.expect("motionctl runs"));
            assert_eq!(status, Some(2), "{errors}");
            assert!(errors.contains(says), "{says}: {errors}");
        }
        // What an override could ask for is checked too: 67 mm/s at 100 %.
        let file = Scratch::new("program-fast.ngc", "G21 G90\nG1 X60 Y30 F2400\n");
        let mut words = arguments(&bench, &file);
        let allowed = words
            .iter()
            .position(|word| *word == "500")
            .expect("--max-rpm");
        words[allowed] = "460";
        words.extend(["--max-override", "200", "--axis-rpm", "900"]);
        let output = motionctl(&words).output().expect("motionctl runs");
        let (status, errors) = status_and_errors(&output);
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("allow it with --max-rpm"), "{errors}");
        assert_eq!(bench.stop()["frames_from_host"], 0);
    });
}
