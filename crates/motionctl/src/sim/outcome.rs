//! The result of a simulation as its page has it.

use super::summary::Summary;
use crate::counted::counted;
use crate::recording::{AxisOutcome, Outcome};

/// The result for the page.
pub(super) fn outcome(summary: &Summary) -> Outcome {
    let axes = summary.axes.iter().map(|axis| AxisOutcome {
        set_points: Some(axis.set_points.into()),
        received_counts: Some(axis.received_counts),
        reply_timeouts: Some(axis.reply_timeouts),
        state: axis.fault.as_ref().unwrap_or(&axis.state).clone(),
    });
    let advice = summary.axes.iter().filter_map(|axis| axis.advice.clone());
    let facts = [
        format!(
            "{} of {} us at {} kbit/s, {} of them late; bus load {:.1} % mean, {:.1} % peak; {}.",
            counted(summary.cycles, "cycle", "cycles"),
            summary.cycle_us,
            summary.bit_rate_kbit,
            summary.late_cycles,
            100.0 * summary.mean_bus_load,
            100.0 * summary.peak_bus_load,
            counted(summary.faults, "fault", "faults"),
        ),
        "Simulated drives in virtual time: positions are those of the simulated motors in every cycle.".to_owned(),
    ];
    Outcome {
        verdict: summary.verdict().to_owned(),
        is_good: summary.promises_kept(),
        facts: facts.into_iter().chain(advice).collect(),
        axes: axes.collect(),
    }
}
