//! Signals that end a program unless it minds them, sent by mistake, by a timer or by a limit of the system: the drives are off behind
//! them.

use std::fs::File;
use std::process::{Child, Command, Stdio};

use rustix::process::{Pid, Signal, kill_process};

use crate::bench::{BenchProcess, motionctl, scratch, start_and_wait_for};
use crate::undisturbed::undisturbed;

const SIGNALS: [Signal; 8] = [
    Signal::USR1,
    Signal::USR2,
    Signal::ALARM,
    Signal::VTALARM,
    Signal::PROF,
    Signal::IO,
    Signal::XCPU,
    Signal::POWER,
];

/// Drive 1 is off when the tool comes.
fn bench(name: &str) -> BenchProcess {
    let bench = BenchProcess::start(name, "1");
    bench.disable("1");
    bench
}

fn enable(bench: &BenchProcess) -> Child {
    let command = motionctl(&["enable", "--slcan", bench.path(), "--drives", "1", "--yes"]);
    start_and_wait_for(command, "drive 1 is enabled and holds")
}

/// Whether drive 1 is on, and how far it was moved.
fn drive(bench: BenchProcess) -> (bool, bool) {
    let report = bench.stop();
    let drive = &report["drives"][0];
    (drive["enabled"] == true, drive["received_counts"] != 0)
}

#[test]
fn no_signal_ends_the_tool_in_front_of_its_drives() {
    for signal in SIGNALS {
        undisturbed(|| {
            let bench = bench("other-signal");
            let child = enable(&bench);
            kill_process(Pid::from_child(&child), signal).expect("the process is there");
            let output = child.wait_with_output().expect("its output");
            // A status: it was not ended by the signal.
            assert!(output.status.code().is_some(), "{signal:?}: {output:?}");
            assert_eq!(drive(bench), (false, false), "{signal:?}: {output:?}");
        });
    }
}

#[test]
fn a_file_that_may_not_grow_does_not_end_the_tool_in_front_of_its_drives() {
    undisturbed(|| {
        let errors = scratch("may-not-grow.err");
        let bench = bench("may-not-grow");
        let mut command = Command::new("sh");
        command
            .args(["-c", "ulimit -f 0 && exec \"$@\"", "sh"])
            .arg(env!("CARGO_BIN_EXE_motionctl"))
            .args(["enable", "--slcan", bench.path(), "--drives", "1", "--yes"])
            .args(["--for", "1"])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            // What is told first is told when the drive is on.
            .stderr(File::create(&errors).expect("a temporary file"));
        let status = command.status().expect("a shell");
        std::fs::remove_file(&errors).expect("it is there");
        assert_eq!(status.code(), Some(0), "{status:?}");
        assert_eq!(drive(bench), (false, false));
    });
}
