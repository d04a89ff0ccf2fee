//! The result of a measurement.

use core::fmt;

use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use dyn_can::DriveId;
use serde::Serialize;

use super::arguments::Arguments;
use super::figures::Figures;
use super::gains::Gains;
use super::measure::Sample;
use crate::counted::counted;
use crate::table::align_numbers;

/// One set of gains.
#[derive(Debug, Serialize)]
pub(super) struct Set {
    pub(super) gains: Gains,
    figures: Figures,
    #[serde(skip)]
    pub(super) samples: Vec<Sample>,
}

impl Set {
    pub(super) fn new(gains: Gains, samples: Vec<Sample>, arguments: &Arguments) -> Self {
        let hold_ms = f64::from(arguments.hold_ms);
        // The largest set-point is the height of the step, in the direction of the amplitude.
        let heights = samples.iter().map(|sample| sample.set_point_counts);
        let height = heights.max_by_key(|height| height.abs()).unwrap_or(1);
        let figures = Figures::of(&samples, hold_ms, height, 2 * arguments.periods);
        Self {
            gains,
            figures,
            samples,
        }
    }
}

/// Every set.
#[derive(Debug, Serialize)]
pub(super) struct Outcome {
    drive: u8,
    pub(super) sets: Vec<Set>,
    /// The gains that the drive had, and has again.
    old_gains: Gains,
    pub(super) restored: bool,
    pub(super) eeprom_writes: u32,
}

impl Outcome {
    pub(super) fn new(drive: DriveId, old_gains: Gains) -> Self {
        Self {
            drive: drive.get(),
            sets: Vec::new(),
            old_gains,
            restored: false,
            eeprom_writes: 0,
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new();
        let titles = ["gains"].into_iter().chain(Figures::TITLES);
        table.load_style(UTF8_BORDERS_ONLY).set_header(titles);
        for set in &self.sets {
            let cells = [set.gains.to_string()].into_iter();
            table.add_row(cells.chain(set.figures.cells()));
        }
        align_numbers(&mut table);
        writeln!(f, "{table}")?;
        write!(
            f,
            "drive {} is disabled and has its old gains: {}. EEPROM: {}",
            self.drive,
            self.old_gains,
            counted(self.eeprom_writes, "write", "writes")
        )
    }
}
