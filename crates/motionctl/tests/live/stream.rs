//! Set-points that arrive while the motion runs, and orders to it, as other programs give them.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::os::unix::fs::PermissionsExt;
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::process::{Child, Command, Output};
use std::time::Duration;

use serde_json::Value;

use crate::bench::{BenchProcess, Scratch, motionctl, scratch, start_and_wait_for, wait_until};
use crate::tool::Folder;
use crate::tool::page::Page;
use crate::undisturbed::undisturbed;

/// Nobody waits longer for an answer.
const PATIENCE: Duration = Duration::from_secs(30);

/// A motion that takes set-points from a port, and the port.
struct Streamed {
    child: Child,
    port: u16,
}

impl Streamed {
    fn start(bench: &BenchProcess, options: &[&str]) -> Self {
        Self::start_on(&["--slcan", bench.path(), "--drives", "1,2"], options)
    }

    fn start_on(link: &[&str], options: &[&str]) -> Self {
        let stream = ["--stream", "tcp:0", "--yes", "--json"];
        let mut child = motionctl(&[&["run"], link, &stream, options].concat())
            .spawn()
            .expect("motionctl starts");
        let errors = child.stderr.as_mut().expect("it is piped");
        let mut heard = String::new();
        let place = "set-points are taken from tcp:127.0.0.1:";
        while !heard.contains(place) || !heard.ends_with('\n') {
            let mut byte = [0];
            let length = errors.read(&mut byte).expect("its error output");
            assert_eq!(length, 1, "it ended: {heard}");
            heard.push(char::from(byte[0]));
        }
        let port = heard.rsplit(':').next().expect("a port").trim();
        let port = port.parse().expect("a port");
        Self { child, port }
    }

    /// The summary, the error output and the exit status.
    fn end(self) -> (Value, String, Option<i32>) {
        let output = self.child.wait_with_output().expect("its output");
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        let summary = serde_json::from_slice(&output.stdout)
            .unwrap_or_else(|error| panic!("{error}: {errors}"));
        (summary, errors, output.status.code())
    }

    fn connect(&self) -> Sender<TcpStream> {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).expect("it listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a time");
        Sender::new(stream.try_clone().expect("a handle"), stream)
    }
}

/// A program at the other end.
struct Sender<S> {
    out: S,
    answers: BufReader<S>,
}

impl<S: Read + Write> Sender<S> {
    fn new(out: S, answers: S) -> Self {
        Self {
            out,
            answers: BufReader::new(answers),
        }
    }

    fn say(&mut self, line: &str) {
        self.out.write_all(line.as_bytes()).expect("it reads");
        self.out.write_all(b"\n").expect("it reads");
    }

    /// The next answer that is no `ok`; empty when the connection was closed.
    fn answer(&mut self) -> String {
        loop {
            let mut line = String::new();
            self.answers.read_line(&mut line).expect("an answer");
            if !line.starts_with("ok ") || line.split(' ').count() < 3 {
                return line.trim_end().to_owned();
            }
        }
    }

    fn ask(&mut self, line: &str) -> String {
        self.say(line);
        self.answer()
    }
}

fn python(port: u16, options: &[&str]) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    Command::new("python3")
        .arg(root.join("examples/stream.py"))
        .arg(port.to_string())
        .args(options)
        .output()
        .expect("Python is there")
}

/// A quarter of a turn in both axes, and both sides agree; what the axes were told in all is on the bus.
fn has_arrived(summary: &Value, report: &Value, counts: i64) {
    for axis in 0..2 {
        let drive = &report["drives"][axis];
        for count in ["target_counts", "sent_counts"] {
            assert_eq!(summary["axes"][axis][count], counts, "{summary}");
        }
        assert_eq!(drive["received_counts"], counts, "{report}");
        assert_eq!(
            summary["axes"][axis]["set_points"], drive["set_points"],
            "{report}"
        );
    }
}

