//! `motionctl board stream` against `motionctl bench --board`: what is written is what is on the bus, and whatever a sender does, the axes come
//! to rest within their limits and the drives are off.

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

#[test]
fn every_set_point_that_is_written_is_on_the_bus_at_its_cycle() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-every", SETTINGS);
        let mut stream = Streamed::start(&bench, &[]);
        stream.say(NAMES);
        let counts = eased(150, 16_384);
        stream.points(0, 20, &counts);
        stream.say("end");
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(0), "{summary} {errors}");
        assert_eq!(
            (&summary["completed"], &summary["outcome"]),
            (&true.into(), &"completed".into())
        );
        assert_eq!(counted(&summary), [Some(151), Some(0), Some(0)]);
        assert_eq!(summary["segments_sent"], 150);
        assert_eq!(numbers(&summary["axes"], "target_counts"), [16_384, -8_192]);
        let steps = agree(&summary, bench);
        let x: Vec<(usize, i64)> = (0..).step_by(20).zip(counts.iter().copied()).collect();
        let y: Vec<(usize, i64)> = x.iter().map(|(at, x)| (*at, -x / 2)).collect();
        has_every(&steps[0], &x);
        has_every(&steps[1], &y);
    });
}

/// Pauses of 0 to `most` milliseconds, the same at each call with a seed.
fn pauses(seed: u64, most: u64) -> impl Iterator<Item = Duration> {
    let mut state = seed;
    core::iter::repeat_with(move || {
        // Knuth's MMIX.
        state = state.wrapping_mul(6_364_136_223_846_793_005);
        state = state.wrapping_add(1_442_695_040_888_963_407);
        Duration::from_millis((state >> 33) % (most + 1))
    })
}

#[test]
fn a_writer_whose_lines_come_up_to_270_ms_late_costs_nothing() {
    undisturbed(|| {
        let seed = u64::from(std::process::id());
        println!("seed {seed}");
        let bench = BoardBench::start("stream-jitter", SETTINGS);
        let mut stream = Streamed::start(&bench, &[]);
        stream.say(NAMES);
        let counts = eased(200, 16_384);
        // In real time: what is buffered at the start is what may be late, less 130 ms for slowing down.
        // Before it is enabled nothing is late.
        std::thread::sleep(Duration::from_secs(2));
        let start = Instant::now();
        for ((place, x), late) in counts.iter().enumerate().zip(pauses(seed, 20)) {
            let once = Duration::from_millis(if place == 100 { 270 } else { 0 });
            let due = Duration::from_millis(20 * place as u64) + late.max(once);
            std::thread::sleep(due.saturating_sub(start.elapsed()));
            stream.say(&line(20 * place, *x));
        }
        stream.say("end");
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(0), "{summary} {errors}");
        assert_eq!(counted(&summary), [Some(201), Some(0), Some(0)]);
        assert_eq!(summary["stream"]["ran_dry"], 0, "{summary}");
        assert!(!errors.contains("late"), "{errors}");
        let steps = agree(&summary, bench);
        let x: Vec<(usize, i64)> = (0..).step_by(20).zip(counts).collect();
        has_every(&steps[0], &x);
    });
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

#[test]
fn a_writer_that_falls_silent_is_a_ramp_a_message_and_a_clean_end() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-silent", SETTINGS);
        let mut stream = Streamed::start(&bench, &[]);
        stream.say(NAMES);
        let counts = constant(100);
        stream.points(0, 20, &counts);
        // Nothing more comes, and the input stays open.
        let mut input = stream.child.stdin.take();
        let (summary, errors, status) = stream.end();
        drop(input.take());
        assert_eq!(status, Some(1), "{summary} {errors}");
        assert_eq!(summary["outcome"], "the set-points ran out", "{summary}");
        assert_eq!(summary["stream"]["ran_dry"], 1, "{summary}");
        for told in [
            "the set-points are late",
            "the set-points ran out: the axes have come to rest along the path",
        ] {
            assert!(errors.contains(told), "{told}: {errors}");
        }
        let steps = agree(&summary, bench);
        let sent = numbers(&summary["axes"], "set_point_counts");
        // On the path, and before what was not sent.
        assert!((sent[0] + 2 * sent[1]).abs() <= 2, "{sent:?}");
        assert!(
            sent[0] > 2_000 && Some(&sent[0]) < counts.last(),
            "{sent:?}"
        );
        assert_eq!(sums(&steps[0]).last(), Some(&sent[0]));
    });
}

