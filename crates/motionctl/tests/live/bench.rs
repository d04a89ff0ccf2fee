//! `motionctl bench` as a process of its own, for tests.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process};

/// Long enough for a machine that is busy with other things.
const PATIENCE: Duration = Duration::from_secs(60);

/// The tool, ready to be given arguments. It has no terminal to ask on.
pub(crate) fn motionctl(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_motionctl"));
    command
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    command
}

/// A path of its own for each test.
pub(crate) fn scratch(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("motionctl-{}-{name}", std::process::id()))
}

/// Waits until something is the case.
pub(crate) fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < PATIENCE, "still waiting until {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Starts a command and reads its error output until it has said something, or has ended.
pub(crate) fn start_and_wait_for(mut command: Command, text: &str) -> Child {
    let mut child = command.spawn().expect("motionctl starts");
    let errors = child.stderr.as_mut().expect("it is piped");
    let mut heard = Vec::new();
    while !String::from_utf8_lossy(&heard).contains(text) {
        let mut byte = [0];
        let length = errors.read(&mut byte).expect("its error output");
        assert_eq!(length, 1, "it ended: {}", String::from_utf8_lossy(&heard));
        heard.push(byte[0]);
    }
    child
}

/// Sends what Ctrl-C sends.
pub(crate) fn interrupt(child: &Child) {
    kill_process(Pid::from_child(child), Signal::INT).expect("the process is there");
}

/// A bench that is running.
pub(crate) struct BenchProcess {
    child: Option<Child>,
    path: PathBuf,
    serial_path: PathBuf,
}

impl BenchProcess {
    /// Starts a bench with these drives and waits until its terminal is there.
    pub(crate) fn start(name: &str, drives: &str) -> Self {
        Self::spawn(name, drives, &[])
    }

    /// The same with options of the bench.
    pub(crate) fn start_with(name: &str, drives: &str, options: &[&str]) -> Self {
        Self::spawn(name, drives, options)
    }

    /// The same with the serial port of the drives.
    pub(crate) fn start_with_serial(name: &str, drives: &str, options: &[&str]) -> Self {
        let serial_path = scratch(&format!("{name}-port"));
        let port = ["--serial", path_text(&serial_path)];
        let bench = Self::spawn(name, drives, &[&port, options].concat());
        wait_until("the serial terminal is there", || serial_path.exists());
        // The drives are ready 150 ms after power-on.
        std::thread::sleep(Duration::from_millis(300));
        bench
    }

    fn spawn(name: &str, drives: &str, options: &[&str]) -> Self {
        let path = scratch(name);
        let adapter = ["bench", "--slcan", path_text(&path), "--json"];
        // Without ids there are only drives that have none.
        let ids = ["--drives", drives];
        let ids = &ids[..if drives.is_empty() { 0 } else { 2 }];
        let child = motionctl(&[&adapter, ids, options].concat())
            .spawn()
            .expect("the bench starts");
        wait_until("the terminal is there", || path.exists());
        Self {
            child: Some(child),
            serial_path: scratch(&format!("{name}-port")),
            path,
        }
    }

    /// The terminal of the drives' serial port.
    pub(crate) fn serial_path(&self) -> &str {
        path_text(&self.serial_path)
    }

    /// The terminal.
    pub(crate) fn path(&self) -> &str {
        self.path.to_str().expect("a path of plain text")
    }

    /// Runs a command on its adapter to its end.
    pub(crate) fn run(&self, arguments: &[&str]) -> Output {
        let (command, options) = arguments.split_first().expect("a command");
        let link = [command, "--slcan", self.path()];
        motionctl(&[&link, options].concat())
            .output()
            .expect("motionctl runs")
    }

    /// Switches drives off, which come up with their servo on.
    pub(crate) fn disable(&self, drives: &str) {
        let output = self.run(&["disable", "--drives", drives]);
        assert_eq!(output.status.code(), Some(0), "{output:?}");
    }

    /// Ends it as Ctrl-C does and returns what its drives have received.
    pub(crate) fn stop(self) -> serde_json::Value {
        serde_json::from_slice(&self.end().stdout).expect("JSON")
    }

    /// Ends it as Ctrl-C does.
    pub(crate) fn end(mut self) -> Output {
        let child = self.child.take().expect("it runs");
        interrupt(&child);
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        output
    }

    /// It does nothing any more until it is let go on, as an adapter that hangs.
    pub(crate) fn freeze(&self, frozen: bool) {
        let child = self.child.as_ref().expect("it runs");
        let signal = if frozen { Signal::STOP } else { Signal::CONT };
        kill_process(Pid::from_child(child), signal).expect("the process is there");
    }

    /// Sends it a signal.
    pub(crate) fn signal(&self, signal: Signal) {
        let child = self.child.as_ref().expect("it runs");
        kill_process(Pid::from_child(child), signal).expect("the process is there");
    }

    /// Ends it as a pulled plug does.
    pub(crate) fn kill(&mut self) {
        let child = self.child.as_mut().expect("it runs");
        child.kill().expect("it can be ended");
    }
}

impl Drop for BenchProcess {
    fn drop(&mut self) {
        if let Some(mut child) = self.child.take() {
            // It may have ended by itself.
            let _ = child.kill();
            let _ = child.wait();
        }
        let _ = std::fs::remove_file(&self.path);
        let _ = std::fs::remove_file(&self.serial_path);
    }
}

/// A file that is removed afterwards.
pub(crate) struct Scratch(PathBuf);

impl Scratch {
    /// A file with this text.
    pub(crate) fn new(name: &str, text: &str) -> Self {
        let path = scratch(name);
        std::fs::write(&path, text).expect("a temporary file");
        Self(path)
    }

    /// Its path.
    pub(crate) fn path(&self) -> &str {
        path_text(&self.0)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        // Nothing depends on it: the folder is temporary.
        let _ = std::fs::remove_file(&self.0);
    }
}

fn path_text(path: &Path) -> &str {
    path.to_str().expect("a path of plain text")
}

/// Exit status and error output.
pub(crate) fn status_and_errors(output: &Output) -> (Option<i32>, String) {
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    (output.status.code(), errors)
}
