//! A serial line between the tool and a bench, with the faults that lines have.

use std::fs::File;
use std::io::{Read, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::bench::{BenchProcess, motionctl, scratch, status_and_errors};
use crate::terminal::Terminal;

/// What a line does besides carrying bytes.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Line {
    /// It brings back what the host sends, after so long.
    pub(crate) echo: Option<Duration>,
    /// Replies take so much longer.
    pub(crate) replies_late: Duration,
    /// Settings (functions 10h to 17h) never reach the drive.
    pub(crate) drops_settings: bool,
    /// Nothing reaches the drive.
    pub(crate) drops_all: bool,
    /// What is on it when the host opens it.
    pub(crate) stale: &'static [u8],
}

/// A line between the tool and a bench.
pub(crate) struct Relay {
    link: PathBuf,
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Relay {
    pub(crate) fn start(name: &str, bench: &BenchProcess, line: Line) -> Self {
        Self::start_at(scratch(&format!("relay-{name}")), bench, line)
    }

    /// The same with its terminal at a path.
    pub(crate) fn start_at(link: PathBuf, bench: &BenchProcess, line: Line) -> Self {
        let mut host = Terminal::new(&link);
        let mut drives = File::options()
            .read(true)
            .write(true)
            .open(bench.serial_path())
            .expect("the port of the bench");
        rustix::io::ioctl_fionbio(&drives, true).expect("without waiting");
        let is_over = Arc::new(AtomicBool::new(false));
        let over = Arc::clone(&is_over);
        let thread = std::thread::spawn(move || {
            let mut to_host = line.stale.to_vec();
            let mut echoes: Vec<(Instant, Vec<u8>)> = Vec::new();
            let mut replies: Vec<(Instant, Vec<u8>)> = Vec::new();
            while !over.load(Ordering::Relaxed) {
                let sent = host.read();
                if let Some(delay) = line.echo.filter(|_| !sent.is_empty()) {
                    echoes.push((Instant::now() + delay, sent.clone()));
                }
                let is_setting = sent
                    .get(1)
                    .is_some_and(|second| (0x10..=0x17).contains(&(second & 0x1F)));
                if !(line.drops_all || line.drops_settings && is_setting) {
                    drives.write_all(&sent).expect("room");
                }
                let mut buffer = [0; 256];
                if let Ok(length) = drives.read(&mut buffer) {
                    let at = Instant::now() + line.replies_late;
                    replies.push((at, buffer[..length].to_vec()));
                }
                for queue in [&mut echoes, &mut replies] {
                    while queue.first().is_some_and(|(at, _)| *at <= Instant::now()) {
                        to_host.extend(queue.remove(0).1);
                    }
                }
                host.write(&mut to_host, None);
            }
        });
        Self {
            link,
            is_over,
            thread: Some(thread),
        }
    }

    /// Runs a command on it: exit status, what it printed, its errors.
    pub(crate) fn run(&self, arguments: &[&str]) -> (Option<i32>, String, String) {
        let (name, options) = arguments.split_first().expect("a command");
        let link = [*name, "--serial", self.link.to_str().expect("plain text")];
        let output = motionctl(&[&link[..], options].concat())
            .output()
            .expect("motionctl runs");
        let (status, errors) = status_and_errors(&output);
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        (status, text, errors)
    }
}

impl Drop for Relay {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
        let _ = std::fs::remove_file(&self.link);
    }
}
