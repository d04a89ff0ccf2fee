//! Tests in real time presume a machine that gives every process its time. One that does not is told apart from a tool that is wrong.

use std::os::fd::OwnedFd;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rustix::fs::{Mode, OFlags, open};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// As long as a request waits for its reply (`can_motion::Timeouts`). A thread that wants to run has to wait for less than this on a
/// machine that is not busy with other things, and three such waits in a row lose a drive.
const LONGEST_WAIT: Duration = Duration::from_millis(10);
/// How often a test is played before its failure counts all the same.
const ATTEMPTS: usize = 6;

/// Plays a test. When it fails and the machine let a thread wait meanwhile, it shows nothing, and is played again.
pub(crate) fn undisturbed(test: impl Fn()) {
    for _ in 1..ATTEMPTS {
        let watch = Watch::start();
        let result = catch_unwind(AssertUnwindSafe(&test));
        let wait = watch.stop();
        match result {
            Ok(()) => return,
            Err(failure) if wait < LONGEST_WAIT => resume_unwind(failure),
            Err(_) => println!("to be played again: the machine let a thread wait for {wait:?}"),
        }
        await_calm();
    }
    test();
}

/// Waits for a second in which no thread has to wait, at most a minute.
fn await_calm() {
    for _ in 0..60 {
        let watch = Watch::start();
        std::thread::sleep(Duration::from_secs(1));
        if watch.stop() < LONGEST_WAIT {
            return;
        }
    }
}

/// Two threads that note how late things are: one that wakes every millisecond, and one that sends a byte through a terminal. A thread of the
/// kernel carries that, and it can be late when no other thread is: a bench behind a terminal stands still then.
struct Watch {
    is_over: Arc<AtomicBool>,
    threads: [JoinHandle<Duration>; 2],
}

impl Watch {
    fn start() -> Self {
        let is_over = Arc::new(AtomicBool::new(false));
        let watch = |late: fn(&AtomicBool) -> Duration| {
            let is_over = Arc::clone(&is_over);
            std::thread::spawn(move || late(&is_over))
        };
        let threads = [watch(longest_sleep), watch(longest_way)];
        Self { is_over, threads }
    }

    /// The longest time for which one of them had to wait.
    fn stop(self) -> Duration {
        self.is_over.store(true, Ordering::Relaxed);
        let waits = self
            .threads
            .map(|thread| thread.join().expect("it only waits"));
        waits.into_iter().max().unwrap_or_default()
    }
}

fn longest_sleep(is_over: &AtomicBool) -> Duration {
    let mut longest = Duration::ZERO;
    let mut ran_at = Instant::now();
    while !is_over.load(Ordering::Relaxed) {
        std::thread::sleep(Duration::from_millis(1));
        let wait = std::mem::replace(&mut ran_at, Instant::now()).elapsed();
        longest = longest.max(wait);
    }
    longest
}

fn longest_way(is_over: &AtomicBool) -> Duration {
    let (near, far) = terminal();
    let mut longest = Duration::ZERO;
    while !is_over.load(Ordering::Relaxed) {
        let sent_at = Instant::now();
        rustix::io::write(&far, b"x").expect("the terminal takes a byte");
        rustix::io::read(&near, &mut [0_u8; 1]).expect("the byte");
        longest = longest.max(sent_at.elapsed());
        std::thread::sleep(Duration::from_millis(1));
    }
    longest
}

/// Both ends of a terminal that changes no byte.
fn terminal() -> (OwnedFd, OwnedFd) {
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
    let near = openpt(flags).expect("a pseudo-terminal");
    grantpt(&near).expect("granted");
    unlockpt(&near).expect("unlocked");
    let name = ptsname(&near, Vec::new()).expect("a name");
    let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC;
    let far = open(name.as_c_str(), flags, Mode::empty()).expect("its line");
    let mut settings = tcgetattr(&far).expect("its settings");
    settings.make_raw();
    tcsetattr(&far, OptionalActions::Now, &settings).expect("they are set");
    (near, far)
}
