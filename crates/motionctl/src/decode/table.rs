//! The statistics at the end: for each bus a table of its identifiers and what is true of the whole bus.

use core::fmt;

use can_decode::statistics::{OfIdentifier, Spread, Statistics};
use comfy_table::presets::UTF8_BORDERS_ONLY;
use comfy_table::{CellAlignment, Table};
use schemars::JsonSchema;
use serde::Serialize;

use super::bus::Bus;
use super::meaning::SpreadFields;
use crate::counted::counted;

/// One bus.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Overview<'a> {
    interface: &'a str,
    frames: u64,
    /// From the first frame to the last; nothing in a log without times.
    duration_s: Option<f64>,
    /// Load of the bus without stuff bits, 0 ..= 1: the real one is up to a fifth higher.
    least_load: Option<f64>,
    bit_rate_kbit: u32,
    undecodable_frames: u64,
    /// Frames that look like trouble, those that do not decode included.
    remarkable_frames: u64,
    error_frames: u64,
    fd_frames: u64,
    identifiers: Vec<Identifier<'a>>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct Identifier<'a> {
    id: u32,
    extended: bool,
    function: &'a str,
    frames: u64,
    data_bytes: u64,
    undecodable_frames: u64,
    #[schemars(with = "Option<SpreadFields>")]
    interval: Option<Spread>,
    #[schemars(with = "Option<SpreadFields>")]
    response: Option<Spread>,
}

impl<'a> Overview<'a> {
    pub(super) fn new(bus: &'a Bus, bit_rate_kbit: u32) -> Self {
        let statistics = &bus.statistics;
        let identifier = |(id, extended, entry): (u32, bool, &'a OfIdentifier)| Identifier {
            id,
            extended,
            function: entry.name(),
            frames: entry.frames(),
            data_bytes: entry.bytes(),
            undecodable_frames: entry.undecodable(),
            interval: entry.intervals(),
            response: entry.responses(),
        };
        Self {
            interface: &bus.interface,
            frames: statistics.frames(),
            duration_s: statistics.duration_ns().map(|ns| ns as f64 * 1e-9),
            least_load: statistics.least_load(bit_rate_kbit),
            bit_rate_kbit,
            undecodable_frames: bus.undecodable,
            remarkable_frames: bus.remarkable,
            error_frames: bus.error_frames,
            fd_frames: bus.fd_frames,
            identifiers: statistics.identifiers().map(identifier).collect(),
        }
    }
}

impl fmt::Display for Overview<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.interface.is_empty() {
            write!(f, "{}: ", self.interface)?;
        }
        write!(
            f,
            "{}{}; {} did not decode, {}, {}, {}",
            counted(self.frames, "frame", "frames"),
            self.duration_s
                .map_or(String::new(), |duration_s| format!(" in {duration_s:.3} s")),
            self.undecodable_frames,
            counted(
                self.remarkable_frames,
                "looks like trouble",
                "look like trouble"
            ),
            counted(self.error_frames, "error frame", "error frames"),
            counted(self.fd_frames, "CAN FD frame", "CAN FD frames")
        )?;
        match self.least_load {
            Some(load) => write!(
                f,
                "\nBus load at least {:.1} % at {} kbit/s, without stuff bits",
                100.0 * load,
                self.bit_rate_kbit
            ),
            None => Ok(()),
        }
    }
}

/// One line for each identifier.
pub(super) fn table(statistics: &Statistics) -> Table {
    let mut table = Table::new();
    table.load_style(UTF8_BORDERS_ONLY).set_header([
        "id",
        "drive",
        "function",
        "frames",
        "not\ndecoded",
        "interval ms\nleast / mean / most",
        "response ms\nleast / mean / most",
    ]);
    for (id, extended, entry) in statistics.identifiers() {
        let id = if extended {
            format!("{id:08X}")
        } else {
            format!("{id:03X}")
        };
        let drive = entry
            .drive()
            .map_or(String::new(), |drive| drive.to_string());
        table.add_row([
            id,
            drive,
            entry.name().to_owned(),
            entry.frames().to_string(),
            entry.undecodable().to_string(),
            spread(entry.intervals()),
            spread(entry.responses()),
        ]);
    }
    for column in table.column_iter_mut().skip(3) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}

fn spread(spread: Option<Spread>) -> String {
    let ms = |us: f64| us / 1e3;
    spread.map_or(String::new(), |spread| {
        format!(
            "{:.3} / {:.3} / {:.3}",
            ms(spread.least_us),
            ms(spread.mean_us),
            ms(spread.most_us)
        )
    })
}
