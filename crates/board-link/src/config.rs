//! Limits of the axes, how much is buffered, and what follows from both.

use serde::{Deserialize, Serialize};
use trajectory::{Limits, Position, Time};

use crate::polynomial::ROUNDING_OF_PLACE;

/// Share of the acceleration that the set-points may need; the rest is for ramps.
const ACCELERATION_OF_MOTION: f32 = 2.0 / 3.0;
const ACCELERATION_OF_RAMPS: f32 = 1.0 - ACCELERATION_OF_MOTION;
/// Share of the jerk that the set-points may need; a ramp of a motion that accelerates needs twice the other share.
const JERK_OF_MOTION: f32 = 0.5;
const JERK_OF_RAMPS: f32 = 0.25;
/// A ramp is used a little less than it may be: between two set-points the curve can be a little faster than at them.
const RAMP_SHARE: f32 = 0.9;
/// Cycles in which the change of a rate reaches its highest value, where no jerk is limited.
const CYCLES_TO_FULL_RAMP: f32 = 25.0;

/// Limits of one axis for what goes out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisLimits {
    /// Largest velocity, acceleration and jerk; [`Limits::without_jerk`] where no jerk is limited. The set-points may need two thirds
    /// of the acceleration and half of the jerk; the rest is what ramps, pauses and changes of the speed need on top.
    pub motion: Limits,
    /// Lowest position of a set-point that goes out. A curve between two of them may lead beyond it by less than half a count, as long as
    /// no whole count beyond it goes out.
    pub lowest: Position,
    /// Highest position, in the same way.
    pub highest: Position,
}

impl AxisLimits {
    /// Whether a place on the way may be passed. Set-points are whole counts: between two of them a curve may lead beyond the travel by
    /// what sends none beyond it. `at` may be off by [`ROUNDING_OF_PLACE`].
    pub(crate) fn admit_on_the_way(&self, at: Position) -> bool {
        let (low, high) = (
            at.distance_from(ROUNDING_OF_PLACE),
            at.moved_by(ROUNDING_OF_PLACE),
        );
        let is_inside = self.lowest <= high && low <= self.highest;
        let sent = |at: Position| at.wide_counts().saturating_mul(Position::UNITS);
        let (lowest, highest) = (self.lowest.units(), self.highest.units());
        is_inside || sent(low) >= lowest && sent(high) <= highest
    }

    /// The same for an axis whose positions count from another place: its travel moves by so many counts.
    #[must_use]
    pub fn moved_by(&self, counts: i64) -> Self {
        let moved = |end: Position| {
            let units = counts.saturating_mul(Position::UNITS);
            Position::from_units(end.units().saturating_add(units))
        };
        Self {
            motion: self.motion,
            lowest: moved(self.lowest),
            highest: moved(self.highest),
        }
    }

    /// Largest velocity of the set-points, in counts per cycle.
    #[must_use]
    pub fn velocity(&self) -> f32 {
        self.motion.velocity()
    }

    /// Largest acceleration of the set-points, in counts per cycle².
    #[must_use]
    pub fn acceleration(&self) -> f32 {
        ACCELERATION_OF_MOTION * self.motion.acceleration()
    }

    /// Largest jerk of the set-points, in counts per cycle³; infinite when there is no limit.
    #[must_use]
    pub fn jerk(&self) -> f32 {
        JERK_OF_MOTION * self.motion.jerk()
    }

    /// Largest change of the rate in a cycle that this axis can bear.
    fn ramp(&self) -> f32 {
        let by_acceleration = ACCELERATION_OF_RAMPS * self.motion.acceleration() / self.velocity();
        let by_jerk = JERK_OF_RAMPS * self.motion.jerk() / (3.0 * self.acceleration());
        RAMP_SHARE * by_acceleration.min(by_jerk)
    }

    /// Largest change of that change in a cycle.
    fn ramp_change(&self) -> f32 {
        RAMP_SHARE * JERK_OF_RAMPS * self.motion.jerk() / self.velocity()
    }
}

/// What happens when the set-points or segments run out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum WhenDry {
    /// The axes come to rest at the last set-point, or on the way to the end of the last segment, and that is the end.
    #[default]
    End,
    /// The axes come to rest there, and go on when the lead is buffered again: [`Config::lead`].
    Wait,
}

/// How a buffer works.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Config {
    /// Motion starts, and starts again, when so much time of complete path is buffered, when the buffer is full or the end is there.
    pub lead: Time,
    /// The sender is to keep so much time buffered; the credit ends there.
    pub ahead: Time,
    /// Longest time from one set-point to the next.
    pub longest_gap: Time,
    /// Accelerations of set-points closer than this are means over so much time: their positions may be whole counts.
    pub window: Time,
    /// What happens when the set-points run out.
    pub when_dry: WhenDry,
}

impl Config {
    /// 0.3 s before it starts, 0.6 s ahead, gaps of 10 s, means over 20 ms, with this many cycles in a second.
    #[must_use]
    pub const fn with_cycles_per_second(cycles: u32) -> Self {
        Self {
            lead: Time::from_units(3 * cycles as u64, 10),
            ahead: Time::from_units(6 * cycles as u64, 10),
            longest_gap: Time::from_units(10 * cycles as u64, 1),
            window: Time::from_units(cycles as u64, 50),
            when_dry: WhenDry::End,
        }
    }
}

/// How fast the rate of a motion may change: the smallest of all axes.
pub(crate) fn ramp(axes: &[AxisLimits]) -> (f32, f32) {
    let least = |of: fn(&AxisLimits) -> f32| axes.iter().map(of).fold(f32::INFINITY, f32::min);
    let ramp = least(AxisLimits::ramp);
    let change = least(AxisLimits::ramp_change);
    (ramp, change.min(ramp / CYCLES_TO_FULL_RAMP))
}
