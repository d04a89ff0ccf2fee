//! Limits of motion.

use dyn_can::{Counts28, StepLimit};

/// Limits of one axis, in command counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// Largest step of one cycle: the velocity limit.
    pub max_step: StepLimit,
    /// Largest change of the step from one cycle to the next while ramping down, at least 1: the deceleration limit.
    pub ramp_change: u16,
    /// Smallest target, at least -2^27.
    pub travel_min: i32,
    /// Largest target, at most 2^27 - 1.
    pub travel_max: i32,
    /// Backlog beyond which the axis faults: how far the axis may fall behind its target.
    pub backlog: u32,
    /// Distance between sent position and read position beyond which a moving axis faults.
    pub following_error: u32,
    /// The same at standstill: an error that stays is a lost or doubled step.
    pub drift_tolerance: u32,
}

impl Limits {
    /// The whole 28-bit travel, 16384 counts (one turn) a cycle, eight full steps of backlog, the 8192 counts of
    /// following error after which a drive alarms by itself (section 6, #9), and 16 counts (0.35 degrees) of drift.
    pub const WIDEST: Self = Self {
        max_step: StepLimit::MAX,
        ramp_change: 64,
        travel_min: Counts28::MIN.get(),
        travel_max: Counts28::MAX.get(),
        backlog: 8 * 16_384,
        following_error: 8_192,
        drift_tolerance: 16,
    };
}