#[test]
fn a_writer_that_comes_back_goes_on_where_the_board_waits() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-wait", SETTINGS);
        let mut stream = Streamed::start(&bench, &["--when-dry", "wait"]);
        stream.say(NAMES);
        let counts = eased(200, 16_384);
        stream.points(0, 20, &counts[..100]);
        // Enabled within a second, two seconds of path, and a second for nothing.
        std::thread::sleep(Duration::from_millis(4_500));
        stream.points(100, 20, &counts[100..]);
        stream.say("end");
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(0), "{summary} {errors}");
        assert_eq!(summary["stream"]["ran_dry"], 1, "{summary}");
        assert_eq!(counted(&summary), [Some(201), Some(0), Some(0)]);
        assert_eq!(
            numbers(&summary["axes"], "set_point_counts"),
            [16_384, -8_192]
        );
        agree(&summary, bench);
    });
}

#[test]
fn a_writer_that_dies_in_motion_leaves_axes_at_rest_at_its_last_whole_line() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-dies", SETTINGS);
        let mut stream = Streamed::start(&bench, &[]);
        stream.say(NAMES);
        let counts = eased(100, 4_096);
        stream.points(0, 20, &counts[..60]);
        // Cut off: the whole number would be 1200.
        let input = stream.child.stdin.as_mut().expect("it is open");
        input.write_all(b"12").expect("it reads");
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(1), "{summary} {errors}");
        assert_eq!(summary["outcome"], "the set-points ran out", "{summary}");
        assert!(
            errors.contains("the sender has gone without an end"),
            "{errors}"
        );
        assert_eq!(counted(&summary), [Some(60), Some(0), Some(1)]);
        let last = counts[59];
        assert_eq!(
            numbers(&summary["axes"], "target_counts"),
            [last, -last / 2]
        );
        assert_eq!(
            numbers(&summary["axes"], "set_point_counts"),
            [last, -last / 2]
        );
        agree(&summary, bench);
    });
}

#[test]
fn a_second_stream_begins_where_the_first_one_ended() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-second", SETTINGS);
        let counts = eased(50, 2_048);
        let stream_once = || {
            let mut stream = Streamed::start(&bench, &["--snapshot-hz", "1000"]);
            stream.say(NAMES);
            // Long after the drives are enabled: until then the board tells of the stream before.
            std::thread::sleep(Duration::from_secs(2));
            stream.points(7, 20, &counts);
            stream.say("end");
            let (summary, errors, status) = stream.end();
            assert_eq!(status, Some(0), "{summary} {errors}");
            assert_eq!(counted(&summary), [Some(51), Some(0), Some(0)]);
            for sums in ["target_counts", "set_point_counts"] {
                assert_eq!(numbers(&summary["axes"], sums), [2_048, -1_024]);
            }
        };
        stream_once();
        stream_once();
        let (report, steps) = bench.end();
        assert_eq!(
            numbers(&report["drives"], "received_counts"),
            [4_096, -2_048]
        );
        is_within_limits(&steps);
    });
}

#[test]
fn an_end_that_is_too_fast_to_stop_at_stops_before_it() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-abrupt", SETTINGS);
        let mut stream =
            Streamed::start(&bench, &["--max-acceleration", "1500", "--max-rpm", "600"]);
        stream.say(NAMES);
        // 50 counts a cycle, at 0.05 counts a cycle and cycle.
        let counts: Vec<i64> = (0..=70_i64).map(|step| step * step * 10).collect();
        stream.points(0, 20, &counts);
        stream.say("end");
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(1), "{summary} {errors}");
        assert!(
            errors.contains("too fast to come to rest there"),
            "{errors}"
        );
        assert_eq!(summary["completed"], false);
        let sent = numbers(&summary["axes"], "set_point_counts");
        let last = counts.last().copied().unwrap_or(0);
        assert!(sent[0] > last / 2 && sent[0] < last, "{sent:?} of {last}");
        agree(&summary, bench);
    });
}

#[test]
fn ctrl_c_stops_on_the_path_and_disables() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-interrupt", SETTINGS);
        let mut stream = Streamed::start(&bench, &["--max-turns", "40"]);
        stream.say(NAMES);
        let counts = constant(400);
        // More than may be ahead waits in the pipe.
        stream.points(0, 20, &counts);
        std::thread::sleep(Duration::from_secs(4));
        interrupt(&stream.child);
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(130), "{summary} {errors}");
        assert_eq!(summary["outcome"], "stopped by the user");
        let sent = numbers(&summary["axes"], "set_point_counts");
        assert!(
            sent[0] > 2_000 && (sent[0] + 2 * sent[1]).abs() <= 2,
            "{sent:?}"
        );
        agree(&summary, bench);
    });
}

