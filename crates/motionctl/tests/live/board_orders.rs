//! Orders to `motionctl board run` while its motion runs.

use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;

use crate::bench::{Scratch, scratch, wait_until};
use crate::board_line::{BoardBench, SETTINGS};
use crate::undisturbed::undisturbed;

/// A turn a second for long, up to nearly two.
const LONG: &str = "time_s,a,b\n0,0,0\n12,7200,-7200\n";

/// Counts a cycle at so many r/min, rounded to whole counts.
fn most_step(rpm: f64) -> i64 {
    (rpm / 60.0 * 4.0 * 4_096.0 * 1e-3).ceil() as i64
}

#[test]
fn an_override_keeps_the_limits_of_the_user_though_the_board_would_allow_more() {
    undisturbed(|| {
        let bench = BoardBench::start("board-override", SETTINGS);
        let file = Scratch::new("board-override.csv", LONG);
        let socket = scratch("board-override.socket");
        let place = format!("unix:{}", socket.display());
        let words = ["run", file.path(), "--max-turns", "30", "--yes", "--json"];
        let orders = ["--max-rpm", "250", "--control", &place];
        let child = bench.spawn(&[&words[..], &orders].concat());
        wait_until("it listens", || UnixStream::connect(&socket).is_ok());
        let mut stream = UnixStream::connect(&socket).expect("it listens");
        let mut answers = BufReader::new(stream.try_clone().expect("a handle"));
        let mut ask = |line: &str| {
            writeln!(stream, "{line}").expect("it reads");
            let mut answer = String::new();
            answers.read_line(&mut answer).expect("it answers");
            answer
        };
        assert!(ask("override 200").starts_with("ok "));
        wait_until("it goes faster than the file says", || {
            let status = ask("status");
            let speed = status.split("speed=").nth(1).expect("a speed");
            let speed = speed.split(' ').next().expect("a number");
            speed.parse::<u32>().expect("a number") > 110
        });
        // Its fastest moment is in the middle.
        std::thread::sleep(std::time::Duration::from_secs(5));
        ask("stop");
        let output = child.wait_with_output().expect("its output");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(130), "{errors}");
        assert!(
            errors.contains("speed 200 % would exceed the limits of an axis: held to 1"),
            "{errors}"
        );
        let (_, steps) = bench.end();
        let fastest = steps.iter().flatten().map(|step| step.abs()).max();
        assert!(fastest <= Some(most_step(250.0)), "{fastest:?}");
        assert!(fastest > Some(most_step(200.0)), "{fastest:?}");
    });
}
