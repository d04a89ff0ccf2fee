//! The result of a measurement.

use core::fmt;

use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use dyn_can::DriveId;
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::Arguments;
use super::figures::Figures;
use super::gains::Gains;
use super::measure::Sample;
use super::wave::WaveFigures;
use crate::counted::counted;
use crate::table::align_numbers;

/// What was measured of a set.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(untagged)]
enum Answer {
    Step(Figures),
    Wave(WaveFigures),
}

/// One set of gains.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Set {
    pub(super) gains: Gains,
    figures: Answer,
    #[serde(skip)]
    pub(super) samples: Vec<Sample>,
}

impl Set {
    pub(super) fn new(
        gains: Gains,
        samples: Vec<Sample>,
        told_counts: i32,
        arguments: &Arguments,
    ) -> Self {
        let figures = match arguments.wave.shape() {
            None => {
                // The largest set-point is the height of the step, in the direction of the amplitude.
                let heights = samples.iter().map(|sample| sample.set_point);
                let height = heights.max_by_key(|height| height.abs()).unwrap_or(1);
                let hold_ms = f64::from(arguments.hold_ms);
                let steps = 2 * arguments.periods();
                Answer::Step(Figures::of(&samples, hold_ms, height, steps))
            }
            Some(shape) => Answer::Wave(WaveFigures::of(&samples, shape, told_counts)),
        };
        Self {
            gains,
            figures,
            samples,
        }
    }
}

/// Every set.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Outcome {
    drive: u8,
    pub(super) sets: Vec<Set>,
    /// The gains that the drive had, and has again.
    old_gains: Gains,
    pub(super) restored: bool,
    pub(super) eeprom_writes: u32,
    /// The swing of a wave of the drive, as its amplitude is read here.
    #[serde(skip)]
    pub(super) told_counts: i32,
}

impl Outcome {
    pub(super) fn new(drive: DriveId, old_gains: Gains, told_counts: i32) -> Self {
        Self {
            drive: drive.get(),
            sets: Vec::new(),
            old_gains,
            restored: false,
            eeprom_writes: 0,
            told_counts,
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new();
        let is_wave = |set: &Set| matches!(set.figures, Answer::Wave(_));
        let titles: Vec<&str> = if self.sets.iter().any(is_wave) {
            WaveFigures::TITLES.to_vec()
        } else {
            Figures::TITLES.to_vec()
        };
        let titles = ["gains"].into_iter().chain(titles);
        table.load_style(UTF8_BORDERS_ONLY).set_header(titles);
        for set in &self.sets {
            let figures = match &set.figures {
                Answer::Step(figures) => figures.cells().to_vec(),
                Answer::Wave(figures) => figures.cells().to_vec(),
            };
            table.add_row([set.gains.to_string()].into_iter().chain(figures));
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
