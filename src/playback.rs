//! Plays the built-in motion.

use can_motion::{AxisState, Instant, Master};

use crate::config::{AXES, GROUP, MOTION};

/// Where and when the motion began.
#[derive(Clone, Copy)]
struct Start {
    at: Instant,
    counts: [i32; AXES],
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

    /// Sets the targets of the cycle that begins at `at`; `now` is the time for the master.
    ///
    /// The motion starts when every axis streams, where they stand then, and ends when one of them does not any more.
    pub(crate) fn set_targets(&mut self, master: &mut Master<AXES>, at: Instant, now: Instant) {
        if !master.all_are(GROUP, AxisState::Streaming) {
            if self.start.take().is_some() {
                defmt::warn!("the motion has ended: an axis does not stream any more");
            }
            return;
        }
        let start = *self.start.get_or_insert_with(|| begin(master, at));
        let elapsed_us = at.us_since(start.at).checked_rem(MOTION.duration_us());
        let distances = MOTION.position(elapsed_us.unwrap_or(0));
        for (axis, (from, distance)) in start.counts.into_iter().zip(distances).enumerate() {
            // Beyond 32 bit is beyond every travel, and refused as such.
            if let Err(error) = master.set_target(axis, from.saturating_add(distance)) {
                defmt::error!("axis {=usize}: target refused, stopping: {}", axis, error);
                master.stop(now, GROUP);
                return;
            }
        }
    }
}

fn begin(master: &Master<AXES>, at: Instant) -> Start {
    let mut counts = [0; AXES];
    for (axis, counts) in counts.iter_mut().enumerate() {
        if let Some(snapshot) = master.snapshot(axis) {
            *counts = snapshot.target_counts;
        }
    }
    defmt::info!("the motion starts from {} counts", counts);
    Start { at, counts }
}
