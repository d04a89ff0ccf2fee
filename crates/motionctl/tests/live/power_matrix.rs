//! Every command that enables, ended in every way at every stage; then the drives are read.
//!
//! Drive 1 is off when the tool comes and must be off when it has gone, or the tool must have said that it may be on. Drive 2 is on
//! and must stay as it is.

use std::fs::OpenOptions;
use std::panic::resume_unwind;
use std::process::{Child, Stdio};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};

use crate::adapter::{End, FakeAdapter, Manner, Mishap, Stage};
use crate::bench::{Scratch, motionctl, status_and_errors};
use crate::undisturbed::undisturbed;

/// Two axes that go on for ten seconds: longer than any case lets them.
const LONG: &str = "time_s,a,b\n0,0,0\n10,3600,-3600\n";
/// The same for less than a second.
const SHORT: &str = "time_s,a,b\n0,0,0\n0.5,90,-90\n";

/// What ends the tool, or tries to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Ending {
    Signal(Signal),
    /// Nobody reads any more.
    ClosedOutput,
    ClosedErrors,
    ClosedBoth,
    /// From the start on.
    FullOutput,
    FullErrors,
    /// The adapter is pulled out.
    Vanished,
    /// The adapter does nothing any more.
    Frozen,
    /// Of the drive that was on before; of the only one where there is only one.
    Alarm,
}

const SIGNALS: [Signal; 5] = [
    Signal::INT,
    Signal::TERM,
    Signal::HUP,
    Signal::QUIT,
    Signal::TSTP,
];
const STAGES: [Stage; 4] = [
    Stage::Looks,
    Stage::Enables,
    Stage::Streams,
    Stage::Disables,
];

/// One of the commands that enable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Command {
    Run,
    Jog,
    Enable,
}

struct Case {
    command: Command,
    stage: Stage,
    ending: Ending,
}

impl Case {
    fn name(&self) -> String {
        format!("{:?}-{:?}-{:?}", self.command, self.stage, self.ending)
    }

    /// Whether the command would go on without the ending.
    fn is_long(&self) -> bool {
        let needs_time = matches!(
            self.ending,
            Ending::Signal(_) | Ending::Vanished | Ending::Frozen | Ending::Alarm
        );
        needs_time && self.stage != Stage::Disables
    }

    fn arguments<'a>(&self, file: &'a Scratch) -> Vec<&'a str> {
        match self.command {
            Command::Run => {
                let motion = ["run", "--trajectory", file.path(), "--cycle-us", "4000"];
                [&motion[..], &["--max-turns", "20"]].concat()
            }
            Command::Jog if self.is_long() => vec!["jog", "--drive", "1", "--turns", "10"],
            Command::Jog => vec!["jog", "--drive", "1", "--turns", "0.25"],
            Command::Enable if self.is_long() => vec!["enable", "--drives", "1,2"],
            Command::Enable => vec!["enable", "--drives", "1,2", "--for", "1"],
        }
    }

    fn spawn(&self, adapter: &FakeAdapter, file: &Scratch) -> Child {
        let link = ["--slcan", adapter.path(), "--yes"];
        let mut command = motionctl(&[&self.arguments(file)[..], &link].concat());
        let full = || {
            let full = OpenOptions::new().write(true).open("/dev/full");
            Stdio::from(full.expect("/dev/full"))
        };
        match self.ending {
            Ending::FullOutput => command.stdout(full()),
            Ending::FullErrors => command.stderr(full()),
            _ => &mut command,
        };
        command.spawn().expect("motionctl starts")
    }

    /// What the adapter does by itself when the tool has come to the stage.
    fn mishap(&self) -> Option<Mishap> {
        match self.ending {
            Ending::Vanished => Some(Mishap::Vanishes),
            Ending::Frozen => Some(Mishap::Freezes),
            Ending::Alarm if self.command == Command::Jog => Some(Mishap::Alarm(0)),
            Ending::Alarm => Some(Mishap::Alarm(1)),
            _ => None,
        }
    }

    /// Starts, waits for the stage, ends; returns exit status, everything that was said, and the drives.
    fn play(&self) -> (Option<i32>, String, End) {
        let text = if self.is_long() { LONG } else { SHORT };
        let file = Scratch::new(&format!("{}.csv", self.name()), text);
        let mishap = self.mishap().map(|mishap| (self.stage, mishap));
        let adapter = FakeAdapter::start_until(&self.name(), Manner::LAWICEL, mishap);
        let mut child = self.spawn(&adapter, &file);
        if !matches!(self.ending, Ending::FullOutput | Ending::FullErrors) {
            // One that ends before has said why.
            adapter.await_stage_or(self.stage, || {
                child.try_wait().is_ok_and(|end| end.is_some())
            });
        }
        match self.ending {
            Ending::Signal(signal) => {
                // One that has ended by itself says by its status and its words why.
                let _ = kill_process(Pid::from_child(&child), signal);
            }
            Ending::ClosedOutput => drop(child.stdout.take()),
            Ending::ClosedErrors => drop(child.stderr.take()),
            Ending::ClosedBoth => drop((child.stdout.take(), child.stderr.take())),
            Ending::FullOutput
            | Ending::FullErrors
            | Ending::Vanished
            | Ending::Frozen
            | Ending::Alarm => {}
        }
        let output = child.wait_with_output().expect("its output");
        let (status, errors) = status_and_errors(&output);
        let said = errors + &String::from_utf8_lossy(&output.stdout);
        let was_enabled = adapter.has_reached(Stage::Enables);
        let never = self.stage == Stage::Looks && self.ending == Ending::Alarm;
        assert!(!(never && was_enabled), "{}: {said}", self.name());
        (status, said, adapter.stop())
    }

    fn check(&self) {
        let name = self.name();
        let (status, said, end) = self.play();
        let [first, second] = end.drives;
        let case = format!("{name}: status {status:?}, {end:?}, said:\n{said}");
        assert!(second.enabled || self.ending == Ending::Alarm, "{case}");
        if matches!(self.ending, Ending::Vanished | Ending::Frozen) {
            let is_said = match self.ending {
                Ending::Vanished => [
                    "drive 1 may still be ENABLED",
                    "drives 1, 2 may still be ENABLED",
                ]
                .iter()
                .any(|text| said.contains(text)),
                _ => said.contains("drive 1 did not confirm that it is DISABLED"),
            };
            assert!(!first.enabled || is_said, "{case}");
            let is_known = self.ending == Ending::Vanished;
            // One that hangs looks like a drive that does not answer, before anything and after everything.
            let is_as_usual = status == Some(3) || !is_known && status == Some(1);
            assert!(is_as_usual, "{case}");
            return;
        }
        assert!(!first.enabled, "{case}");
        let is_as_usual = match self.ending {
            // One that comes when everything is over changes nothing.
            Ending::Signal(_) if self.stage == Stage::Disables => true,
            Ending::Signal(_) => {
                status == Some(130) || self.command == Command::Enable && status == Some(0)
            }
            Ending::FullOutput => status == Some(1) && said.contains("cannot write"),
            Ending::ClosedOutput
            | Ending::ClosedErrors
            | Ending::ClosedBoth
            | Ending::FullErrors => status == Some(0),
            Ending::Alarm if self.stage == Stage::Disables => true,
            Ending::Alarm => status == Some(1) && said.contains("alarm, over-current"),
            Ending::Vanished | Ending::Frozen => false,
        };
        assert!(is_as_usual, "{case}");
        let is_found = self.command != Command::Jog && self.stage > Stage::Enables;
        if is_found && matches!(self.ending, Ending::Signal(_)) {
            assert!(said.contains("drive 2 was enabled before"), "{case}");
        }
        // Nothing was sent once it was off. One that switched itself off by its alarm was sent what was under way.
        let is_its_own = self.ending == Ending::Alarm && self.command == Command::Jog;
        assert!(first.ignored == 0 || is_its_own, "{case}");
    }
}

