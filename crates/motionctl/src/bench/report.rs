//! What the drives of a bench have received.

use core::fmt;

use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use drive_sim::{Bench, DynDrive, NodeId};
use schemars::JsonSchema;
use serde::Serialize;

use super::adapter::Refusals;
use super::board::BoardReport;
use crate::counted::counted;
use crate::table::align_numbers;

/// One drive at the end.
#[derive(Debug, Serialize, JsonSchema)]
struct DriveReport {
    drive: u8,
    /// Sum of the steps that were accepted.
    received_counts: i64,
    set_points: u64,
    /// Set-points that came while the servo was off or in alarm.
    ignored_set_points: u64,
    /// Built-in motions that came while the servo was off, in alarm or in another mode.
    ignored_moves: u64,
    /// Frames to this drive that are no request: a wrong length, an unknown value, a number out of range.
    refused_frames: u64,
    /// How many of them it answered with a data error.
    data_errors: u64,
    /// Requests over the serial port that the drive has taken.
    serial_requests: u64,
    /// Requests that wrote the EEPROM.
    eeprom_writes: u64,
    position_counts: i64,
    enabled: bool,
    alarm: Option<String>,
}

/// A whole bench at the end.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Report {
    drives: Vec<DriveReport>,
    /// Frames that the adapter has sent and received.
    frames_from_host: u64,
    frames_to_host: u64,
    /// Frames of the host that the adapter did not take, other lines that it did not obey, and lines for which the host was too slow.
    refused_by_adapter: u64,
    refused_commands: u64,
    lost_to_host: u64,
    seconds: f64,
    /// The motion board on the bus, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    board: Option<BoardReport>,
}

impl Report {
    pub(super) fn new(
        bench: &Bench<DynDrive>,
        adapter: NodeId,
        refusals: Refusals,
        board: Option<BoardReport>,
    ) -> Self {
        let now_ns = bench.now_ns();
        let counters = bench.bus().controller(adapter).counters();
        let drive = |drive: &DynDrive| DriveReport {
            drive: drive.id().map_or(0, |id| id.get()),
            received_counts: drive.commanded_counts(),
            set_points: drive.books().pd_frames,
            ignored_set_points: drive.books().pd_frames_ignored,
            ignored_moves: drive.books().moves_ignored,
            refused_frames: drive.books().undecodable_frames,
            data_errors: drive.books().data_errors,
            serial_requests: drive.books().serial_requests,
            eeprom_writes: drive.eeprom_writes().total(),
            position_counts: drive.position_counts(now_ns),
            enabled: drive.is_enabled(),
            alarm: drive.alarm().is_alarm().then(|| drive.alarm().to_string()),
        };
        Self {
            drives: bench.devices().map(drive).collect(),
            frames_from_host: counters.tx_frames,
            frames_to_host: counters.rx_frames,
            refused_by_adapter: refusals.frames,
            refused_commands: refusals.commands,
            lost_to_host: refusals.lost_to_host,
            seconds: now_ns as f64 * 1e-9,
            board,
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
            "refused\nframes",
            "received\ncounts",
            "serial\nrequests",
            "EEPROM\nwrites",
            "position\ncounts",
            "state",
        ]);
        for drive in &self.drives {
            let state = if drive.enabled { "enabled" } else { "disabled" };
            table.add_row([
                drive.drive.to_string(),
                drive.set_points.to_string(),
                (drive.ignored_set_points + drive.ignored_moves).to_string(),
                drive.refused_frames.to_string(),
                drive.received_counts.to_string(),
                drive.serial_requests.to_string(),
                drive.eeprom_writes.to_string(),
                drive.position_counts.to_string(),
                drive.alarm.clone().unwrap_or_else(|| state.to_owned()),
            ]);
        }
        align_numbers(&mut table);
        writeln!(f, "{table}")?;
        write!(
            f,
            "{:.1} s; the adapter sent {} and received {}. Refused by the adapter: {}, {}; lost because the host was too slow: {}",
            self.seconds,
            counted(self.frames_from_host, "frame", "frames"),
            self.frames_to_host,
            counted(self.refused_by_adapter, "frame", "frames"),
            counted(self.refused_commands, "other command", "other commands"),
            counted(self.lost_to_host, "line", "lines"),
        )?;
        self.board.map_or(Ok(()), |board| write!(f, "\n{board}"))
    }
}
