//! A simulated board as a process of its own, and a serial line to it that damages what it carries.

use std::fs::File;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::process::{Child, ChildStdin, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;

use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;

use crate::bench::{Scratch, interrupt, motionctl, scratch, wait_until};
use crate::terminal::Terminal;
use crate::tool::bus::steps;

/// Two drives, at the speed and acceleration that `motionctl board run` allows, with room to stop.
pub(crate) const SETTINGS: &str = "\
format = 1
name = \"test\"

[bus]
bit_rate_kbit_per_s = 1000

[[axis]]
drive = 1
gear_number = 4096
speed_rpm = 600
acceleration_rpm_per_s = 10000
travel_min_millidegrees = -9000000
travel_max_millidegrees = 9000000

[[axis]]
drive = 2
gear_number = 4096
speed_rpm = 600
acceleration_rpm_per_s = 10000
travel_min_millidegrees = -9000000
travel_max_millidegrees = 9000000
";

/// A bench with a board.
pub(crate) struct BoardBench {
    child: Option<Child>,
    inputs: Option<ChildStdin>,
    port: PathBuf,
    settings: Scratch,
    log: Scratch,
}

impl BoardBench {
    /// A board with these settings, which may be empty.
    pub(crate) fn start(name: &str, settings: &str) -> Self {
        Self::start_with(name, settings, &[])
    }

    /// The same, with more options of the bench.
    pub(crate) fn start_with(name: &str, settings: &str, more: &[&str]) -> Self {
        let port = scratch(&format!("{name}-board"));
        let log = Scratch::new(&format!("{name}-bus.log"), "");
        let flash = Scratch::new(&format!("{name}-flash.toml"), settings);
        if settings.is_empty() {
            std::fs::remove_file(flash.path()).expect("it was there");
        }
        let port_text = port.to_str().expect("plain text");
        let mut command = motionctl(&[
            "bench",
            "--drives",
            "1,2",
            "--board",
            port_text,
            "--settings",
            flash.path(),
            "--candump",
            log.path(),
            "--inputs",
            "--json",
        ]);
        let mut child = command
            .args(more)
            .stdin(Stdio::piped())
            .spawn()
            .expect("the bench starts");
        wait_until("the board is there", || port.exists());
        let bench = Self {
            inputs: child.stdin.take(),
            child: Some(child),
            port,
            settings: flash,
            log,
        };
        // The drives are ready 150 ms after power-on, and the board has to ask them everything.
        std::thread::sleep(std::time::Duration::from_millis(500));
        bench
    }

    pub(crate) fn port(&self) -> &str {
        self.port.to_str().expect("plain text")
    }

    pub(crate) fn settings_path(&self) -> &str {
        self.settings.path()
    }

    /// What somebody does at the board.
    pub(crate) fn tell(&mut self, line: &str) {
        let inputs = self.inputs.as_mut().expect("they are open");
        writeln!(inputs, "{line}").expect("it reads");
    }

    /// The power of board and drives goes off and on.
    pub(crate) fn power_cycle(&self) {
        let child = self.child.as_ref().expect("it runs");
        kill_process(Pid::from_child(child), Signal::USR1).expect("the process is there");
        std::thread::sleep(std::time::Duration::from_secs(1));
    }

    /// Runs a word of `motionctl board` on it: exit status, what it printed, its errors.
    pub(crate) fn run(&self, words: &[&str]) -> (Option<i32>, String, String) {
        run_at(self.port(), words)
    }

    /// Starts a word.
    pub(crate) fn spawn(&self, words: &[&str]) -> Child {
        motionctl(&[&["board"], words, &["--port", self.port()]].concat())
            .spawn()
            .expect("motionctl starts")
    }

    /// The state of the board.
    pub(crate) fn info(&self) -> Value {
        let (status, text, errors) = self.run(&["info", "--json"]);
        assert_eq!(status, Some(0), "{errors}");
        serde_json::from_str(&text).expect("JSON")
    }

    /// Ends it: its report, and the steps of its drives.
    pub(crate) fn end(mut self) -> (Value, Vec<Vec<i64>>) {
        let child = self.child.take().expect("it runs");
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let report = serde_json::from_slice(&output.stdout).expect("JSON");
        (report, steps(self.log.path(), 2))
    }
}

impl Drop for BoardBench {
    fn drop(&mut self) {
        if let Some(mut child) = self.child.take() {
            // It may have ended by itself.
            let _ = child.kill();
            let _ = child.wait();
        }
        let _ = std::fs::remove_file(&self.port);
    }
}

/// Runs a word on a port.
pub(crate) fn run_at(port: &str, words: &[&str]) -> (Option<i32>, String, String) {
    let output = motionctl(&[&["board"], words, &["--port", port]].concat())
        .output()
        .expect("motionctl runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, errors) = (text(&output.stdout), text(&output.stderr));
    (output.status.code(), out, errors)
}

/// A line that changes a bit of one in so many bytes, both ways.
pub(crate) struct DamagedLine {
    link: PathBuf,
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<u64>>,
}

impl DamagedLine {
    pub(crate) fn start(bench: &BoardBench, one_in: u64) -> Self {
        let link = scratch("damaged-board");
        let mut host = Terminal::new(&link);
        let mut board = File::options()
            .read(true)
            .write(true)
            .open(bench.port())
            .expect("the port of the board");
        rustix::io::ioctl_fionbio(&board, true).expect("without waiting");
        let is_over = Arc::new(AtomicBool::new(false));
        let over = Arc::clone(&is_over);
        let thread = std::thread::spawn(move || {
            let (mut place, mut damaged) = (0_u64, 0);
            let mut damage = |bytes: &mut [u8]| {
                for byte in bytes {
                    place += 1;
                    if place.is_multiple_of(one_in) {
                        *byte ^= 1 << (place / one_in % 8);
                        damaged += 1;
                    }
                }
            };
            let mut to_host = Vec::new();
            while !over.load(Ordering::Relaxed) {
                let mut sent = host.read();
                damage(&mut sent);
                board.write_all(&sent).expect("room");
                let mut buffer = [0; 4_096];
                if let Ok(length) = board.read(&mut buffer) {
                    damage(&mut buffer[..length]);
                    to_host.extend_from_slice(&buffer[..length]);
                }
                host.write(&mut to_host, None);
            }
            damaged
        });
        Self {
            link,
            is_over,
            thread: Some(thread),
        }
    }

    pub(crate) fn port(&self) -> &str {
        self.link.to_str().expect("plain text")
    }

    /// Ends it: so many bytes were damaged.
    pub(crate) fn end(mut self) -> u64 {
        self.is_over.store(true, Ordering::Relaxed);
        let thread = self.thread.take().expect("it runs");
        thread.join().expect("it carries on")
    }
}

impl Drop for DamagedLine {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        let _ = std::fs::remove_file(&self.link);
    }
}
