//! The result of a simulation with wheels: were the promises kept?

use core::fmt;

use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use schemars::JsonSchema;
use serde::Serialize;

use super::setup::Setup;
use crate::counted::counted;
use crate::recording::{AxisOutcome, Outcome};
use crate::table::align_numbers;

/// Largest difference between the way that was commanded and the way that the wheel made, in turns: a hundredth.
const WAY_TOLERANCE_TURNS: f64 = 0.01;

/// One wheel at the end.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct WheelSummary {
    pub(super) wheel: usize,
    pub(super) node: u8,
    pub(super) state: String,
    pub(super) fault: Option<String>,
    /// Set-points that the master's controller accepted.
    pub(super) set_points: u32,
    /// Set-points that the drive took.
    pub(super) received: u64,
    /// The commanded speeds, each for its cycle.
    pub(super) commanded_turns: f64,
    /// What the wheel turned.
    pub(super) travelled_turns: f64,
    /// Largest difference between the speed sent and the speed of the wheel at the end of a cycle.
    pub(super) largest_speed_error_rpm: f64,
    pub(super) final_speed_rpm: f64,
    /// Nothing when the wheel was without feedback for a time.
    pub(super) oldest_feedback_ms: Option<f64>,
    pub(super) sdo_timeouts: u32,
    pub(super) eeprom_writes: u64,
    /// The wheel still streamed at the end, as it should.
    pub(super) streamed: bool,
}

impl WheelSummary {
    fn promises_kept(&self) -> bool {
        let way_turns = (self.commanded_turns - self.travelled_turns).abs();
        self.streamed
            && self.fault.is_none()
            && u64::from(self.set_points) == self.received
            && way_turns <= WAY_TOLERANCE_TURNS
            && self.final_speed_rpm == 0.0
            && self.eeprom_writes == 0
    }
}

/// A whole simulation.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Summary {
    pub(super) promises_kept: bool,
    wheels: Vec<WheelSummary>,
    cycle_us: u32,
    bit_rate_kbit: u32,
    speed_resolution: u16,
    /// Cycles of the motion.
    cycles: usize,
    /// Cycles whose set-points had not all ended on the wire when the next cycle began.
    late_cycles: u32,
    /// Cycles that the master could not hand to its controller in time, since power-on.
    late_hand_overs: u32,
    faults: u32,
    /// Faults of the script whose time did not come.
    faults_not_reached: usize,
    mean_bus_load: f64,
    /// The user stopped the motion before its end.
    stopped: bool,
}

impl Summary {
    /// `troubles` are late cycles, late hand-overs and faults.
    pub(super) fn new(
        wheels: Vec<WheelSummary>,
        setup: &Setup,
        cycles: usize,
        troubles: (u32, u32, u32),
        mean_bus_load: f64,
        stopped: bool,
    ) -> Self {
        let (late_cycles, late_hand_overs, faults) = troubles;
        let promises_kept = !wheels.is_empty()
            && cycles > 0
            && wheels.iter().all(WheelSummary::promises_kept)
            && troubles == (0, 0, 0);
        Self {
            promises_kept,
            wheels,
            cycle_us: setup.cycle_us,
            bit_rate_kbit: setup.bit_rate.kbit_per_s(),
            speed_resolution: setup.speed_resolution,
            cycles,
            late_cycles,
            late_hand_overs,
            faults,
            faults_not_reached: setup.faults.left(),
            mean_bus_load,
            stopped,
        }
    }

    /// The result in one sentence.
    pub(super) fn verdict(&self) -> &'static str {
        if self.promises_kept && self.stopped {
            "Every promise kept until the user stopped the motion: each drive took every set-point, each wheel made its way and stands, and no cycle was late."
        } else if self.promises_kept {
            "Every promise kept: each drive took every set-point, each wheel made its way and stands, and no cycle was late."
        } else {
            "A promise was BROKEN: see the differences, late cycles, states and faults."
        }
    }

    /// The result as its page has it.
    pub(super) fn for_page(&self) -> Outcome {
        let axes = self.wheels.iter().map(|wheel| AxisOutcome {
            set_points: Some(wheel.set_points.into()),
            received_counts: None,
            reply_timeouts: Some(wheel.sdo_timeouts),
            state: wheel.fault.as_ref().unwrap_or(&wheel.state).clone(),
        });
        let facts = [
            format!("{}.", self.cycles_text()),
            "Simulated drives in virtual time: speeds are those of the simulated wheels in every cycle.".to_owned(),
        ];
        Outcome {
            verdict: self.verdict().to_owned(),
            is_good: self.promises_kept,
            facts: facts.into(),
            axes: axes.collect(),
        }
    }

    fn cycles_text(&self) -> String {
        format!(
            "{} of {} us at {} kbit/s, {} late; bus load {:.1} % mean; {}",
            counted(self.cycles, "cycle", "cycles"),
            self.cycle_us,
            self.bit_rate_kbit,
            self.late_cycles,
            100.0 * self.mean_bus_load,
            counted(self.faults, "fault", "faults"),
        )
    }

    fn table(&self) -> Table {
        let mut table = Table::new();
        table.load_style(UTF8_BORDERS_ONLY).set_header([
            "wheel",
            "node",
            "set-\npoints",
            "received",
            "commanded\nturns",
            "travelled\nturns",
            "largest\nspeed error",
            "oldest\nfeedback",
            "EEPROM\nwrites",
            "state",
        ]);
        for wheel in &self.wheels {
            table.add_row([
                wheel.wheel.to_string(),
                wheel.node.to_string(),
                wheel.set_points.to_string(),
                wheel.received.to_string(),
                format!("{:.4}", wheel.commanded_turns),
                format!("{:.4}", wheel.travelled_turns),
                format!("{:.1} r/min", wheel.largest_speed_error_rpm),
                wheel
                    .oldest_feedback_ms
                    .map_or("never read".to_owned(), |ms| format!("{ms:.1} ms")),
                wheel.eeprom_writes.to_string(),
                wheel.fault.clone().unwrap_or_else(|| wheel.state.clone()),
            ]);
        }
        align_numbers(&mut table);
        table
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.table())?;
        writeln!(f, "{}", self.cycles_text())?;
        if self.faults_not_reached > 0 {
            writeln!(
                f,
                "Not reached: {} of the script.",
                counted(self.faults_not_reached as u64, "fault", "faults")
            )?;
        }
        f.write_str(self.verdict())
    }
}