/// `STREAM_SECONDS=60` for the long run.
#[test]
fn a_client_of_the_standard_library_loses_no_set_point() {
    let seconds = std::env::var("STREAM_SECONDS").unwrap_or_else(|_| "10".to_owned());
    undisturbed(|| {
        let bench = BenchProcess::start("stream", "1,2");
        let run = Streamed::start(&bench, &[]);
        let client = python(run.port, &["--seconds", &seconds]);
        assert!(client.status.success(), "{client:?}");
        let said = String::from_utf8_lossy(&client.stdout).into_owned();
        assert!(said.ends_with("end completed\n"), "{said}");
        let (summary, errors, status) = run.end();
        assert_eq!(status, Some(0), "{summary} {errors}");
        assert_eq!(summary["completed"], true, "{summary}");
        let sent = seconds.parse::<u64>().expect("seconds") * 50 + 1;
        assert_eq!(summary["stream"]["taken"], sent, "{summary}");
        for nothing in ["refused", "unusable", "ran_dry"] {
            assert_eq!(summary["stream"][nothing], 0, "{nothing}: {summary}");
        }
        has_arrived(&summary, &bench.stop(), 4_096);
    });
}

#[test]
fn the_recording_of_a_stream_has_the_names_and_units_of_its_sender() {
    undisturbed(|| {
        let folder = Folder::new("stream-buses");
        std::fs::create_dir_all(&folder.0).expect("a folder");
        let benches = ["stream-a", "stream-b"].map(|name| BenchProcess::start(name, "1"));
        let buses = benches
            .each_ref()
            .map(|bench| format!("slcan:{}=1", bench.path()));
        let [page, mcap] = ["page", "run.mcap"].map(|name| folder.file(name));
        let link = ["--bus", &buses[0], "--bus", &buses[1]];
        let run = Streamed::start_on(&link, &["--report", &page, "--mcap", &mcap]);
        let mut sender = run.connect();
        sender.say("t_ms,rail_turns,turret_deg");
        for (at_ms, tenth) in (0..=1_000).step_by(20).zip(0..) {
            let turns = f64::from(tenth) * 0.005;
            sender.say(&format!("{at_ms},{turns},{}", -180.0 * turns));
        }
        sender.say("end");
        let (summary, errors, status) = run.end();
        assert_eq!(status, Some(0), "{summary} {errors}");
        let axes = [("rail_turns", "turns", 0.25), ("turret_deg", "deg", -45.0)];
        for (bench, (name, unit, last)) in benches.into_iter().zip(axes) {
            let tail = bench.path().rsplit('/').next().expect("a name").to_owned();
            let page = Page::in_folder(&folder.file(&format!("page-{tail}")));
            assert_eq!(page.axes(), [name]);
            assert_eq!(page.data()["axes"][0]["unit"], unit);
            let bytes = std::fs::read(folder.file(&format!("run-{tail}.mcap"))).expect("it");
            let value = last_of(&bytes, &format!("/axis/{name}"));
            assert!((value - last).abs() < 1e-3, "{name}: {value}");
        }
    });
}

/// The last set-point on a topic.
fn last_of(bytes: &[u8], topic: &str) -> f64 {
    let messages = mcap::MessageStream::new(bytes).expect("an MCAP file");
    let of_topic = messages
        .map(|message| message.expect("a message"))
        .filter(|message| message.channel.topic == topic);
    let last = of_topic.last().expect("a message on the topic");
    let json: Value = serde_json::from_slice(&last.data).expect("JSON");
    json["sent"].as_f64().expect("a number")
}

#[test]
fn a_silence_of_a_second_is_a_ramp_a_message_and_a_clean_end() {
    undisturbed(|| {
        let bench = BenchProcess::start("dry", "1,2");
        bench.disable("1,2");
        let run = Streamed::start(&bench, &[]);
        let client = python(run.port, &["--seconds", "4", "--silence", "1.5"]);
        assert!(!client.status.success(), "{client:?}");
        let (summary, errors, status) = run.end();
        assert_eq!(status, Some(1), "{summary} {errors}");
        assert_eq!(summary["outcome"], "the set-points ran out", "{summary}");
        assert!(
            errors.contains("the set-points ran out: the axes slow down"),
            "{errors}"
        );
        assert_eq!(summary["disabled"], serde_json::json!([1, 2]), "{summary}");
        assert_eq!(summary["stream"]["ran_dry"], 1, "{summary}");
        let report = bench.stop();
        for axis in 0..2 {
            let (ours, theirs) = (&summary["axes"][axis], &report["drives"][axis]);
            assert_eq!(ours["target_counts"], ours["sent_counts"], "{summary}");
            assert_eq!(ours["sent_counts"], theirs["received_counts"], "{report}");
            assert_eq!(theirs["enabled"], false, "{report}");
            assert_ne!(theirs["received_counts"], 0, "it had moved");
            assert_eq!(theirs["alarm"], Value::Null);
        }
    });
}

