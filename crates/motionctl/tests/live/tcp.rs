//! A bench behind ports of this machine, as on systems without pseudo-terminals, and whoever may use them.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, ChildStderr, Output};

use serde_json::Value;

use crate::bench::{interrupt, motionctl, wait_until};
use crate::tool::Scratch;
use crate::undisturbed::undisturbed;

/// A bench with its adapter, and the serial port of its drives, behind ports that are free.
struct TcpBench {
    child: Option<Child>,
    errors: BufReader<ChildStderr>,
    slcan: String,
    serial: String,
}

impl TcpBench {
    fn start(drives: &str) -> Self {
        let places = ["--slcan", "tcp:0", "--serial", "tcp:[::1]:0"];
        let words = [&["bench", "--drives", drives, "--json"][..], &places].concat();
        let mut child = motionctl(&words).spawn().expect("motionctl starts");
        let mut errors = BufReader::new(child.stderr.take().expect("it is piped"));
        let mut line = String::new();
        errors.read_line(&mut line).expect("its first line");
        let mut places = line
            .split_whitespace()
            .map(|word| word.trim_end_matches(';'))
            .filter(|word| word.starts_with("tcp:"))
            .map(str::to_owned);
        let mut next = || places.next().unwrap_or_else(|| panic!("{line}"));
        Self {
            slcan: next(),
            serial: next(),
            child: Some(child),
            errors,
        }
    }

    fn address(&self) -> &str {
        self.slcan.trim_start_matches("tcp:")
    }

    /// What it received, and what it said after its first line.
    fn end(mut self) -> (Value, String) {
        let child = self.child.take().expect("it runs");
        interrupt(&child);
        let output = child.wait_with_output().expect("its end");
        assert_eq!(output.status.code(), Some(0));
        let mut log = String::new();
        self.errors.read_to_string(&mut log).expect("its log");
        (serde_json::from_slice(&output.stdout).expect("JSON"), log)
    }
}

impl Drop for TcpBench {
    fn drop(&mut self) {
        if let Some(child) = &mut self.child {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn found(output: &Output) -> Vec<u64> {
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{errors}");
    let scan: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let drives = scan["drives"]
        .as_array()
        .unwrap_or_else(|| panic!("{scan}"));
    let ids = drives.iter().filter_map(|drive| drive["drive"].as_u64());
    ids.collect()
}

fn refused(words: &[&str]) -> (Option<i32>, String) {
    let output = motionctl(words).output().expect("motionctl runs");
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), errors)
}

#[test]
fn drives_behind_ports_of_this_machine_are_found_on_both_protocols() {
    let bench = TcpBench::start("1,9");
    assert!(bench.slcan.starts_with("tcp:127.0.0.1:"), "{}", bench.slcan);
    assert!(bench.serial.starts_with("tcp:[::1]:"), "{}", bench.serial);
    let scan = |link: &[&str]| {
        let output = motionctl(&[&["scan", "--json"], link].concat()).output();
        found(&output.expect("motionctl runs"))
    };
    assert_eq!(scan(&["--slcan", &bench.slcan]), [1, 9]);
    assert_eq!(scan(&["--serial", &bench.serial]), [1, 9]);
    let (report, log) = bench.end();
    assert_eq!(
        (report["refused_by_adapter"].as_u64(), log.as_str()),
        (Some(0), "")
    );
}

#[test]
fn one_host_at_a_time_and_the_next_one_when_it_has_gone() {
    let bench = TcpBench::start("1");
    let mut first = TcpStream::connect(bench.address()).expect("room for one");
    // Its answer says that it was let in.
    first.write_all(b"V\r").expect("written");
    let mut answer = [0; 6];
    first.read_exact(&mut answer).expect("the version");
    assert_eq!(&answer, b"V1013\r");
    let (status, errors) = refused(&["scan", "--slcan", &bench.slcan]);
    assert_eq!(status, Some(3), "{errors}");
    assert!(errors.contains("cannot open tcp:"), "{errors}");
    drop(first);
    wait_until("the port is free again", || {
        let output = motionctl(&["scan", "--json", "--slcan", &bench.slcan]).output();
        output.is_ok_and(|output| output.status.success() && found(&output) == [1])
    });
    let (_, log) = bench.end();
    assert!(
        log.contains("refused 127.0.0.1:") && log.contains("the adapter has one host at a time"),
        "{log}"
    );
}

#[test]
fn other_machines_are_refused_on_both_sides_and_a_port_without_a_bench_is_told() {
    for place in ["tcp:0.0.0.0:0", "tcp:[::]:0", "tcp:192.168.0.1:7000"] {
        let (status, errors) = refused(&["bench", "--slcan", place]);
        assert_eq!(status, Some(2), "{errors}");
        assert!(errors.contains("other machines are refused"), "{errors}");
        let (status, errors) = refused(&["scan", "--slcan", place]);
        assert_eq!(status, Some(3), "{errors}");
        assert!(errors.contains("other machines are refused"), "{errors}");
    }
    // Nobody listens at a port that was just given back.
    let free = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let place = format!("tcp:{}", free.local_addr().expect("its address"));
    let (status, errors) = refused(&["bench", "--slcan", &place]);
    assert_eq!(status, Some(2), "{errors}");
    assert!(
        errors.contains("another program listens there already"),
        "{errors}"
    );
    drop(free);
    let (status, errors) = refused(&["scan", "--slcan", &place]);
    assert_eq!(status, Some(3), "{errors}");
    assert!(
        errors.contains(&format!("nobody listens at {place}")),
        "{errors}"
    );
}

#[test]
fn a_motion_ends_whole_and_its_drives_are_off_after_it() {
    undisturbed(|| {
        let bench = TcpBench::start("1");
        let file = Scratch::new("tcp-motion.csv", "time_s,a_deg\n0,0\n0.5,90\n1,180\n");
        // A motion leaves each drive as it was.
        let disable = ["disable", "--slcan", &bench.slcan, "--drives", "1"];
        assert!(motionctl(&disable).status().expect("it runs").success());
        let link = ["--slcan", &bench.slcan, "--trajectory", file.as_str()];
        let run = [&["run", "--json", "--yes"][..], &link].concat();
        let output = motionctl(&run).output().expect("motionctl runs");
        let summary = String::from_utf8_lossy(&output.stdout);
        assert_eq!(output.status.code(), Some(0), "{summary}");
        let summary: Value = serde_json::from_str(&summary).expect("JSON");
        let sent = &summary["axes"][0]["sent_counts"];
        assert_ne!(sent.as_i64(), Some(0), "{summary}");
        let (report, _) = bench.end();
        let drive = &report["drives"][0];
        assert_eq!(&drive["received_counts"], sent, "{report}");
        assert_eq!(drive["enabled"], false, "{report}");
    });
}
