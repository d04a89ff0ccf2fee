//! The result of a simulation: were the promises kept?

use core::fmt;

use can_motion::CycleCounters;
use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use schemars::JsonSchema;
use serde::Serialize;

use super::axis_summary::{AxisSummary, age_text};
use super::setup::Setup;
use super::watch::Watch;
use crate::counted::counted;
use crate::table::align_numbers;

/// A whole simulation.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub(crate) struct Summary {
    pub(crate) promises_kept: bool,
    pub(crate) axes: Vec<AxisSummary>,
    pub(crate) cycle_us: u32,
    pub(crate) bit_rate_kbit: u32,
    /// Cycles of the motion, rest at its end included.
    pub(crate) cycles: u32,
    /// Cycles whose set-points had not all ended on the wire when the next cycle began.
    pub(crate) late_cycles: u32,
    /// Cycles that the master could not hand to its controller in time, since power-on.
    pub(crate) late_hand_overs: u32,
    pub(crate) faults: u32,
    pub(crate) mean_bus_load: f64,
    pub(crate) peak_bus_load: f64,
    /// The user stopped the motion before its end.
    pub(crate) stopped: bool,
    /// Faults of the script whose time did not come.
    pub(crate) faults_not_reached: usize,
}

impl Summary {
    pub(crate) fn new(
        axes: Vec<AxisSummary>,
        counters: &CycleCounters,
        watch: &Watch,
        setup: &Setup,
        stopped: bool,
    ) -> Self {
        let promises_kept = axes.iter().all(AxisSummary::promises_kept)
            && !axes.is_empty()
            && watch.cycles > 0
            && watch.late_cycles == 0
            && watch.faults() == 0
            && counters.late == 0;
        Self {
            promises_kept,
            axes,
            cycle_us: setup.cycle_us,
            bit_rate_kbit: setup.bit_rate.kbit_per_s(),
            cycles: watch.cycles,
            late_cycles: watch.late_cycles,
            late_hand_overs: counters.late,
            faults: watch.faults(),
            mean_bus_load: watch.mean_load,
            peak_bus_load: watch.peak_load,
            stopped,
            faults_not_reached: setup.faults.left(),
        }
    }

    pub(crate) fn promises_kept(&self) -> bool {
        self.promises_kept
    }

    /// The result in one sentence.
    pub(crate) fn verdict(&self) -> &'static str {
        if self.promises_kept && self.stopped {
            "Stopped by the user. Every promise kept until then: each drive received exactly its target, and no cycle was late."
        } else if self.promises_kept {
            "Every promise kept: each drive received exactly its target, and no cycle was late."
        } else {
            "A promise was BROKEN: see the differences, late cycles, states and faults."
        }
    }

    fn table(&self) -> Table {
        let mut table = Table::new();
        table.load_style(UTF8_BORDERS_ONLY).set_header([
            "axis",
            "drive",
            "set-\npoints",
            "target\ncounts",
            "sent\ncounts",
            "received\ncounts",
            "differ-\nence",
            "largest\nbacklog",
            "position\nerror",
            "oldest\nstatus",
            "oldest\nposition",
            "state",
        ]);
        for axis in &self.axes {
            let difference = i64::from(axis.target_counts) - axis.received_counts;
            table.add_row([
                axis.axis.to_string(),
                axis.drive.to_string(),
                axis.set_points.to_string(),
                axis.target_counts.to_string(),
                axis.sent_counts.to_string(),
                axis.received_counts.to_string(),
                difference.to_string(),
                axis.largest_backlog_counts.to_string(),
                axis.position_error_counts.to_string(),
                age_text(axis.worst_status_age_ms),
                age_text(axis.worst_position_age_ms),
                axis.fault.clone().unwrap_or_else(|| axis.state.clone()),
            ]);
        }
        align_numbers(&mut table);
        table
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.table())?;
        writeln!(
            f,
            "{} of {} us at {} kbit/s, {} late; bus load {:.1} % mean, {:.1} % peak; {}",
            counted(self.cycles, "cycle", "cycles"),
            self.cycle_us,
            self.bit_rate_kbit,
            self.late_cycles,
            100.0 * self.mean_bus_load,
            100.0 * self.peak_bus_load,
            counted(self.faults, "fault", "faults"),
        )?;
        if self.faults_not_reached > 0 {
            writeln!(
                f,
                "Not reached: {} of the script.",
                counted(self.faults_not_reached, "fault", "faults")
            )?;
        }
        for advice in self.axes.iter().filter_map(|axis| axis.advice.as_ref()) {
            writeln!(f, "{advice}")?;
        }
        f.write_str(self.verdict())
    }
}
