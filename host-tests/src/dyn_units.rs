//! `dyn_units.json`: the manual's unit formulas.

use std::path::Path;

use dyn_can::units::{self, SCurve};
use dyn_can::{GearNumber, MaxAcceleration, MaxSpeed, OnPosRange, RangeError};
use serde::Deserialize;

use crate::report::{Mismatch, Report, same};
use crate::vector_file::check_file;

/// The file name.
pub const FILE: &str = "dyn_units.json";

/// Largest relative error; a few roundings of `f64`, whose unit roundoff is 1.1e-16.
pub const RELATIVE_TOLERANCE: f64 = 1e-12;

/// Largest error where the vector says exactly zero, in the unit of the quantity.
pub const ZERO_TOLERANCE: f64 = 1e-12;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct SCurveResult {
    max_speed_rpm: f64,
    acceleration_rpm_s: f64,
    total_rev: f64,
    acceleration_time_s: f64,
    acceleration_distance_rev: f64,
    constant_speed_time_s: f64,
    total_time_s: f64,
}

#[derive(Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
enum Vector {
    SCurve {
        command_counts: i32,
        max_speed: i32,
        max_acceleration: i32,
        gear_number: i32,
        result: SCurveResult,
    },
    Gear {
        gear_number: i32,
        gear_ratio: f64,
        command_counts_per_rev: u32,
    },
    SoftStart {
        max_acceleration: i32,
        rise_10_90_s: f64,
        total_s: f64,
    },
    MaxSpeed {
        max_speed: i32,
        gear_number: i32,
        rpm: f64,
    },
    MaxAcceleration {
        max_acceleration: i32,
        gear_number: i32,
        rpm_s: f64,
    },
    OnRange {
        on_pos_range: i32,
        degrees: f64,
    },
}

/// Each formula gives the number of its vector within [`RELATIVE_TOLERANCE`].
pub fn check(dir: &Path) -> Report {
    check_file(dir, FILE, check_vector)
}

fn check_vector(vector: Vector) -> Result<(), Mismatch> {
    match vector {
        Vector::SCurve {
            command_counts,
            max_speed,
            max_acceleration,
            gear_number,
            result,
        } => {
            let max_speed = typed(MaxSpeed::new(max_speed))?;
            let max_acceleration = typed(MaxAcceleration::new(max_acceleration))?;
            let gear = typed(GearNumber::new(gear_number))?;
            check_s_curve(
                &result,
                &SCurve::new(command_counts, max_speed, max_acceleration, gear),
            )
        }
        Vector::Gear {
            gear_number,
            gear_ratio,
            command_counts_per_rev,
        } => {
            let gear = typed(GearNumber::new(gear_number))?;
            close("gear_ratio", gear_ratio, units::gear_ratio(gear))?;
            same(
                "command_counts_per_rev",
                &command_counts_per_rev,
                &units::command_counts_per_turn(gear),
            )
        }
        Vector::SoftStart {
            max_acceleration,
            rise_10_90_s,
            total_s,
        } => {
            let max_acceleration = typed(MaxAcceleration::new(max_acceleration))?;
            close(
                "rise_10_90_s",
                rise_10_90_s,
                units::soft_start_10_90_s(max_acceleration),
            )?;
            close("total_s", total_s, units::soft_start_s(max_acceleration))
        }
        Vector::MaxSpeed {
            max_speed,
            gear_number,
            rpm,
        } => {
            let gear = typed(GearNumber::new(gear_number))?;
            close(
                "rpm",
                rpm,
                units::max_speed_rpm(typed(MaxSpeed::new(max_speed))?, gear),
            )
        }
        Vector::MaxAcceleration {
            max_acceleration,
            gear_number,
            rpm_s,
        } => {
            let gear = typed(GearNumber::new(gear_number))?;
            let max_acceleration = typed(MaxAcceleration::new(max_acceleration))?;
            close(
                "rpm_s",
                rpm_s,
                units::max_acceleration_rpm_s(max_acceleration, gear),
            )
        }
        Vector::OnRange {
            on_pos_range,
            degrees,
        } => {
            let range = typed(OnPosRange::new(on_pos_range))?;
            close("degrees", degrees, units::on_position_degrees(range))
        }
    }
}

fn check_s_curve(expected: &SCurveResult, actual: &SCurve) -> Result<(), Mismatch> {
    close(
        "max_speed_rpm",
        expected.max_speed_rpm,
        actual.peak_speed_rpm,
    )?;
    close(
        "acceleration_rpm_s",
        expected.acceleration_rpm_s,
        actual.acceleration_rpm_s,
    )?;
    close("total_rev", expected.total_rev, actual.distance_turns)?;
    close(
        "acceleration_time_s",
        expected.acceleration_time_s,
        actual.acceleration_time_s,
    )?;
    close(
        "acceleration_distance_rev",
        expected.acceleration_distance_rev,
        actual.acceleration_turns,
    )?;
    close(
        "constant_speed_time_s",
        expected.constant_speed_time_s,
        actual.constant_speed_time_s,
    )?;
    close("total_time_s", expected.total_time_s, actual.total_time_s)
}

fn typed<T>(value: Result<T, RangeError>) -> Result<T, Mismatch> {
    value.map_err(Mismatch::unreadable)
}

fn close(what: &str, expected: f64, actual: f64) -> Result<(), Mismatch> {
    let tolerance = if expected == 0.0 {
        ZERO_TOLERANCE
    } else {
        RELATIVE_TOLERANCE * expected.abs()
    };
    // A NaN is not within any tolerance.
    if (actual - expected).abs() <= tolerance {
        return Ok(());
    }
    Err(Mismatch {
        expected: format!("{what} {expected:?} within {tolerance:e}"),
        actual: format!("{what} {actual:?}"),
    })
}
