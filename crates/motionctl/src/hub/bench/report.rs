//! What the hub motors of a bench have received.

use core::fmt;

use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use drive_sim::{Bench, NodeId as BusNode, ZlacDrive};
use schemars::JsonSchema;
use serde::Serialize;
use zlac8030l::FaultCode;

use crate::bench::Refusals;
use crate::counted::counted;
use crate::table::align_numbers;

/// One drive at the end.
#[derive(Debug, Serialize, JsonSchema)]
struct DriveReport {
    node: u8,
    /// PDOs with targets that were taken.
    rpdos: u64,
    /// PDOs that were sent.
    tpdos: u64,
    sdo_served: u64,
    /// SDO requests that were refused with an abort code.
    sdo_aborted: u64,
    /// Starts, the first one included.
    boots: u64,
    /// Single objects, saves and factory settings.
    eeprom_writes: u64,
    position_counts: i64,
    /// From where the wheel stood at first.
    travel_counts: i64,
    speed_rpm: f64,
    enabled: bool,
    operational: bool,
    fault: Option<String>,
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
}

impl Report {
    pub(super) fn new(bench: &Bench<ZlacDrive>, adapter: BusNode, refusals: Refusals) -> Self {
        let now_ns = bench.now_ns();
        let counters = bench.bus().controller(adapter).counters();
        Self {
            drives: bench
                .devices()
                .map(|drive| DriveReport::new(drive, now_ns))
                .collect(),
            frames_from_host: counters.tx_frames,
            frames_to_host: counters.rx_frames,
            refused_by_adapter: refusals.frames,
            refused_commands: refusals.commands,
            lost_to_host: refusals.lost_to_host,
            seconds: now_ns as f64 * 1e-9,
        }
    }
}

impl DriveReport {
    fn new(drive: &ZlacDrive, now_ns: u64) -> Self {
        let (books, wear) = (drive.books(), drive.eeprom_wear());
        let fault = FaultCode::new(drive.fault_bits());
        Self {
            node: drive.node_id(),
            rpdos: books.rpdos,
            tpdos: books.tpdos,
            sdo_served: books.sdo_served,
            sdo_aborted: books.sdo_aborted,
            boots: books.boots,
            eeprom_writes: wear.single_writes + wear.saves + wear.restores,
            position_counts: drive.position_counts(now_ns),
            travel_counts: drive.travel_counts(now_ns),
            speed_rpm: drive.speed_rpm(now_ns),
            enabled: drive.is_enabled(),
            operational: drive.is_operational(),
            fault: fault.is_fault().then(|| fault.to_string()),
        }
    }

    fn state(&self) -> String {
        match &self.fault {
            Some(fault) => fault.clone(),
            None if self.enabled => "enabled".to_owned(),
            None => "not enabled".to_owned(),
        }
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new();
        table.load_style(UTF8_BORDERS_ONLY).set_header([
            "node",
            "PDOs\ntaken",
            "PDOs\nsent",
            "SDO\nserved",
            "SDO\nrefused",
            "starts",
            "EEPROM\nwrites",
            "position\ncounts",
            "state",
        ]);
        for drive in &self.drives {
            table.add_row([
                drive.node.to_string(),
                drive.rpdos.to_string(),
                drive.tpdos.to_string(),
                drive.sdo_served.to_string(),
                drive.sdo_aborted.to_string(),
                drive.boots.to_string(),
                drive.eeprom_writes.to_string(),
                drive.position_counts.to_string(),
                drive.state(),
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
        )
    }
}
