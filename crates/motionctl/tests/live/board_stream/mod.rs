//! `motionctl board stream` against `motionctl bench --board`: what is written is what is on the bus, and whatever a sender does, the axes come
//! to rest within their limits and the drives are off.

mod arrives;
mod ends;
mod orders;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use crate::bench::{Scratch, interrupt, motionctl, wait_until};
use crate::board_line::{BoardBench, SETTINGS};
use crate::tool::Folder;
use crate::tool::page::Page;
use crate::undisturbed::undisturbed;

/// Steps that change from one cycle to the next by no more than the settings allow, 2.73 counts, and what rounding adds.
const MOST_CHANGE: i64 = 4;

/// Nobody waits longer for an answer.
const PATIENCE: Duration = Duration::from_secs(30);

const NAMES: &str = "t_ms,x_counts,y_counts";

/// A stream whose lines come from this test, on standard input.
struct Streamed {
    child: Child,
}

impl Streamed {
    fn start(bench: &BoardBench, options: &[&str]) -> Self {
        let words = ["board", "stream", "--port", bench.port(), "--yes", "--json"];
        let child = motionctl(&[&words, options].concat())
            .stdin(Stdio::piped())
            .spawn()
            .expect("motionctl starts");
        Self { child }
    }

    fn say(&mut self, line: &str) {
        let input = self.child.stdin.as_mut().expect("it is open");
        // Whoever has ended does not read, and says why.
        let _ = writeln!(input, "{line}");
    }

    /// Set-points for which the other axis goes half the way back, `ms` apart from `from` on.
    fn points(&mut self, from: usize, ms: usize, counts: &[i64]) {
        for (place, x) in counts.iter().enumerate() {
            self.say(&line((from + place) * ms, *x));
        }
    }

    /// Summary and errors of a stream with this exit status; the input ends now, if it has not.
    fn ends_with(self, expected: i32) -> (Value, String) {
        let (summary, errors, status) = self.end();
        assert_eq!(status, Some(expected), "{summary} {errors}");
        (summary, errors)
    }

    /// Summary, errors and exit status; the input ends now, if it has not.
    fn end(mut self) -> (Value, String, Option<i32>) {
        drop(self.child.stdin.take());
        let output = self.child.wait_with_output().expect("its output");
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        let summary = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|error| panic!("{error}: {errors}"));
        (summary, errors, output.status.code())
    }
}

fn line(ms: usize, x: i64) -> String {
    format!("{ms},{x},{}", -x / 2)
}

/// From rest to rest in so many steps, to an even number of counts.
fn eased(steps: usize, way: i64) -> Vec<i64> {
    let at = |step: usize| {
        let share = step as f64 / steps as f64;
        let eased = share.powi(3) * (10.0 - 15.0 * share + 6.0 * share * share);
        2 * (way as f64 * eased / 2.0).round() as i64
    };
    (0..=steps).map(at).collect()
}

fn sums(steps: &[i64]) -> Vec<i64> {
    let mut position = 0;
    let after = steps.iter().map(|step| {
        position += step;
        position
    });
    core::iter::once(0).chain(after).collect()
}

/// Every set-point is on the bus, at its own cycle.
fn has_every(steps: &[i64], written: &[(usize, i64)]) {
    let positions = sums(steps);
    let last = written.last().expect("one").0;
    // An axis that stands has no set-points with a step; those before the start are on the bus, too.
    let padded = [vec![0; last], positions].concat();
    let at = |start: usize, cycle: usize| {
        let position = padded.get(start + cycle).or(padded.last());
        position.copied()
    };
    let fits = |start: &usize| {
        let mut all = written.iter();
        all.all(|(cycle, counts)| at(*start, *cycle) == Some(*counts))
    };
    assert!(
        (0..padded.len()).any(|start| fits(&start)),
        "{written:?} in {padded:?}"
    );
}

/// The set-points slow down within the limits, to rest.
fn is_within_limits(steps: &[Vec<i64>]) {
    for steps in steps {
        let ends = [&[0], &steps[..], &[0]].concat();
        let changes = ends.windows(2).map(|pair| (pair[1] - pair[0]).abs());
        let worst = changes.max();
        assert!(worst <= Some(MOST_CHANGE), "{worst:?} in {ends:?}");
    }
}

fn numbers(list: &Value, field: &str) -> Vec<i64> {
    let entries = list.as_array().expect("a list");
    let number = |entry: &Value| entry[field].as_i64().expect("a number");
    entries.iter().map(number).collect()
}

/// The board is off, and what it sent in all is what the summary says.
fn agree(summary: &Value, bench: BoardBench) -> Vec<Vec<i64>> {
    let (report, steps) = bench.end();
    assert_eq!(summary["disabled"], true, "{summary}");
    for drive in report["drives"].as_array().expect("a list") {
        assert_eq!(drive["enabled"], false, "{report}");
        assert_eq!(drive["alarm"], Value::Null, "{report}");
    }
    let sent = numbers(&summary["axes"], "set_point_counts");
    assert_eq!(numbers(&report["drives"], "received_counts"), sent);
    is_within_limits(&steps);
    steps
}

fn counted(summary: &Value) -> [Option<u64>; 3] {
    ["taken", "refused", "unusable"].map(|count| summary["stream"][count].as_u64())
}

/// Set-points at a constant speed: 100 counts in 20 ms, after a soft start.
fn constant(points: usize) -> Vec<i64> {
    let start: Vec<i64> = (0..=20)
        .map(|step: i64| step * step * 5 / 2 / 2 * 2)
        .collect();
    let from = start.last().copied().unwrap_or(0);
    let rest = (1..).map(|step: i64| from + 100 * step);
    start.iter().copied().chain(rest).take(points).collect()
}

/// A sender at a port, and its answers.
struct Peer {
    out: TcpStream,
    answers: BufReader<TcpStream>,
}

impl Peer {
    /// Starts a stream at a port of its own, and connects to it.
    fn start(bench: &BoardBench, options: &[&str]) -> (Streamed, Self) {
        let mut stream = Streamed::start(bench, &[&["tcp:0"], options].concat());
        let port = port_of(&mut stream);
        let out = TcpStream::connect(("127.0.0.1", port)).expect("it listens");
        out.set_read_timeout(Some(PATIENCE)).expect("a time");
        let answers = BufReader::new(out.try_clone().expect("a handle"));
        (stream, Self { out, answers })
    }

    fn say(&mut self, line: &str) {
        writeln!(self.out, "{line}").expect("it reads");
    }

    /// The next answer that is no `ok`; empty when the connection was closed.
    fn answer(&mut self) -> String {
        loop {
            let mut line = String::new();
            self.answers.read_line(&mut line).expect("an answer");
            if !line.starts_with("ok ") {
                return line.trim_end().to_owned();
            }
        }
    }

    fn ask(&mut self, line: &str) -> String {
        self.say(line);
        self.answer()
    }
}

fn port_of(stream: &mut Streamed) -> u16 {
    let errors = stream.child.stderr.as_mut().expect("it is piped");
    let mut heard = String::new();
    let place = "set-points are taken from tcp:127.0.0.1:";
    while !heard.contains(place) || !heard.ends_with('\n') {
        let mut byte = [0];
        let length = errors.read(&mut byte).expect("its error output");
        assert_eq!(length, 1, "it ended: {heard}");
        heard.push(char::from(byte[0]));
    }
    let port = heard.rsplit(':').next().expect("a port").trim();
    port.parse().expect("a port")
}
