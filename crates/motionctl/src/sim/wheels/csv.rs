//! What wheels did, as a table: one row a cycle.

use std::fs::File;
use std::io::{self, BufWriter};

use can_motion::Instant;
use can_motion::wheel::WheelSnapshot;
use zlac8030l::NodeId;

/// Columns of each wheel, in order; speeds of the wheel itself are those of its shaft.
const WHEEL_COLUMNS: [&str; 8] = [
    "target_rpm",
    "sent_rpm",
    "speed_rpm",
    "read_speed_rpm",
    "position_counts",
    "read_position_counts",
    "read_torque",
    "feedback_age_us",
];

/// A table that grows with each cycle.
pub(super) struct Table {
    table: csv::Writer<BufWriter<File>>,
    per_rpm: f64,
}

/// One wheel in one cycle.
pub(super) struct WheelRow {
    pub(super) snapshot: WheelSnapshot,
    /// What the shaft does, which the simulation alone knows.
    pub(super) shaft_rpm: f64,
    pub(super) travel_counts: i64,
}

impl Table {
    /// The line of names.
    ///
    /// # Errors
    /// As the file.
    pub(super) fn begin(
        file: BufWriter<File>,
        nodes: &[NodeId],
        speed_resolution: u16,
    ) -> io::Result<Self> {
        let mut table = csv::Writer::from_writer(file);
        let fixed = ["time_s", "bus_load", "late"].map(str::to_owned);
        let of_wheels = nodes
            .iter()
            .flat_map(|node| WHEEL_COLUMNS.map(|column| format!("node{node}_{column}")));
        table.write_record(fixed.into_iter().chain(of_wheels))?;
        Ok(Self {
            table,
            per_rpm: f64::from(speed_resolution),
        })
    }

    /// One cycle.
    ///
    /// # Errors
    /// As the file.
    pub(super) fn row(
        &mut self,
        now: Instant,
        load: f64,
        is_late: bool,
        wheels: &[WheelRow],
    ) -> io::Result<()> {
        let fixed = [
            format!("{:.6}", now.as_us() as f64 * 1e-6),
            format!("{load:.4}"),
            u8::from(is_late).to_string(),
        ];
        let cells = wheels.iter().flat_map(|wheel| self.cells(now, wheel));
        let record: Vec<String> = fixed.into_iter().chain(cells).collect();
        self.table.write_record(record)?;
        Ok(())
    }

    fn cells(&self, now: Instant, wheel: &WheelRow) -> [String; 8] {
        let (snapshot, feedback) = (&wheel.snapshot, &wheel.snapshot.feedback);
        let speed = feedback
            .speed_decirpm
            .map(|read| f64::from(read.value) / 10.0);
        [
            (f64::from(snapshot.target) / self.per_rpm).to_string(),
            (f64::from(snapshot.sent) / self.per_rpm).to_string(),
            format!("{:.3}", wheel.shaft_rpm),
            text(speed),
            wheel.travel_counts.to_string(),
            text(feedback.position_counts.map(|read| read.value)),
            text(feedback.torque.map(|read| read.value)),
            text(feedback.status.map(|read| now.us_since(read.at))),
        ]
    }

    /// Everything is in the file.
    ///
    /// # Errors
    /// As the file.
    pub(super) fn end(&mut self) -> io::Result<()> {
        self.table.flush()
    }
}

fn text<T: ToString>(value: Option<T>) -> String {
    value.map_or(String::new(), |value| value.to_string())
}
