//! What wheels did, as a table: one row a cycle.

use std::io::{self, Write};

use super::about::{About, COUNTS_PER_RPM};
use super::item::Item;
use super::keep::Keep;
use super::sample::{AxisSample, WheelReadings};

/// Columns of each wheel, in order; what has `read` in its name is what the drive reported last.
const WHEEL_COLUMNS: [&str; 9] = [
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

/// A table in the making.
pub(super) struct WheelTable<W: Write> {
    rows: csv::Writer<W>,
}

impl<W: Write> WheelTable<W> {
    /// A table with its header.
    pub(super) fn new(to: W, about: &About) -> io::Result<Self> {
        let mut rows = csv::Writer::from_writer(to);
        let fixed = ["time_s", "bus_load", "late"].map(str::to_owned);
        let of_wheels = about
            .axes
            .iter()
            .flat_map(|wheel| WHEEL_COLUMNS.map(|column| format!("node{}_{column}", wheel.drive)));
        rows.write_record(fixed.into_iter().chain(of_wheels))?;
        Ok(Self { rows })
    }
}

impl<W: Write + Send> Keep for WheelTable<W> {
    fn keep(&mut self, item: &Item) -> io::Result<()> {
        let Item::Cycle(sample) = item else {
            return Ok(());
        };
        let fixed = [
            format!("{:.6}", sample.at_us as f64 * 1e-6),
            format!("{:.4}", sample.load),
            u8::from(sample.is_late).to_string(),
        ];
        let wheels = sample.axes.iter().zip(&sample.wheels);
        let cells = wheels.flat_map(|(axis, readings)| cells(axis, readings));
        Ok(self.rows.write_record(fixed.into_iter().chain(cells))?)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.rows.flush()
    }

    fn finish(&mut self) -> io::Result<()> {
        self.rows.flush()
    }
}

fn cells(axis: &AxisSample, readings: &WheelReadings) -> [String; 9] {
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