#[test]
fn ctrl_c_before_anything_was_written_disables() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-nothing", SETTINGS);
        let stream = Streamed::start(&bench, &[]);
        std::thread::sleep(Duration::from_secs(2));
        interrupt(&stream.child);
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(130), "{summary} {errors}");
        agree(&summary, bench);
    });
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

#[test]
fn what_is_no_set_point_is_answered_with_its_number_and_moves_nothing() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-hostile", SETTINGS);
        let (stream, mut sender) = Peer::start(&bench, &["--drives", "2,1"]);
        assert!(sender.ask("0,0,0").starts_with("error 1 104 "));
        assert_eq!(sender.ask("time_s,x_deg,y_deg"), "ready 2 8");
        for (line, expected) in [
            (
                "0,90,0",
                "error 3 202 x_deg: the first set-point must be where the axis stands: expected 0 deg, got 90 deg",
            ),
            ("0,0", "error 4 105 expected 3 fields, one a name, got 2"),
            (
                "0,0,nan",
                "error 5 107 y_deg: expected a finite number, got nan",
            ),
            ("0,0,0x10", "error 6 106 y_deg: expected a number, got 0x10"),
            (
                "0,0,99999",
                "error 7 207 y_deg: beyond its travel: expected -3600 deg to 3600 deg, got 99999 deg",
            ),
            (
                "override 201",
                "error 8 109 an override is a whole percentage: expected 0 to 200, got 201",
            ),
        ] {
            assert_eq!(sender.ask(line), expected);
        }
        assert!(sender.ask(&"7".repeat(5_000)).starts_with("error 9 101 "));
        sender.say("0,0,0");
        assert_eq!(
            sender.ask("0,0,0"),
            "error 11 204 the time is out of order: expected later than 0 s, got 0 s"
        );
        sender.say("0.02,0,0");
        assert!(sender.ask("0.01,0,0").starts_with("error 13 204 "));
        assert!(sender.ask("0.0201,0,0").starts_with("error 14 205 "));
        assert!(sender.ask("20,0,0").starts_with("error 15 206 "));
        assert!(
            sender
                .ask("0.04,360,0")
                .starts_with("error 16 208 x_deg: too fast: expected at most 30")
        );
        // It is slow enough and begins too hard: known with the next one.
        let answer = sender.ask("0.04,25,0");
        let expected = "error 17 209 x_deg: too much acceleration: expected at most 20000";
        assert!(answer.starts_with(expected), "{answer}");
        let status = sender.ask("status");
        assert!(
            status.starts_with("status 18 phase=Waiting speed=0"),
            "{status}"
        );
        assert_eq!(sender.ask("stop"), "end stopped by an order");
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(130), "{summary} {errors}");
        assert_eq!(counted(&summary), [Some(2), Some(8), Some(6)], "{summary}");
        assert_eq!(numbers(&summary["axes"], "drive"), [2, 1]);
        let steps = agree(&summary, bench);
        assert!(
            steps.iter().flatten().all(|step| *step == 0),
            "nothing has moved"
        );
    });
}

#[test]
fn a_refused_line_in_motion_is_left_out_and_the_others_are_on_the_bus() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-refused", SETTINGS);
        let mut stream = Streamed::start(&bench, &[]);
        stream.say(NAMES);
        let counts = eased(100, 8_192);
        let mut written = Vec::new();
        for (place, x) in counts.iter().enumerate() {
            if place == 40 {
                // Three turns away, then a letter.
                stream.say(&line(20 * place, x + 49_152));
                stream.say(&format!("{},{x}a,0", 20 * place));
                continue;
            }
            stream.say(&line(20 * place, *x));
            written.push((20 * place, *x));
        }
        stream.say("end");
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(0), "{summary} {errors}");
        assert!(
            errors.contains("error 42 208 x_counts: too fast"),
            "{errors}"
        );
        assert!(
            errors.contains("error 43 106 x_counts: expected a number"),
            "{errors}"
        );
        assert_eq!(counted(&summary), [Some(100), Some(1), Some(1)]);
        let steps = agree(&summary, bench);
        has_every(&steps[0], &written);
    });
}

