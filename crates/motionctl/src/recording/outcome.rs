//! How a run ended, for its page.

/// A run at its end.
#[derive(Debug, Clone, Default)]
pub(crate) struct Outcome {
    /// The result in one sentence.
    pub(crate) verdict: String,
    pub(crate) is_good: bool,
    /// What else is true of the whole run, one sentence each.
    pub(crate) facts: Vec<String>,
    /// In the order of the axes; empty for a log.
    pub(crate) axes: Vec<AxisOutcome>,
}

/// One axis at the end: what does not follow from its samples.
#[derive(Debug, Clone, Default)]
pub(crate) struct AxisOutcome {
    /// Set-points that went out.
    pub(crate) set_points: Option<u64>,
    /// Sum of the steps that the drive received, which a simulation alone knows.
    pub(crate) received_counts: Option<i64>,
    pub(crate) reply_timeouts: Option<u32>,
    /// The state, or the fault.
    pub(crate) state: String,
}
