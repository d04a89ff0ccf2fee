//! A script of commissioning, from its start to its end.

use dyn_commission::{Commissioner, Script};

use crate::drives::DrivesError;
use crate::link::Link;
use crate::station::{Clock, StallWatch, serve_until};

/// How often a script is told that time passes, in microseconds.
const TICK_US: u32 = 1_000;

/// How long each drive has to answer: adapters on USB hold bytes back for up to 16 ms, and the system lets a program wait.
pub(super) const LISTEN_US: u32 = 50_000;

/// Runs a script; shows it after each step.
pub(super) fn run<S: Script<Result: Clone>>(
    link: &mut Link,
    script: S,
    mut show: impl FnMut(&S),
) -> Result<S::Result, DrivesError> {
    let clock = Clock::start();
    let mut task = Commissioner::new(script);
    let mut watch = StallWatch::new(task.windows(), clock.now());
    loop {
        show(task.script());
        if let Some(result) = task.result() {
            return Ok(result.clone());
        }
        serve_until(&mut task, link, &clock, clock.now() + TICK_US)?;
        task.tick(clock.now());
        if watch.stalls_at(task.windows(), clock.now()) {
            return Err(DrivesError::NothingGetsOut);
        }
    }
}
