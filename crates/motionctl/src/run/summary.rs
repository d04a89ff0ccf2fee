//! The result of a motion on a real bus.

use can_motion::{AxisSnapshot, Instant, ReadBackScale};
use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use core::fmt;
use dyn_can::DriveId;
use schemars::JsonSchema;
use serde::Serialize;

use crate::counted::counted;
use crate::ending::{Cause, Ending};
use crate::link::LinkFault;
use crate::recording::{AxisOutcome, Outcome as PageOutcome};
use crate::station::{End, PaceCounts, left_on};
use crate::table::align_numbers;

/// An older position says nothing of the end of a motion.
const FRESH_MS: u64 = 500;

/// How a motion ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Outcome {
    Completed,
    /// Why, which was told already.
    Stopped(String),
    /// Why it is not known that set-points got out, which was told already.
    StoodStill(String),
    Interrupted,
    /// Somebody gave the order.
    Ordered,
    /// A stream had no more set-points, which was told already.
    RanOut,
    LinkFailed(LinkFault),
}

impl Outcome {
    /// Why it is not complete.
    pub(super) fn reason(&self) -> Option<String> {
        match self {
            Self::Completed | Self::Interrupted | Self::Ordered | Self::RanOut => None,
            Self::Stopped(reason) | Self::StoodStill(reason) => Some(reason.clone()),
            Self::LinkFailed(fault) => Some(fault.to_string()),
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Completed => f.write_str("completed"),
            Self::Stopped(_) => f.write_str("stopped by a fault"),
            Self::StoodStill(_) => {
                f.write_str("stopped, because it is not known that its set-points got out")
            }
            Self::Interrupted => f.write_str("stopped by the user"),
            Self::Ordered => f.write_str("stopped by an order"),
            Self::RanOut => f.write_str("the set-points ran out"),
            Self::LinkFailed(fault) => write!(f, "the link failed: {fault}"),
        }
    }
}

/// One axis at the end.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct AxisSummary {
    axis: usize,
    drive: u8,
    state: String,
    fault: Option<String>,
    /// Set-points that the link accepted.
    set_points: u32,
    /// Final target of the plan, from the start.
    target_counts: i32,
    /// Sum of the steps that the link accepted.
    sent_counts: i32,
    /// Position that the drive reported last, from the start, in command counts.
    read_counts: Option<i32>,
    /// How old that position was when the motion ended.
    read_age_ms: Option<u64>,
    /// Set-points that missed their cycle and went with the next one.
    merged: u32,
    reply_timeouts: u32,
}

impl AxisSummary {
    /// The position that was read, with its age where it says nothing of the end.
    fn read_text(&self) -> String {
        match (self.read_counts, self.read_age_ms) {
            (Some(counts), Some(age_ms)) if age_ms > FRESH_MS => {
                format!("{counts}? {age_ms} ms old")
            }
            (Some(counts), _) => counts.to_string(),
            (None, _) => "never read".to_owned(),
        }
    }

    /// State and fault are those before the axes were slowed down and switched off, the sums those of the end.
    pub(super) fn new(
        axis: usize,
        before_end: &AxisSnapshot,
        sums: &AxisSnapshot,
        anchor_counts: i32,
        target_counts: i32,
        read_back: ReadBackScale,
        now: Instant,
    ) -> Self {
        let position = sums.feedback.position;
        let read_counts = position.and_then(|read| read_back.to_command_counts(read.value));
        Self {
            axis,
            drive: before_end.drive.get(),
            state: before_end.state.to_string(),
            fault: before_end.fault.map(|fault| fault.to_string()),
            set_points: sums.counters.set_points,
            target_counts,
            sent_counts: sums.sent_counts.wrapping_sub(anchor_counts),
            read_age_ms: position.map(|read| now.us_since(read.at) / 1_000),
            read_counts: read_counts.map(|counts| counts.wrapping_sub(anchor_counts)),
            merged: sums.counters.merged,
            reply_timeouts: sums.counters.timeouts,
        }
    }
}

