//! What the drives of a bench have received.

use core::fmt;

use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use drive_sim::{Bench, DynDrive, NodeId};
use serde::Serialize;

use crate::table::align_numbers;

/// One drive at the end.
#[derive(Debug, Serialize)]
struct DriveReport {
    drive: u8,
    /// Sum of the steps that were accepted.
    received_counts: i64,
    set_points: u64,
    /// Set-points that came while the servo was off or in alarm.
    ignored_set_points: u64,
    /// Requests over the serial port that the drive has taken.
    serial_requests: u64,
    position_counts: i64,
    enabled: bool,
    alarm: Option<String>,
}

/// A whole bench at the end.
#[derive(Debug, Serialize)]
pub(super) struct Report {
    drives: Vec<DriveReport>,
    /// Frames that the adapter has sent and received.
    frames_from_host: u64,
    frames_to_host: u64,
    seconds: f64,
}

impl Report {
    pub(super) fn new(bench: &Bench<DynDrive>, adapter: NodeId) -> Self {
        let now_ns = bench.now_ns();
        let counters = bench.bus().controller(adapter).counters();
        let drive = |drive: &DynDrive| DriveReport {
            drive: drive.id().map_or(0, |id| id.get()),
            received_counts: drive.commanded_counts(),
            set_points: drive.books().pd_frames,
            ignored_set_points: drive.books().pd_frames_ignored,
            serial_requests: drive.books().serial_requests,
            position_counts: drive.position_counts(now_ns),
            enabled: drive.is_enabled(),
            alarm: drive.alarm().is_alarm().then(|| drive.alarm().to_string()),
        };
        Self {
            drives: bench.devices().map(drive).collect(),
            frames_from_host: counters.tx_frames,
            frames_to_host: counters.rx_frames,
            seconds: now_ns as f64 * 1e-9,
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new();
        table.load_style(UTF8_BORDERS_ONLY).set_header([
            "drive",
            "set-\npoints",
            "ignored",
            "received\ncounts",
            "serial\nrequests",
            "position\ncounts",
            "state",
        ]);
        for drive in &self.drives {
            let state = if drive.enabled { "enabled" } else { "disabled" };
            table.add_row([
                drive.drive.to_string(),
                drive.set_points.to_string(),
                drive.ignored_set_points.to_string(),
                drive.received_counts.to_string(),
                drive.serial_requests.to_string(),
                drive.position_counts.to_string(),
                drive.alarm.clone().unwrap_or_else(|| state.to_owned()),
            ]);
        }
        align_numbers(&mut table);
        writeln!(f, "{table}")?;
        write!(
            f,
            "{:.1} s; the adapter sent {} frames and received {}",
            self.seconds, self.frames_from_host, self.frames_to_host
        )
    }
}