#[test]
fn what_is_no_set_point_is_answered_with_its_number_and_moves_nothing() {
    undisturbed(|| {
        let bench = BenchProcess::start("hostile", "1,2");
        let run = Streamed::start(&bench, &[]);
        let mut sender = run.connect();
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
        assert!(
            sender
                .ask(&"7".repeat(5_000))
                .starts_with("error 9 101 the line is too long")
        );
        sender.say("0,0,0");
        assert!(
            sender
                .ask("0,0,0")
                .starts_with("error 11 203 the time is in the past")
        );
        sender.say("0.02,0,0");
        assert_eq!(
            sender.ask("0.01,0,0"),
            "error 13 204 the time is out of order: expected later than 0.02 s, got 0.01 s"
        );
        assert!(
            sender
                .ask("20,0,0")
                .starts_with("error 14 206 the time is too far ahead")
        );
        assert!(
            sender
                .ask("0.04,360,0")
                .starts_with("error 15 208 x_deg: too fast: expected at most 30")
        );
        let mut second = run.connect();
        assert!(
            second.answer().starts_with("error 0 301 "),
            "one writer at a time"
        );
        assert_eq!(second.answer(), "");
        sender.say("end");
        assert_eq!(sender.answer(), "end completed");
        let (summary, _, status) = run.end();
        assert_eq!(status, Some(0), "{summary}");
        let stream = &summary["stream"];
        let counted = ["taken", "refused", "unusable"].map(|count| stream[count].as_u64());
        assert_eq!(counted, [Some(2), Some(6), Some(6)], "{summary}");
        has_arrived(&summary, &bench.stop(), 0);
    });
}

#[test]
fn a_sender_that_goes_without_an_end_leaves_axes_at_rest() {
    undisturbed(|| {
        let bench = BenchProcess::start("gone", "1,2");
        let run = Streamed::start(&bench, &[]);
        let mut sender = run.connect();
        sender.ask(r#"{"t":0,"x_deg":0,"y_deg":0}"#);
        for point in 1..=40_u32 {
            let share = f64::from(point) / 40.0;
            let eased = 90.0 * share * share * (3.0 - 2.0 * share);
            sender.say(&format!(
                r#"{{"t":{},"x_deg":{eased},"y_deg":{eased}}}"#,
                0.02 * f64::from(point)
            ));
        }
        drop(sender);
        let (summary, errors, status) = run.end();
        assert_eq!(status, Some(1), "{summary}");
        assert!(
            errors.contains("the sender has gone without an end"),
            "{errors}"
        );
        assert_eq!(summary["stream"]["taken"], 41, "{summary}");
        has_arrived(&summary, &bench.stop(), 4_096);
    });
}

#[test]
fn a_sender_that_does_not_look_at_its_credit_is_held_back_and_loses_nothing() {
    undisturbed(|| {
        let bench = BenchProcess::start("hasty", "1,2");
        let run = Streamed::start(&bench, &[]);
        let mut sender = run.connect();
        sender.say("time_ms,x_deg,y_deg");
        // Three times what fits into the buffer, all at once.
        for point in 0..=2_000 {
            let share = f64::from(point) / 2_000.0;
            let eased = 90.0 * share * share * (3.0 - 2.0 * share);
            sender.say(&format!("{point},{eased:.5},{eased:.5}"));
        }
        sender.say("end");
        assert_eq!(sender.answer(), "ready 2 8");
        assert_eq!(sender.answer(), "end completed");
        let (summary, errors, status) = run.end();
        assert_eq!(status, Some(0), "{summary} {errors}");
        let counted = ["taken", "refused"].map(|count| summary["stream"][count].as_u64());
        assert_eq!(counted, [Some(2_001), Some(0)], "{summary}");
        has_arrived(&summary, &bench.stop(), 4_096);
    });
}

#[test]
fn orders_at_a_socket_pause_and_stop_on_the_path() {
    undisturbed(|| {
        let bench = BenchProcess::start("control", "1,2");
        // y is always half of x, the other way.
        let file = Scratch::new(
            "control.csv",
            "time_s,a,b\n0,0,0\n10,3000,-1500\n20,6000,-3000\n",
        );
        let socket = scratch("control.socket");
        let place = format!("unix:{}", socket.display());
        let arguments = [
            "run",
            "--slcan",
            bench.path(),
            "--trajectory",
            file.path(),
            "--max-turns",
            "20",
            "--yes",
            "--control",
            &place,
        ];
        let child = start_and_wait_for(motionctl(&arguments), "the motion starts");
        let mode = std::fs::metadata(&socket)
            .expect("it is there")
            .permissions()
            .mode();
        assert_eq!(mode & 0o777, 0o600);
        let stream = UnixStream::connect(&socket).expect("it listens");
        let mut other = Sender::new(stream.try_clone().expect("a handle"), stream);
        assert_eq!(other.ask("override 50"), "ok 1");
        assert!(other.ask("faster").starts_with("error 2 108 "));
        let until = |other: &mut Sender<UnixStream>, what: &str| {
            wait_until(what, || other.ask("status").contains(what));
        };
        until(&mut other, "speed=50 asked=50 paused=false");
        other.ask("pause");
        until(&mut other, "speed=0 asked=50 paused=true");
        other.ask("stop");
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(130), "{output:?}");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(text.contains("The motion: stopped by an order."), "{text}");
        assert!(!socket.exists(), "its file is removed");
        let report = bench.stop();
        let [x, y] = [0, 1].map(|drive: usize| report["drives"][drive]["received_counts"].as_i64());
        let (x, y) = (x.expect("counts"), y.expect("counts"));
        assert!(x > 0 && (x + 2 * y).abs() <= 2, "on the path: {x} {y}");
    });
}

