//! The orders of an image that takes none: it plays the built-in motion as the inputs say. With `link` they come from `link`.

use can_motion::Instant;
use trajectory::curve::Playhead;

use crate::board::Watchdog;
use crate::config::{self, AXES, Drives, GROUP, MOTION};
use crate::drives::{Board as _, BoardMaster};
use crate::home::Homing as _;
use crate::last_words::History;
use crate::start::Cause;
use crate::supervisor::{Axes, Inputs, State, Supervisor};
use crate::telemetry::{self, Message};
use crate::words;

/// Length of the motion; 32 bits of microseconds are more than an hour.
const DURATION_US: u32 = {
    let us = MOTION.duration_us();
    assert!(
        0 < us && us <= u32::MAX as u64,
        "the motion must take some time, at most 71 minutes"
    );
    us as u32
};

/// Where and when the motion began.
#[derive(Clone, Copy)]
struct Start {
    /// When the present repetition began.
    at: Instant,
    targets: [i32; AXES],
    /// It ends with the present repetition.
    is_last: bool,
    head: Playhead,
}

/// The motion under way.
pub(crate) struct Orders {
    start: Option<Start>,
}

impl Orders {
    /// Nothing is played yet.
    const fn new() -> Self {
        Self { start: None }
    }

    /// A cycle without a bus.
    #[inline(always)]
    pub(crate) const fn wait(&mut self, _: bool) {}

    /// What the supervisor sees of the inputs: what they are.
    #[inline(always)]
    pub(crate) const fn rule(
        &mut self,
        _: &mut Supervisor,
        (inputs, _): (Inputs, Axes),
        _: &mut BoardMaster,
        _: Instant,
    ) -> Inputs {
        inputs
    }

    /// Where the machine is: nobody asks.
    #[inline(always)]
    pub(crate) const fn note(&mut self, _: State, _: &BoardMaster) {}

    /// Starts the motion at `at`, from where the axes stand, and repeats it.
    pub(crate) fn start(&mut self, master: &BoardMaster, at: Instant) {
        let targets = targets(master);
        telemetry::tell_motion(Message::MotionStarts, targets);
        self.start = Some(Start {
            at,
            targets,
            is_last: false,
            head: Playhead::START,
        });
    }

    /// Lets the motion end when it is back where it started.
    pub(crate) fn finish(&mut self) {
        if let Some(start) = &mut self.start {
            start.is_last = true;
        }
    }

    /// Sets the targets of the cycle that begins at `at`, while every axis streams; `now` is the time for the master.
    pub(crate) fn set_targets(
        &mut self,
        master: &mut BoardMaster,
        home: &config::Homing,
        is_streaming: bool,
        at: Instant,
        now: Instant,
    ) {
        let Some(start) = &mut self.start else { return };
        if !is_streaming {
            return self.end(master);
        }
        let is_through = at.us_since(start.at) >= u64::from(DURATION_US);
        let is_over = is_through && start.is_last;
        if is_over {
            start.at = at;
        }
        while at.us_since(start.at) >= u64::from(DURATION_US) {
            start.at = start.at + DURATION_US;
        }
        let distances = MOTION.position_from(&mut start.head, at.us_since(start.at));
        for (axis, (from, distance)) in start.targets.iter().zip(&distances).enumerate() {
            // Beyond 32 bit is beyond every travel, and refused as such.
            let target = from.saturating_add(*distance);
            if !home.allows(axis, target) {
                defmt::error!(
                    "axis {=usize}: the motion leaves its travel, stopping",
                    axis
                );
                master.stop(now, GROUP);
                return self.end(master);
            }
            if let Err(error) = master.set_target(axis, target) {
                words::target_refused(axis, &error);
                master.stop(now, GROUP);
                return self.end(master);
            }
        }
        if is_over {
            self.end(master);
        }
    }

    fn end(&mut self, master: &BoardMaster) {
        self.start = None;
        telemetry::tell_motion(Message::MotionEnds, targets(master));
    }
}

fn targets(master: &BoardMaster) -> [i32; AXES] {
    core::array::from_fn(|axis| {
        let snapshot = master.snapshot(axis);
        snapshot.map_or(0, |snapshot| Drives::target(&snapshot))
    })
}

/// What the thread does beside the log: nothing.
pub(crate) struct Thread;

impl Thread {
    /// A message that the log tells.
    #[inline(always)]
    pub(crate) const fn note(&mut self, _: &Message) {}

    /// One of the looks between two sleeps.
    #[inline(always)]
    pub(crate) const fn poll(&mut self) {}
}

/// The half of the cycle, and that of the thread.
#[inline(always)]
pub(crate) const fn prepare(_: Cause, _: &History, _: &mut Watchdog) -> (Option<Orders>, Thread) {
    (Some(Orders::new()), Thread)
}
