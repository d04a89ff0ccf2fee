//! Tests in real time presume a machine that gives every process its time. One that does not is told apart from a tool that is wrong.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

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

/// A thread that wakes every millisecond and notes how late it was.
struct Watch {
    is_over: Arc<AtomicBool>,
    thread: JoinHandle<Duration>,
}

impl Watch {
    fn start() -> Self {
        let is_over = Arc::new(AtomicBool::new(false));
        let over = Arc::clone(&is_over);
        let thread = std::thread::spawn(move || {
            let mut longest = Duration::ZERO;
            let mut ran_at = Instant::now();
            while !over.load(Ordering::Relaxed) {
                std::thread::sleep(Duration::from_millis(1));
                let wait = std::mem::replace(&mut ran_at, Instant::now()).elapsed();
                longest = longest.max(wait);
            }
            longest
        });
        Self { is_over, thread }
    }

    /// The longest time for which it had to wait.
    fn stop(self) -> Duration {
        self.is_over.store(true, Ordering::Relaxed);
        self.thread.join().expect("it only waits")
    }
}
