//! The cycles of a run as a table: one row a cycle.

use std::io::{self, Write};

use super::about::About;
use super::item::Item;
use super::keep::Keep;
use super::sample::AxisSample;

/// Columns of each axis, in order; counts are command counts as the master counts them.
const AXIS_COLUMNS: [&str; 8] = [
    "target_counts",
    "sent_counts",
    "drive_counts",
    "error_counts",
    "backlog_counts",
    "status_age_us",
    "position_age_us",
    "state",
];

/// A table in the making.
pub(super) struct Table<W: Write> {
    rows: csv::Writer<W>,
}

impl<W: Write> Table<W> {
    /// A table with its header.
    pub(super) fn new(to: W, about: &About) -> io::Result<Self> {
        let mut rows = csv::Writer::from_writer(to);
        let fixed = ["time_s", "bus_load", "late"].map(str::to_owned);
        let of_axes = about
            .axes
            .iter()
            .flat_map(|axis| AXIS_COLUMNS.map(|column| format!("drive{}_{column}", axis.drive)));
        rows.write_record(fixed.into_iter().chain(of_axes))?;
        Ok(Self { rows })
    }
}

impl<W: Write + Send> Keep for Table<W> {
    fn keep(&mut self, item: &Item) -> io::Result<()> {
        let Item::Cycle(sample) = item else {
            return Ok(());
        };
        let fixed = [
            format!("{:.6}", sample.at_us as f64 * 1e-6),
            format!("{:.4}", sample.load),
            u8::from(sample.is_late).to_string(),
        ];
        let row = fixed.into_iter().chain(sample.axes.iter().flat_map(fields));
        Ok(self.rows.write_record(row)?)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.rows.flush()
    }

    fn finish(&mut self) -> io::Result<()> {
        self.rows.flush()
    }
}

fn fields(axis: &AxisSample) -> [String; 8] {
    let age = |age: Option<u32>| age.map_or(String::new(), |us| us.to_string());
    let counts = |counts: Option<i64>| counts.map_or(String::new(), |counts| counts.to_string());
    [
        axis.target.to_string(),
        axis.sent.to_string(),
        counts(axis.position),
        counts(axis.error()),
        axis.backlog.to_string(),
        age(axis.status_age_us),
        age(axis.position_age_us),
        axis.state.map_or(String::new(), |state| state.to_string()),
    ]
}