/// All cases of a command with these endings.
fn all(command: Command, endings: &[Ending]) {
    let cases: Vec<Case> = endings
        .iter()
        .flat_map(|&ending| {
            let is_from_start = matches!(ending, Ending::FullOutput | Ending::FullErrors);
            let stages = if is_from_start {
                &STAGES[..1]
            } else {
                &STAGES[..]
            };
            stages.iter().map(move |&stage| Case {
                command,
                stage,
                ending,
            })
        })
        .collect();
    // Two at a time: most of a case is waiting.
    let half = cases.len().div_ceil(2);
    std::thread::scope(|scope| {
        let play = |cases: &[Case]| cases.iter().for_each(|case| undisturbed(|| case.check()));
        let halves: Vec<_> = cases
            .chunks(half)
            .map(|half| scope.spawn(move || play(half)))
            .collect();
        for half in halves {
            half.join().unwrap_or_else(|failure| resume_unwind(failure));
        }
    });
    println!("{command:?}: {} cases", cases.len());
}

fn endings() -> Vec<Ending> {
    let others = [
        Ending::ClosedOutput,
        Ending::ClosedErrors,
        Ending::ClosedBoth,
        Ending::FullOutput,
        Ending::FullErrors,
        Ending::Vanished,
        Ending::Frozen,
        Ending::Alarm,
    ];
    SIGNALS
        .map(Ending::Signal)
        .into_iter()
        .chain(others)
        .collect()
}

#[test]
fn run_leaves_nothing_on() {
    all(Command::Run, &endings());
}

#[test]
fn jog_leaves_nothing_on() {
    all(Command::Jog, &endings());
}

#[test]
fn enable_leaves_nothing_on() {
    all(Command::Enable, &endings());
}

#[test]
fn two_interrupts_in_motion_stop_at_once_and_switch_off() {
    undisturbed(|| {
        let file = Scratch::new("twice.csv", LONG);
        let adapter = FakeAdapter::start("twice", Manner::LAWICEL);
        let case = Case {
            command: Command::Run,
            stage: Stage::Streams,
            ending: Ending::Signal(Signal::INT),
        };
        let child = case.spawn(&adapter, &file);
        adapter.await_stage(Stage::Streams);
        for _ in 0..2 {
            kill_process(Pid::from_child(&child), Signal::INT).expect("the process is there");
            std::thread::sleep(Duration::from_millis(20));
        }
        let output = child.wait_with_output().expect("its output");
        assert_eq!(output.status.code(), Some(130), "{output:?}");
        let end = adapter.stop();
        assert_eq!(end.drives.map(|drive| drive.enabled), [false, true]);
    });
}
