//! What was written.

use core::fmt;
use std::path::Path;

use schemars::JsonSchema;
use serde::Serialize;

use super::fit::Fitted;
use crate::counted::counted;

/// Keyframes in figures.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Report {
    file: String,
    keyframes: usize,
    duration_ms: u32,
    cycle_us: u32,
    flash_bytes: usize,
    /// Largest difference between the set-points of the board and those of `motionctl run`.
    worst_difference_counts: u64,
    largest_steps_counts: Vec<u64>,
}

impl Report {
    pub(super) fn new(file: &Path, fitted: &Fitted, cycle_us: u32) -> Self {
        Self {
            file: file.display().to_string(),
            keyframes: fitted.frames.len(),
            duration_ms: fitted.duration_ms(),
            cycle_us,
            flash_bytes: fitted.bytes(),
            worst_difference_counts: fitted.worst_counts,
            largest_steps_counts: fitted.steps.clone(),
        }
    }

    /// How near to the path the board is.
    pub(super) fn nearness(&self) -> String {
        format!(
            "in cycles of {} us the set-points differ from those of `motionctl run` by at most {}",
            self.cycle_us,
            counted(self.worst_difference_counts, "count", "counts")
        )
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}: {}, {} bytes of flash; {}",
            self.file,
            counted(self.keyframes, "keyframe", "keyframes"),
            self.flash_bytes,
            self.nearness()
        )
    }
}