#[test]
fn two_buses_start_and_arrive_together() {
    undisturbed(|| {
        let (left, right) = (
            BenchProcess::start("left", "1,2"),
            BenchProcess::start("right", "1"),
        );
        left.disable("1,2");
        let file = Scratch::new("two-buses.csv", "time_s,a,b,c\n0,0,0,0\n1,90,-90,180\n");
        let run = |options: &[&str]| {
            let buses = [
                format!("slcan:{}=2,1", left.path()),
                format!("slcan:{}=1", right.path()),
            ];
            let arguments = [
                "run",
                "--bus",
                &buses[0],
                "--bus",
                &buses[1],
                "--trajectory",
                file.path(),
                "--yes",
                "--json",
            ];
            let output = motionctl(&[&arguments, options].concat()).output();
            let output = output.expect("motionctl runs");
            let summary: Value = serde_json::from_slice(&output.stdout).unwrap_or(Value::Null);
            (
                output.status.code(),
                summary,
                String::from_utf8_lossy(&output.stderr).into_owned(),
            )
        };
        let (status, summary, errors) = run(&[]);
        assert_eq!(status, Some(0), "{summary} {errors}");
        let sent =
            |bus: usize, axis: usize| summary["buses"][bus]["axes"][axis]["sent_counts"].as_i64();
        assert_eq!(
            [sent(0, 0), sent(0, 1), sent(1, 0)],
            [Some(4_096), Some(-4_096), Some(8_192)]
        );
        assert_eq!(
            summary["buses"][0]["disabled"],
            serde_json::json!([1, 2]),
            "{summary}"
        );
        assert_eq!(
            summary["buses"][1]["left_enabled"],
            serde_json::json!([1]),
            "{summary}"
        );
        let (left, right) = (left.stop(), right.stop());
        let received =
            |report: &Value, drive: usize| report["drives"][drive]["received_counts"].as_i64();
        let all = [received(&left, 0), received(&left, 1), received(&right, 0)];
        assert_eq!(all, [Some(-4_096), Some(4_096), Some(8_192)]);
    });
}

#[test]
fn a_bus_that_vanishes_stops_the_other_one() {
    undisturbed(|| {
        let (left, mut right) = (
            BenchProcess::start("stays", "1"),
            BenchProcess::start("goes", "1"),
        );
        left.disable("1");
        let file = Scratch::new("vanishing.csv", "time_s,a,b\n0,0,0\n60,3000,3000\n");
        let buses = [
            format!("slcan:{}=1", left.path()),
            format!("slcan:{}=1", right.path()),
        ];
        let arguments = [
            "run",
            "--bus",
            &buses[0],
            "--bus",
            &buses[1],
            "--trajectory",
            file.path(),
            "--yes",
        ];
        let child = start_and_wait_for(motionctl(&arguments), "the motion starts");
        std::thread::sleep(Duration::from_secs(1));
        right.kill();
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(3), "{output:?}");
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(errors.contains("stopped with the other bus"), "{errors}");
        assert!(
            errors.contains("the link failed: the adapter is gone"),
            "{errors}"
        );
        let report = left.stop();
        assert_eq!(report["drives"][0]["enabled"], false, "{report}");
        assert_ne!(report["drives"][0]["received_counts"], 0, "it had moved");
    });
}

