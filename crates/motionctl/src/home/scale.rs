//! Turns and r/min as counts and cycles.

use homing::Refusal;

use super::error::HomeError;

/// The jerk brings the acceleration to its limit in so long.
const JERK_TIME_S: f64 = 0.05;

/// Counts of a turn, and the cycle.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    /// Counts of a turn.
    pub(crate) turn: f64,
    pub(crate) cycle_us: u32,
}

impl Scale {
    fn cycle_s(&self) -> f64 {
        f64::from(self.cycle_us) * 1e-6
    }

    pub(crate) fn counts(&self, turns: f64) -> i32 {
        (turns * self.turn).round() as i32
    }

    pub(crate) fn counts_of_degrees(&self, degrees: f64) -> u32 {
        (degrees / 360.0 * self.turn).round() as u32
    }

    pub(crate) fn limits(&self, rpm: f64, rpm_per_s: f64) -> Result<trajectory::Limits, HomeError> {
        let velocity = rpm / 60.0 * self.turn * self.cycle_s();
        let acceleration = rpm_per_s / 60.0 * self.turn * self.cycle_s() * self.cycle_s();
        let jerk = acceleration * self.cycle_s() / JERK_TIME_S;
        trajectory::Limits::new(velocity as f32, acceleration as f32, jerk as f32)
            .map_err(|error| HomeError::Limits(error.to_string()))
    }

    /// A refusal in the words of the options.
    pub(crate) fn words(&self, refusal: Refusal) -> HomeError {
        let rpm = |counts: f32| f64::from(counts) / self.turn / self.cycle_s() * 60.0;
        match refusal {
            Refusal::TooFast { most, actual } => HomeError::TooFast {
                most_rpm: (rpm(most) * 10.0).floor() / 10.0,
                actual_rpm: (rpm(actual) * 10.0).round() / 10.0,
            },
            Refusal::SlowIsFaster { most, actual } => HomeError::Order {
                what: "--slow-rpm",
                than: "--rpm",
                actual: (rpm(actual) * 10.0).round() / 10.0,
                most: (rpm(most) * 10.0).round() / 10.0,
            },
            other => HomeError::Refusal(other),
        }
    }
}
