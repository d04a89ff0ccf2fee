//! Measures of the vehicle, and what they make of a twist.

use core::f64::consts::TAU;

use crate::error::{ValueError, checked};
use crate::twist::Twist;

/// Seconds in a minute.
const S_PER_MIN: f64 = 60.0;

/// Speeds of the two wheels in r/min; a wheel that drives the vehicle forwards turns positive.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WheelSpeeds {
    /// Left wheel.
    pub left_rpm: f64,
    /// Right wheel.
    pub right_rpm: f64,
}

impl WheelSpeeds {
    /// The faster of the two, without its sign.
    #[must_use]
    pub const fn fastest_rpm(self) -> f64 {
        self.left_rpm.abs().max(self.right_rpm.abs())
    }

    /// Both by the same factor: the curve stays the same.
    #[must_use]
    pub const fn scaled(self, factor: f64) -> Self {
        Self {
            left_rpm: self.left_rpm * factor,
            right_rpm: self.right_rpm * factor,
        }
    }

    /// Both scaled down together, so that neither is faster than the limit; what is within it stays.
    #[must_use]
    pub const fn within(self, most_rpm: f64) -> Self {
        let fastest = self.fastest_rpm();
        if fastest > most_rpm {
            self.scaled(most_rpm / fastest)
        } else {
            self
        }
    }
}

/// Measures of a vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Geometry {
    track_m: f64,
    wheel_radius_m: f64,
    counts_per_turn: f64,
}

impl Geometry {
    /// A vehicle with its track (from the middle of one wheel to that of the other, 0.01 to 10 m), the radius of its wheels under load
    /// (0.005 to 2 m), and the encoder counts of one turn of a wheel (1 to 10,000,000).
    ///
    /// # Errors
    /// [`ValueError`] for a number out of range, or none.
    pub const fn new(
        track_m: f64,
        wheel_radius_m: f64,
        counts_per_turn: u32,
    ) -> Result<Self, ValueError> {
        let counts = counts_per_turn as f64;
        match (
            checked("track in m", (0.01, 10.0), track_m),
            checked("wheel radius in m", (0.005, 2.0), wheel_radius_m),
            checked("counts of a turn", (1.0, 1e7), counts),
        ) {
            (Ok(track_m), Ok(wheel_radius_m), Ok(counts_per_turn)) => Ok(Self {
                track_m,
                wheel_radius_m,
                counts_per_turn,
            }),
            (Err(error), _, _) | (_, Err(error), _) | (_, _, Err(error)) => Err(error),
        }
    }

    /// Track in metres.
    #[must_use]
    pub const fn track_m(&self) -> f64 {
        self.track_m
    }

    /// Encoder counts of one turn of a wheel.
    #[must_use]
    pub const fn counts_per_turn(&self) -> f64 {
        self.counts_per_turn
    }

    /// Way of a wheel on the ground for one count, in metres.
    #[must_use]
    pub const fn m_per_count(&self) -> f64 {
        TAU * self.wheel_radius_m / self.counts_per_turn
    }

    /// The wheel speeds of a twist, without limits.
    #[must_use]
    pub const fn wheel_speeds(&self, twist: Twist) -> WheelSpeeds {
        let rpm_of = S_PER_MIN / (TAU * self.wheel_radius_m);
        let side = twist.omega_rad_s() * self.track_m / 2.0;
        WheelSpeeds {
            left_rpm: (twist.v_m_s() - side) * rpm_of,
            right_rpm: (twist.v_m_s() + side) * rpm_of,
        }
    }
}