#[test]
fn more_set_points_than_the_memory_of_the_board_holds_are_refused_before_anything_moves() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-dense", SETTINGS);
        let mut stream = Streamed::start(&bench, &[]);
        stream.say("t_ms,x_turns,y_turns");
        for ms in (0..320_u32).step_by(4) {
            let turns = f64::from(ms).powi(3) * 1e-9;
            stream.say(&format!("{ms},{turns},0"));
        }
        stream.say("end");
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(1), "{summary} {errors}");
        let why = "expected 56 of them in at least 300 ms, which are 186 a second";
        assert!(errors.contains(why), "{errors}");
        let outcome = "stopped, because the set-points cannot be played";
        assert_eq!(summary["outcome"], outcome, "{summary}");
        let text =
            "205 the time is too close to the set-points before: expected at least 300 ms, got";
        assert!(errors.contains(text), "{errors}");
        assert_eq!(summary["stream"]["refused_by_number"][0][0], 205);
        let steps = agree(&summary, bench);
        assert!(steps.iter().flatten().all(|step| *step == 0));
    });
}

#[test]
fn a_sender_that_becomes_too_fast_in_motion_is_stopped_on_the_path() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-faster", SETTINGS);
        let mut stream = Streamed::start(&bench, &["--max-turns", "20"]);
        stream.say("t_ms,x_turns,y_turns");
        let (mut ms, mut turns) = (0, 0.0);
        for step in 0..400_u32 {
            stream.say(&format!("{ms},{turns:.6},{:.6}", -0.5 * turns));
            let gap = if step < 100 { 20 } else { 2 };
            // Up to 2 turns a second.
            turns += 1e-3 * f64::from(gap) * (0.02 * f64::from(step)).min(2.0);
            ms += gap;
        }
        stream.say("end");
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(1), "{summary} {errors}");
        assert!(
            errors.contains("more set-points than the memory"),
            "{errors}"
        );
        let sent = numbers(&summary["axes"], "set_point_counts");
        assert!(
            sent[0] > 2_000 && (sent[0] + 2 * sent[1]).abs() <= 2,
            "{sent:?}"
        );
        agree(&summary, bench);
    });
}

/// A lead that is as long as a sender may be ahead.
#[test]
fn a_lead_as_long_as_what_may_be_ahead_is_reached() {
    undisturbed(|| {
        for (lead, when_dry) in [("1000", "end"), ("300", "wait")] {
            let bench = BoardBench::start("stream-lead", SETTINGS);
            let lead = ["--lead-ms", lead, "--ahead-ms", lead];
            let all = [&lead[..], &["--when-dry", when_dry]].concat();
            let mut stream = Streamed::start(&bench, &all);
            stream.say(NAMES);
            let counts = eased(100, 4_096);
            stream.points(0, 20, &counts);
            stream.say("end");
            let (summary, errors, status) = stream.end();
            assert_eq!(status, Some(0), "{summary} {errors}");
            assert_eq!(counted(&summary), [Some(101), Some(0), Some(0)]);
            agree(&summary, bench);
        }
    });
}

#[test]
fn a_path_that_ends_too_fast_before_it_begins_is_not_played() {
    undisturbed(|| {
        let ends = [&["end"][..], &[]];
        for (place, end) in ends.into_iter().enumerate() {
            let bench = BoardBench::start(&format!("stream-short-{place}"), SETTINGS);
            let mut stream = Streamed::start(&bench, &[]);
            stream.say(NAMES);
            // In 30 ms from rest to rest: far more acceleration than there may be.
            for line in ["0,0,0", "10,500,0"] {
                stream.say(line);
            }
            end.iter().for_each(|end| stream.say(end));
            let (summary, errors, status) = stream.end();
            assert_eq!(status, Some(1), "{summary} {errors}");
            assert!(errors.contains("nothing was moved"), "{errors}");
            assert!(errors.contains("expected at most"), "{errors}");
            assert_eq!(numbers(&summary["axes"], "set_point_counts"), [0, 0]);
            agree(&summary, bench);
        }
    });
}

#[test]
fn a_last_way_that_takes_longer_than_its_time_is_told() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-slow-end", SETTINGS);
        let mut stream = Streamed::start(&bench, &[]);
        stream.say(NAMES);
        stream.points(0, 20, &eased(100, 20_000)[..81]);
        stream.say("end");
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(0), "{summary} {errors}");
        assert!(errors.contains(" s instead of 0.020 s"), "{errors}");
        agree(&summary, bench);
    });
}

