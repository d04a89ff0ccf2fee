//! What has become of a run.

use core::fmt;

use serde::Serialize;

use crate::counted::counted;

/// What every run counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) struct Counts {
    pub(super) interrupted: bool,
    /// Every wheel says that it stands.
    pub(super) stands: bool,
    pub(super) cycles: u64,
    /// Cycles begun more than half a cycle after their time.
    pub(super) late_cycles: u64,
    /// Cycles never begun.
    pub(super) merged_cycles: u64,
}

/// One wheel at the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(super) struct WheelCounts {
    pub(super) node: u8,
    /// How far it turned, by its own count.
    pub(super) counts: Option<i32>,
}

/// Where a vehicle is.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(super) struct VehiclePose {
    pub(super) x_m: f64,
    pub(super) y_m: f64,
    pub(super) heading_rad: f64,
    pub(super) from_start_m: f64,
    pub(super) left_counts: i64,
    pub(super) right_counts: i64,
}

/// A run at its end.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Summary {
    /// The end of the input was reached, and every wheel stands.
    pub(super) complete: bool,
    #[serde(flatten)]
    pub(super) counts: Counts,
    pub(super) wheels: Vec<WheelCounts>,
    pub(super) pose: Option<VehiclePose>,
    /// How often no twist came in time.
    pub(super) dead_man_stops: u32,
    /// Cycles in which the vehicle was slower than its twist.
    pub(super) limited_cycles: u32,
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for wheel in &self.wheels {
            let counts = wheel
                .counts
                .map_or_else(|| "?".to_owned(), |counts| counts.to_string());
            writeln!(f, "node {}: turned {counts} counts", wheel.node)?;
        }
        if let Some(pose) = &self.pose {
            writeln!(
                f,
                "odometry: x {:.4} m, y {:.4} m, heading {:.2} degrees, {:.1} mm from the start",
                pose.x_m,
                pose.y_m,
                pose.heading_rad.to_degrees(),
                pose.from_start_m * 1e3
            )?;
        }
        if self.dead_man_stops > 0 {
            writeln!(
                f,
                "stopped {} because no twist came in time",
                counted(self.dead_man_stops, "time", "times")
            )?;
        }
        if self.limited_cycles > 0 {
            writeln!(
                f,
                "slower than the twist, on the same curve, in {} cycles",
                self.limited_cycles
            )?;
        }
        writeln!(
            f,
            "{} cycles, {} late, {} merged into the next",
            self.counts.cycles, self.counts.late_cycles, self.counts.merged_cycles
        )?;
        f.write_str(match (self.complete, self.counts.interrupted) {
            (false, false) if self.counts.stands => {
                "NOT complete: the input ended with an error; every wheel stands and its power is off."
            }
            (true, _) => "The end was reached; every wheel stands and its power is off.",
            (false, true) => "Stopped by the user; the power of the wheels is off.",
            (false, false) => "NOT complete: a wheel does not say that it stands.",
        })
    }
}
