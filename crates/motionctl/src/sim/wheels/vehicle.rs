//! The result of a vehicle: where its odometry says that it is, and where its wheels took it.

use core::fmt;

use diff_drive::Odometry;
use schemars::JsonSchema;
use serde::Serialize;

use super::summary::Summary;
use crate::recording::Outcome;

/// Counts by which the odometry may differ from a wheel at rest: one of rounding either way.
const MOST_COUNTS: i64 = 2;

/// A pose, and the counts behind it.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(super) struct PoseSummary {
    x_m: f64,
    y_m: f64,
    heading_rad: f64,
    /// How far it is from the start.
    from_start_m: f64,
    left_counts: i64,
    right_counts: i64,
}

impl PoseSummary {
    pub(super) fn of(odometry: &Odometry) -> Self {
        let pose = odometry.pose();
        let (left_counts, right_counts) = odometry.travel_counts();
        Self {
            x_m: pose.x_m,
            y_m: pose.y_m,
            heading_rad: pose.heading_rad,
            from_start_m: pose.distance_m(),
            left_counts,
            right_counts,
        }
    }
}

impl fmt::Display for PoseSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "x {:.4} m, y {:.4} m, heading {:.2} degrees, {:.1} mm from the start; {} and {} counts",
            self.x_m,
            self.y_m,
            self.heading_rad.to_degrees(),
            self.from_start_m * 1e3,
            self.left_counts,
            self.right_counts
        )
    }
}

/// A whole simulation of a vehicle.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct VehicleSummary {
    /// The wheels kept their promises, and the odometry agrees with them.
    pub(super) promises_kept: bool,
    /// From the feedback of the drives.
    odometry: PoseSummary,
    /// From the shafts of the simulated wheels.
    wheels_pose: PoseSummary,
    /// Largest difference of the counts of a wheel.
    largest_difference_counts: i64,
    /// Cycles in which no twist was in force any more.
    dead_man_cycles: u32,
    /// Cycles in which the vehicle was slower than its twist.
    limited_cycles: u32,
    /// Positions that no wheel can have reached since the cycle before.
    jumps: u32,
    #[serde(flatten)]
    run: RunSummary,
}

/// The wheels, under a name of their own in JSON.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct RunSummary {
    run: Summary,
}

impl VehicleSummary {
    /// `cycles` are those without a twist, those that were limited, and jumps.
    pub(super) fn new(
        odometry: PoseSummary,
        wheels_pose: PoseSummary,
        [dead_man_cycles, limited_cycles, jumps]: [u32; 3],
        run: Summary,
    ) -> Self {
        let left = (odometry.left_counts - wheels_pose.left_counts).abs();
        let right = (odometry.right_counts - wheels_pose.right_counts).abs();
        let largest_difference_counts = left.max(right);
        Self {
            promises_kept: run.promises_kept
                && largest_difference_counts <= MOST_COUNTS
                && jumps == 0,
            odometry,
            wheels_pose,
            largest_difference_counts,
            dead_man_cycles,
            limited_cycles,
            jumps,
            run: RunSummary { run },
        }
    }
}

impl VehicleSummary {
    /// The result in one sentence.
    pub(super) fn verdict(&self) -> &'static str {
        if self.run.run.promises_kept && !self.promises_kept {
            "A promise was BROKEN: the odometry is not where the wheels are."
        } else {
            self.run.run.verdict()
        }
    }

    /// The result as its page has it.
    pub(super) fn for_page(&self) -> Outcome {
        let mut outcome = self.run.run.for_page();
        outcome.facts.extend([
            format!("Odometry: {}.", self.odometry),
            format!("Wheels: {}.", self.wheels_pose),
        ]);
        Outcome {
            verdict: self.verdict().to_owned(),
            is_good: self.promises_kept,
            ..outcome
        }
    }
}

impl fmt::Display for VehicleSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.run.run)?;
        writeln!(f, "odometry: {}", self.odometry)?;
        writeln!(f, "wheels:   {}", self.wheels_pose)?;
        if self.dead_man_cycles > 0 {
            writeln!(
                f,
                "no twist was in force in {} cycles: the wheels ramped to 0 or stood",
                self.dead_man_cycles
            )?;
        }
        if self.limited_cycles > 0 {
            writeln!(
                f,
                "slower than the twist, on the same curve, in {} cycles",
                self.limited_cycles
            )?;
        }
        write!(
            f,
            "the odometry differs from the wheels by {} counts at most",
            self.largest_difference_counts
        )
    }
}
