//! The samples of a run as a table: one row a cycle.

use std::io::Write;

use super::recording::{AxisSample, Recording};

/// Columns of each axis, in order; counts are command counts as the master counts them.
const AXIS_COLUMNS: [&str; 7] = [
    "target_counts",
    "sent_counts",
    "drive_counts",
    "error_counts",
    "backlog_counts",
    "status_age_us",
    "position_age_us",
];

/// Writes every sample.
pub(super) fn write(to: impl Write, recording: &Recording) -> std::io::Result<()> {
    let mut table = csv::Writer::from_writer(to);
    let fixed = ["time_s", "bus_load", "late"].map(str::to_owned);
    let of_axes = recording
        .drives
        .iter()
        .flat_map(|drive| AXIS_COLUMNS.map(|column| format!("drive{drive}_{column}")));
    table.write_record(fixed.into_iter().chain(of_axes))?;
    for sample in &recording.samples {
        let fixed = [
            format!("{:.6}", sample.at_us as f64 * 1e-6),
            format!("{:.4}", sample.load),
            u8::from(sample.is_late).to_string(),
        ];
        table.write_record(fixed.into_iter().chain(sample.axes.iter().flat_map(fields)))?;
    }
    table.flush()
}

fn fields(axis: &AxisSample) -> [String; 7] {
    let age = |age: Option<u32>| age.map_or(String::new(), |us| us.to_string());
    [
        axis.target.to_string(),
        axis.sent.to_string(),
        axis.drive.to_string(),
        axis.error().to_string(),
        axis.backlog.to_string(),
        age(axis.status_age_us),
        age(axis.position_age_us),
    ]
}
