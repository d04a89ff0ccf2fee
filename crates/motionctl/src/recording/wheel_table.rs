//! What wheels did, in a row of the table.

use super::about::COUNTS_PER_RPM;
use super::sample::{AxisSample, WheelReadings};

/// Columns of each wheel, in order; what has `read` in its name is what the drive reported last.
pub(super) const WHEEL_COLUMNS: [&str; 9] = [
    "target_rpm",
    "sent_rpm",
    "speed_rpm",
    "read_speed_rpm",
    "position_counts",
    "read_position_counts",
    "read_torque",
    "feedback_age_us",
    "state",
];

/// What is in them.
pub(super) fn wheel_cells(axis: &AxisSample, readings: &WheelReadings) -> [String; 9] {
    let rpm = |counts: i32| (f64::from(counts) / COUNTS_PER_RPM).to_string();
    [
        rpm(axis.target),
        rpm(axis.sent),
        text(axis.position.map(|speed| speed as f64 / COUNTS_PER_RPM)),
        text(readings.speed_decirpm.map(|speed| f64::from(speed) / 10.0)),
        text(readings.travel_counts),
        text(readings.position_counts),
        text(readings.torque),
        text(axis.status_age_us),
        text(axis.state),
    ]
}

fn text<T: ToString>(value: Option<T>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}