#[test]
fn an_override_goes_no_further_than_the_limits_of_the_user() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-override", SETTINGS);
        let ahead = ["--ahead-ms", "20000", "--max-turns", "40"];
        let (stream, mut sender) = Peer::start(&bench, &ahead);
        assert_eq!(sender.ask(NAMES), "ready 2 8");
        for (place, x) in constant(300).into_iter().enumerate() {
            sender.say(&line(20 * place, x));
        }
        sender.say("override 200");
        wait_until("it is held", || {
            sender.ask("status").contains("speed=100 asked=100")
        });
        assert_eq!(sender.ask("stop"), "end stopped by an order");
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(130), "{summary} {errors}");
        assert!(errors.contains("held to 100 %"), "{errors}");
        // It was stopped, and some were played.
        let sent = summary["segments_sent"].as_u64();
        assert!(sent > Some(2), "{summary}");
        agree(&summary, bench);
    });
}

#[test]
fn orders_of_the_sender_pause_and_stop_on_the_path() {
    undisturbed(|| {
        let bench = BoardBench::start("stream-orders", SETTINGS);
        let (stream, mut sender) =
            Peer::start(&bench, &["--ahead-ms", "20000", "--max-turns", "40"]);
        sender.say("pause");
        assert_eq!(sender.ask(NAMES), "ready 2 8");
        for (place, x) in constant(600).into_iter().enumerate() {
            sender.say(&line(20 * place, x));
        }
        let until = |sender: &mut Peer, what: &str| {
            wait_until(what, || sender.ask("status").contains(what));
        };
        until(&mut sender, "phase=Waiting speed=0 asked=100 paused=true");
        sender.say("override 50");
        sender.say("resume");
        until(&mut sender, "speed=50 asked=50 paused=false");
        sender.say("pause");
        until(&mut sender, "speed=0 asked=50 paused=true");
        assert_eq!(sender.ask("stop"), "end stopped by an order");
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(130), "{summary} {errors}");
        let sent = numbers(&summary["axes"], "set_point_counts");
        assert!(
            sent[0] > 0 && (sent[0] + 2 * sent[1]).abs() <= 2,
            "{sent:?}"
        );
        agree(&summary, bench);
    });
}

#[test]
fn the_client_of_the_documents_and_the_recording_with_its_names() {
    undisturbed(|| {
        let folder = Folder::new("board-stream-page");
        std::fs::create_dir_all(&folder.0).expect("a folder");
        let [page, table] = ["page", "run.csv"].map(|name| folder.file(name));
        let bench = BoardBench::start("stream-client", SETTINGS);
        let mut stream = Streamed::start(&bench, &["tcp:0", "--report", &page, "--csv", &table]);
        let port = port_of(&mut stream);
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let client = Command::new("python3")
            .arg(root.join("examples/stream.py"))
            .args([&port.to_string(), "--seconds", "6"])
            .output()
            .expect("Python is there");
        let said = String::from_utf8_lossy(&client.stdout).into_owned();
        assert!(said.ends_with("end completed\n"), "{client:?}");
        let (summary, errors, status) = stream.end();
        assert_eq!(status, Some(0), "{summary} {errors}");
        assert_eq!(counted(&summary), [Some(301), Some(0), Some(0)]);
        assert_eq!(
            numbers(&summary["axes"], "set_point_counts"),
            [4_096, 4_096]
        );
        assert_eq!(Page::in_folder(&page).axes(), ["x_deg", "y_deg"]);
        let rows = std::fs::read_to_string(&table).expect("a table");
        assert!(rows.contains(",4096,"), "{rows}");
        agree(&summary, bench);
    });
}

#[test]
fn what_cannot_be_used_is_refused_before_anything_is_enabled() {
    let bench = BoardBench::start("stream-options", SETTINGS);
    let file = Scratch::new("stream-options.csv", "time_s,a,b\n0,0,0\n");
    for (options, expected) in [
        (
            &["--trajectory", file.path()][..],
            "`motionctl board run` plays files",
        ),
        (
            &["--candump", "/tmp/none.log"],
            "the frames are on the bus of the board",
        ),
        (&["--drives", "1,7"], "the board has no drive 7"),
        (
            &["--counts-per-turn", "8192"],
            "give --counts-per-turn 16384",
        ),
        (
            &["--counts-per-turn", "8192,8192,8192"],
            "or 2 for 2 axes, got 3",
        ),
        (&["--lead-ms", "100"], "100 is not in 300..=10000"),
        (&["udp:7"], "expected -, tcp:PORT"),
        (&["tcp:0.0.0.0:7001"], "or --allow-remote"),
    ] {
        let (status, _, errors) = bench.run(&[&["stream", "--yes"], options].concat());
        assert_eq!(status, Some(2), "{options:?}: {errors}");
        assert!(errors.contains(expected), "{options:?}: {errors}");
    }
    let (_, steps) = bench.end();
    assert_eq!(json!(steps), json!([[], []]));
}