/// A whole motion.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Summary {
    /// The bus, where there are several.
    #[serde(skip_serializing_if = "String::is_empty")]
    bus: String,
    completed: bool,
    outcome: String,
    reason: Option<String>,
    axes: Vec<AxisSummary>,
    pace: PaceCounts,
    /// Cycles whose set-points the link did not all accept in time.
    late_hand_overs: u32,
    /// Drives that this motion had enabled, and that say that they are disabled.
    disabled: Vec<u8>,
    /// Drives that this motion had enabled, and that did not say that they are disabled.
    unconfirmed: Vec<u8>,
    /// Drives that were enabled before, and still are.
    left_enabled: Vec<u8>,
    /// What somebody who goes near must know.
    warnings: Vec<String>,
    /// The drives that were left on, for those who have read the other warnings already.
    #[serde(skip)]
    left_on: Option<String>,
    #[serde(flatten)]
    pub(super) ending: Ending,
}

impl Summary {
    pub(super) fn new(
        bus: String,
        outcome: Outcome,
        end: End,
        told_warning: Option<String>,
        axes: Vec<AxisSummary>,
        pace: PaceCounts,
        late_hand_overs: u32,
    ) -> Self {
        let sums_are_equal = axes
            .iter()
            .all(|axis| axis.sent_counts == axis.target_counts);
        let is_off = end.unconfirmed.is_empty();
        let completed = outcome == Outcome::Completed && sums_are_equal && is_off;
        let cause = match outcome {
            Outcome::LinkFailed(_) | Outcome::StoodStill(_) => Cause::Unknown,
            Outcome::Interrupted | Outcome::Ordered => Cause::Asked,
            _ => Cause::Itself,
        };
        let left_on = left_on(&end.left_on);
        let warnings = [left_on.clone(), told_warning];
        let ids = |drives: &[DriveId]| drives.iter().map(|drive| drive.get()).collect();
        Self {
            bus,
            completed,
            reason: outcome.reason(),
            outcome: outcome.to_string(),
            axes,
            pace,
            late_hand_overs,
            disabled: ids(&end.disabled),
            unconfirmed: ids(&end.unconfirmed),
            left_enabled: ids(&end.left_on),
            warnings: warnings.into_iter().flatten().collect(),
            left_on,
            ending: Ending::new(cause, completed, is_off),
        }
    }

    /// The result as its page has it.
    pub(super) fn for_page(&self) -> PageOutcome {
        let pace = format!("{}.", self.pace_text());
        let facts = [Some(pace), self.reason.clone()].into_iter().flatten();
        let warnings = self.warnings.iter().cloned();
        let axes = self.axes.iter().map(|axis| AxisOutcome {
            set_points: Some(axis.set_points.into()),
            received_counts: None,
            reply_timeouts: Some(axis.reply_timeouts),
            state: axis.fault.as_ref().unwrap_or(&axis.state).clone(),
        });
        PageOutcome {
            verdict: self.verdict(),
            is_good: self.completed,
            facts: facts.chain(warnings).collect(),
            axes: axes.collect(),
        }
    }

    /// The result in one sentence.
    pub(super) fn verdict(&self) -> String {
        format!("The motion: {}.", self.outcome)
    }

    pub(super) fn is_completed(&self) -> bool {
        self.completed
    }

    fn pace_text(&self) -> String {
        let pace = &self.pace;
        format!(
            "{} begun, {} of them more than half a cycle late (the worst {:.1} ms), {} missed and merged; {} handed over late",
            counted(pace.cycles, "cycle", "cycles"),
            pace.late,
            pace.worst_us as f64 / 1_000.0,
            pace.merged,
            self.late_hand_overs
        )
    }

    /// How the motion ended, in words.
    pub(super) fn outcome(&self) -> &str {
        &self.outcome
    }

    fn table(&self) -> Table {
        let mut table = Table::new();
        table.load_style(UTF8_BORDERS_ONLY).set_header([
            "drive",
            "set-\npoints",
            "merged",
            "target\ncounts",
            "sent\ncounts",
            "read\ncounts",
            "reply\ntimeouts",
            "state",
        ]);
        for axis in &self.axes {
            table.add_row([
                axis.drive.to_string(),
                axis.set_points.to_string(),
                axis.merged.to_string(),
                axis.target_counts.to_string(),
                axis.sent_counts.to_string(),
                axis.read_text(),
                axis.reply_timeouts.to_string(),
                axis.fault.clone().unwrap_or_else(|| axis.state.clone()),
            ]);
        }
        align_numbers(&mut table);
        table
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.bus.is_empty() {
            writeln!(f, "bus {}", self.bus)?;
        }
        writeln!(f, "{}", self.table())?;
        writeln!(f, "{}", self.pace_text())?;
        if let Some(text) = &self.left_on {
            writeln!(f, "{text}")?;
        }
        f.write_str(&self.verdict())
    }
}
