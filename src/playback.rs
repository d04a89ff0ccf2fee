//! Plays the built-in motion.

use can_motion::{Instant, ServoMaster};

use crate::config::{AXES, GROUP, MOTION};
use crate::telemetry::{self, Message};

/// Where and when the motion began.
#[derive(Clone, Copy)]
struct Start {
    at: Instant,
    counts: [i32; AXES],
    /// The repetition in which it shall end, counted from 0.
    last_repetition: u64,
}

/// The motion under way.
pub(crate) struct Playback {
    start: Option<Start>,
}

impl Playback {
    /// Nothing is played yet.
    pub(crate) const fn new() -> Self {
        Self { start: None }
    }

    /// Starts the motion at `at`, from where the axes stand, and repeats it.
    pub(crate) fn start(&mut self, master: &ServoMaster<AXES>, at: Instant) {
        let counts = targets(master);
        telemetry::tell(Message::MotionStarts(counts));
        self.start = Some(Start {
            at,
            counts,
            last_repetition: u64::MAX,
        });
    }

    /// Lets the motion end when it is back where it started.
    pub(crate) fn finish(&mut self, at: Instant) {
        if let Some(start) = &mut self.start {
            start.last_repetition = at.us_since(start.at) / MOTION.duration_us();
        }
    }

    /// Sets the targets of the cycle that begins at `at`, while every axis streams; `now` is the time for the master.
    pub(crate) fn set_targets(
        &mut self,
        master: &mut ServoMaster<AXES>,
        is_streaming: bool,
        at: Instant,
        now: Instant,
    ) {
        let Some(start) = self.start else { return };
        if !is_streaming {
            return self.end(master);
        }
        let elapsed_us = at.us_since(start.at);
        let repetition = elapsed_us / MOTION.duration_us();
        let is_over = repetition > start.last_repetition;
        let into_us = if is_over {
            0
        } else {
            elapsed_us - repetition * MOTION.duration_us()
        };
        let distances = MOTION.position(into_us);
        for (axis, (from, distance)) in start.counts.into_iter().zip(distances).enumerate() {
            // Beyond 32 bit is beyond every travel, and refused as such.
            if let Err(error) = master.set_target(axis, from.saturating_add(distance)) {
                defmt::error!("axis {=usize}: target refused, stopping: {}", axis, error);
                master.stop(now, GROUP);
                return self.end(master);
            }
        }
        if is_over {
            self.end(master);
        }
    }

    fn end(&mut self, master: &ServoMaster<AXES>) {
        self.start = None;
        telemetry::tell(Message::MotionEnds(targets(master)));
    }
}

fn targets(master: &ServoMaster<AXES>) -> [i32; AXES] {
    core::array::from_fn(|axis| {
        let snapshot = master.snapshot(axis);
        snapshot.map_or(0, |snapshot| snapshot.target_counts)
    })
}
