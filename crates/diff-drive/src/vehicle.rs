//! From twists to the targets of two wheels, cycle by cycle.

use crate::command::{Command, Phase};
use crate::geometry::{Geometry, WheelSpeeds};
use crate::limits::Limits;
use crate::twist::Twist;

/// Longest time that one step accounts for: after a longer pause the wheels go on as if so much had passed.
const MOST_STEP_US: u64 = 100_000;
const US_PER_S: f64 = 1e6;

/// A vehicle between the last twist and the next cycle.
#[derive(Debug, Clone, Copy)]
pub struct DiffDrive {
    geometry: Geometry,
    limits: Limits,
    /// Numbers of the drives for 1 r/min.
    per_rpm: f64,
    /// The largest number within the limit of speed.
    most: i32,
    twist: Twist,
    twist_at_us: Option<u64>,
    stepped_at_us: Option<u64>,
    /// What the wheels were told last, before rounding.
    speeds: WheelSpeeds,
    /// What rounding has left over, in numbers of the drives.
    rest: (f64, f64),
}

impl DiffDrive {
    /// A vehicle that stands. Its drives count 1/n r/min; n below 1 is taken for 1. The largest speed is a whole number of these: 100.5 r/min
    /// are 100 r/min where they count 1 r/min.
    #[must_use]
    pub const fn new(geometry: Geometry, limits: Limits, speed_resolution: u16) -> Self {
        let n = if speed_resolution == 0 {
            1
        } else {
            speed_resolution
        };
        let per_rpm = n as f64;
        // What 1/n lacks in binary is no reason for a number less.
        let most = (limits.most_rpm * per_rpm + 1e-6) as i32;
        let limits = Limits {
            most_rpm: most as f64 / per_rpm,
            ..limits
        };
        Self {
            geometry,
            limits,
            per_rpm,
            most,
            twist: Twist::ZERO,
            twist_at_us: None,
            stepped_at_us: None,
            speeds: WheelSpeeds {
                left_rpm: 0.0,
                right_rpm: 0.0,
            },
            rest: (0.0, 0.0),
        }
    }

    /// Its measures.
    #[must_use]
    pub const fn geometry(&self) -> &Geometry {
        &self.geometry
    }

    /// The twist from now on.
    pub const fn set_twist(&mut self, now_us: u64, twist: Twist) {
        self.twist = twist;
        self.twist_at_us = Some(now_us);
    }

    /// The wheels do not do what they were told any more, as after a stop by somebody else: the next step begins at standstill, and waits
    /// for a twist.
    pub const fn stand(&mut self) {
        self.twist_at_us = None;
        self.speeds = self.speeds.scaled(0.0);
        self.rest = (0.0, 0.0);
    }

    /// The targets of the cycle that begins now. Call it once a cycle; the time since the call before is the length of the cycle.
    pub const fn step(&mut self, now_us: u64) -> Command {
        let step_us = match self.stepped_at_us {
            Some(at_us) => now_us.saturating_sub(at_us),
            None => 0,
        };
        self.stepped_at_us = Some(now_us);
        let step_us = if step_us > MOST_STEP_US {
            MOST_STEP_US
        } else {
            step_us
        };
        let phase = self.phase(now_us);
        let (asked, rpm_per_s) = match phase {
            Phase::Following => (
                self.geometry.wheel_speeds(self.twist),
                self.limits.rpm_per_s,
            ),
            Phase::Waiting | Phase::TimedOut => (
                WheelSpeeds {
                    left_rpm: 0.0,
                    right_rpm: 0.0,
                },
                self.limits.stop_rpm_per_s,
            ),
        };
        let wanted = asked.within(self.limits.most_rpm);
        let most_change = rpm_per_s * step_us as f64 / US_PER_S;
        self.speeds = toward(self.speeds, wanted, most_change);
        let stands = self.speeds.fastest_rpm() == 0.0;
        let left = self.speeds.left_rpm * self.per_rpm;
        let (left, left_rest) = rounded(left, self.rest.0, stands, self.most);
        let right = self.speeds.right_rpm * self.per_rpm;
        let (right, right_rest) = rounded(right, self.rest.1, stands, self.most);
        self.rest = (left_rest, right_rest);
        Command {
            left,
            right,
            phase,
            is_limited: asked.fastest_rpm() > self.limits.most_rpm,
        }
    }

    const fn phase(&self, now_us: u64) -> Phase {
        match self.twist_at_us {
            None => Phase::Waiting,
            Some(at_us) if now_us.saturating_sub(at_us) > self.limits.timeout_us => Phase::TimedOut,
            Some(_) => Phase::Following,
        }
    }
}

/// Both speeds on the straight line to the wanted ones, the one that changes most by its limit at most.
const fn toward(from: WheelSpeeds, to: WheelSpeeds, most_change: f64) -> WheelSpeeds {
    let left = to.left_rpm - from.left_rpm;
    let right = to.right_rpm - from.right_rpm;
    let change = left.abs().max(right.abs());
    if change <= most_change {
        return to;
    }
    let share = most_change / change;
    WheelSpeeds {
        left_rpm: from.left_rpm + left * share,
        right_rpm: from.right_rpm + right * share,
    }
}

/// The whole number for a speed, and what it leaves over for the next cycle. At standstill nothing creeps on, nor does a wheel that shall
/// stand while the other one turns: what is left over is forgotten, which is less than one number for one cycle. So it is beyond `most`.
const fn rounded(wanted: f64, rest: f64, stands: bool, most: i32) -> (i32, f64) {
    if stands || wanted == 0.0 {
        return (0, 0.0);
    }
    let sum = wanted + rest;
    let whole = nearest(sum);
    if whole > most || whole < -most {
        return (if whole < 0 { -most } else { most }, 0.0);
    }
    (whole, sum - whole as f64)
}

/// To the nearest whole number; what does not fit is the largest that does.
const fn nearest(value: f64) -> i32 {
    let half = if value < 0.0 { -0.5 } else { 0.5 };
    // Rounds towards 0, and saturates.
    (value + half) as i32
}

#[cfg(test)]
mod tests;
