//! The cycles of a run as a table: one row a cycle.

use std::io::{self, Write};

use super::about::{About, Quantity};
use super::item::Item;
use super::keep::Keep;
use super::sample::{AxisSample, Sample};
use super::wheel_table::{WHEEL_COLUMNS, wheel_cells};

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
    quantity: Quantity,
}

impl<W: Write> Table<W> {
    /// A table with its header.
    pub(super) fn new(to: W, about: &About) -> io::Result<Self> {
        let mut rows = csv::Writer::from_writer(to);
        let fixed = ["time_s", "bus_load", "late"].map(str::to_owned);
        let (drive, columns) = match about.quantity {
            Quantity::Position => ("drive", &AXIS_COLUMNS[..]),
            Quantity::Speed => ("node", &WHEEL_COLUMNS[..]),
        };
        let of_axis = |id: u8| {
            columns
                .iter()
                .map(move |column| format!("{drive}{id}_{column}"))
        };
        let of_axes = about.axes.iter().flat_map(|axis| of_axis(axis.drive));
        rows.write_record(fixed.into_iter().chain(of_axes))?;
        let quantity = about.quantity;
        Ok(Self { rows, quantity })
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
        let row = fixed.into_iter().chain(cells(self.quantity, sample));
        Ok(self.rows.write_record(row)?)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.rows.flush()
    }

    fn finish(&mut self) -> io::Result<()> {
        self.rows.flush()
    }
}

fn cells(quantity: Quantity, sample: &Sample) -> Vec<String> {
    let axes = sample.axes.iter();
    match quantity {
        Quantity::Position => axes.flat_map(axis_cells).collect(),
        Quantity::Speed => {
            let wheels = axes.zip(&sample.wheels);
            wheels
                .flat_map(|(axis, readings)| wheel_cells(axis, readings))
                .collect()
        }
    }
}

fn axis_cells(axis: &AxisSample) -> [String; 8] {
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
