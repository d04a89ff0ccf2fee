//! The result of one axis: were its promises kept?

use schemars::JsonSchema;
use serde::Serialize;

/// One axis at the end.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct AxisSummary {
    pub(crate) axis: usize,
    pub(crate) drive: u8,
    pub(crate) state: String,
    pub(crate) fault: Option<String>,
    /// The fault with its drive, its cause and what to do; nothing for an axis that stopped because of another one.
    pub(crate) advice: Option<String>,
    /// Set-points that the master's controller accepted.
    pub(crate) set_points: u32,
    /// Final target, from the start.
    pub(crate) target_counts: i32,
    /// Sum of the steps in the master's books.
    pub(crate) sent_counts: i32,
    /// Sum of the steps that the drive received.
    pub(crate) received_counts: i64,
    /// Target of the master minus the position of the motor at the end, as in the plot: after a stop the target is where it stopped.
    pub(crate) position_error_counts: i64,
    pub(crate) largest_backlog_counts: u32,
    /// `None` when it was never read.
    pub(crate) worst_status_age_ms: Option<f64>,
    pub(crate) worst_position_age_ms: Option<f64>,
    pub(crate) reply_timeouts: u32,
    /// The axis still streamed at the end, as it should, or held after a stop by the user.
    pub(crate) streamed: bool,
}

/// An age in milliseconds for a table.
pub(crate) fn age_text(age_ms: Option<f64>) -> String {
    age_ms.map_or_else(|| "never read".to_owned(), |ms| format!("{ms:.1} ms"))
}

impl AxisSummary {
    pub(super) fn promises_kept(&self) -> bool {
        self.streamed
            && self.fault.is_none()
            && self.sent_counts == self.target_counts
            && self.received_counts == i64::from(self.target_counts)
    }
}