#[test]
fn a_set_point_that_needs_more_jerk_than_allowed_is_refused() {
    undisturbed(|| {
        let bench = BenchProcess::start("jerk", "1,2");
        // On its way, because a start from rest takes more time instead: 10 degrees a second, then 65.
        let jerky = [
            "0,0,0", "0.2,0,0", "0.4,1,0", "0.6,3,0", "0.8,5,0", "1.0,7,0", "1.2,20,0", "1.4,33,0",
        ];
        let run = Streamed::start(&bench, &["--max-jerk", "200"]);
        let mut sender = run.connect();
        assert_eq!(sender.ask("time_s,x_deg,y_deg"), "ready 2 8");
        for line in jerky {
            sender.say(line);
        }
        let answer = sender.answer();
        let words: Vec<&str> = answer.split(' ').collect();
        assert_eq!((words[0], words[2]), ("error", "210"), "{answer}");
        assert!(
            answer.contains("too much jerk: expected at most"),
            "{answer}"
        );
        sender.say("stop");
        let (summary, errors, _) = run.end();
        let refused = &summary["stream"]["refused_by_number"];
        assert_eq!(refused[0][0], 210, "{summary} {errors}");
        bench.stop();
    });
}

/// Gives a program a terminal of its own and presses keys; prints its exit status, and whether the terminal gives lines before, while and
/// after it runs.
const KEYS: &str = r#"
import os, pty, sys, termios, time
child, terminal = pty.fork()
if child == 0:
    os.execv(sys.argv[1], sys.argv[1:])
lines = lambda: int(bool(termios.tcgetattr(terminal)[3] & termios.ICANON))
states, shown = [lines()], b""
while b"the motion starts" not in shown:
    shown += os.read(terminal, 4096)
states.append(lines())
for key in [b"-", b"-", b"-", b" ", b"x", b" ", b"s"]:
    os.write(terminal, key)
    time.sleep(0.25)
try:
    while chunk := os.read(terminal, 4096):
        shown += chunk
except OSError:
    pass
states.append(lines())
status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
print(status, *states, int(b"keys: space pause" in shown), int(b"stopped by an order" in shown))
"#;

#[test]
fn keys_of_the_terminal_pause_and_stop_and_the_terminal_is_itself_again() {
    undisturbed(|| {
        let bench = BenchProcess::start("keys", "1,2");
        let file = Scratch::new(
            "keys.csv",
            "time_s,a,b\n0,0,0\n10,3000,-1500\n20,6000,-3000\n",
        );
        let output = Command::new("python3")
            .args([
                "-c",
                KEYS,
                env!("CARGO_BIN_EXE_motionctl"),
                "run",
                "--slcan",
                bench.path(),
            ])
            .args(["--trajectory", file.path(), "--max-turns", "20", "--yes"])
            .output()
            .expect("Python is there");
        assert_eq!(
            String::from_utf8_lossy(&output.stdout),
            "130 1 0 1 1 1\n",
            "{output:?}"
        );
        let report = bench.stop();
        let counts = |drive: usize| {
            report["drives"][drive]["received_counts"]
                .as_i64()
                .expect("counts")
        };
        assert!(
            counts(0) > 0 && (counts(0) + 2 * counts(1)).abs() <= 2,
            "{report}"
        );
    });
}

#[test]
fn an_endpoint_that_cannot_be_used_is_refused_before_anything() {
    let file = Scratch::new("not-a-socket", "mine");
    let run = |endpoint: &str| {
        let arguments = [
            "run",
            "--slcan",
            "/dev/null",
            "--drives",
            "1",
            "--stream",
            endpoint,
            "--yes",
        ];
        let output = motionctl(&arguments).output().expect("motionctl runs");
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(run("tcp:0.0.0.0:7001").contains(
        "expected tcp:PORT, which only programs of this machine reach, or --allow-remote"
    ));
    assert!(run(&format!("unix:{}", file.path())).contains("got another kind of file"));
    assert!(run("udp:7").contains("expected -, tcp:PORT, tcp:HOST:PORT or unix:PATH, got udp:7"));
    assert_eq!(
        std::fs::read_to_string(file.path()).expect("it is there"),
        "mine"
    );
}
