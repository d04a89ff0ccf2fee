//! What a program is about to do, before anything moves.

use core::fmt;

use comfy_table::Table as TextTable;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use schemars::JsonSchema;
use serde::Serialize;

use super::check::Checked;
use super::machine::MachineSetup;
use crate::counted::counted;

/// A program in figures.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct ProgramReport {
    program: String,
    lines: u32,
    moves: usize,
    duration_s: f64,
    axes: Vec<AxisReport>,
}

#[derive(Debug, Serialize, JsonSchema)]
struct AxisReport {
    axis: String,
    drive: u8,
    counts_per_mm: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    backlash_mm: Option<f64>,
    /// From the start.
    lowest_mm: f64,
    highest_mm: f64,
    /// Largest step in a cycle.
    peak_step_counts: u16,
    peak_mm_per_s: f64,
}

impl ProgramReport {
    pub(crate) fn new(checked: &Checked, machine: &MachineSetup, drives: &[u8]) -> Self {
        let cycle_s = f64::from(checked.machine().manner.cycle_us) * 1e-6;
        let axes = checked.peaks.iter().zip(&machine.motors).zip(drives);
        Self {
            program: checked.path().display().to_string(),
            lines: checked.lines,
            moves: checked.moves,
            duration_s: (checked.cycles - 1) as f64 * cycle_s,
            axes: axes
                .map(|((peaks, motor), &drive)| {
                    let counts_per_mm = motor.counts_per_mm;
                    let ends = [peaks.lowest, peaks.highest]
                        .map(|counts| f64::from(counts) / counts_per_mm);
                    AxisReport {
                        axis: motor.name.clone(),
                        drive,
                        backlash_mm: motor.backlash_mm,
                        counts_per_mm,
                        lowest_mm: ends[0].min(ends[1]),
                        highest_mm: ends[0].max(ends[1]),
                        peak_step_counts: peaks.step,
                        peak_mm_per_s: f64::from(peaks.step) / counts_per_mm.abs() / cycle_s,
                    }
                })
                .collect(),
        }
    }
}

impl fmt::Display for ProgramReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{}: {}, {}, {:.3} s",
            self.program,
            counted(self.lines, "line", "lines"),
            counted(self.moves, "move", "moves"),
            self.duration_s
        )?;
        let mut table = TextTable::new();
        table.load_style(UTF8_BORDERS_ONLY).set_header([
            "axis",
            "drive",
            "travel from the start, mm",
            "largest step\ncounts in a cycle",
            "peak speed\nmm/s",
        ]);
        for axis in &self.axes {
            table.add_row([
                axis.axis.clone(),
                axis.drive.to_string(),
                format!(
                    "{:.3} to {:.3}",
                    axis.lowest_mm + 0.0,
                    axis.highest_mm + 0.0
                ),
                axis.peak_step_counts.to_string(),
                format!("{:.1}", axis.peak_mm_per_s),
            ]);
        }
        write!(f, "{table}")?;
        for axis in &self.axes {
            if let Some(mm) = axis.backlash_mm {
                write!(
                    f,
                    "\n{}: a backlash of {mm} mm is taken up where it turns",
                    axis.axis
                )?;
            }
        }
        Ok(())
    }
}
