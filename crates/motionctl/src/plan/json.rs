//! The plan for other programs.

use can_motion::plan::BusPlan;
use schemars::JsonSchema;
use serde::Serialize;

use super::table::{Row, rows};

/// The whole plan.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Verdict {
    schedulable: bool,
    refusal: Option<String>,
    /// What would help.
    remedies: Option<String>,
    warnings: Vec<String>,
    frames: Vec<Row>,
    load_bits: u64,
    cycle_bits: u64,
    /// Largest number of axes with drives 1, 2, 3 ... and the same polls.
    most_axes: usize,
    /// Set-points before the requests when the drives use their whole response window; null for all of them.
    requests_behind: Option<u8>,
}

impl Verdict {
    pub(super) fn new(plan: &BusPlan<'_>, most_axes: usize) -> Self {
        let refusal = plan.check().err();
        Self {
            schedulable: refusal.is_none(),
            refusal: refusal.map(|refusal| refusal.to_string()),
            remedies: refusal.map(|_| plan.remedies().to_string()),
            warnings: plan
                .cycle()
                .warnings()
                .iter()
                .flatten()
                .map(ToString::to_string)
                .collect(),
            frames: rows(plan),
            load_bits: plan.cycle().load_bits(),
            cycle_bits: plan.cycle().cycle_bits(),
            most_axes,
            requests_behind: plan.requests_behind(),
        }
    }
}
