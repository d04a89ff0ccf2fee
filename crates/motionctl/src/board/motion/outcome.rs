//! The result of a motion on a board.

use core::fmt;

use comfy_table::Table;
use comfy_table::presets::UTF8_BORDERS_ONLY;
use schemars::JsonSchema;
use serde::Serialize;

use super::axes::Axis;
use super::follow::Followed;
use crate::board::words::fault_name;
use crate::counted::counted;
use crate::ending::{Cause, Ending};
use crate::recording::{AxisOutcome, Outcome as PageOutcome};
use crate::table::align_numbers;

/// How a motion ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum End {
    Completed,
    /// Why, which was told already.
    Stopped(String),
    Interrupted,
    /// Somebody gave the order.
    Ordered,
    /// What comes cannot be played; why, which was told already.
    Unplayable(String),
    /// There were no more set-points, which was told already.
    RanOut,
    /// Why nobody knows what the board does.
    LinkFailed(String),
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Completed => f.write_str("completed"),
            Self::Stopped(_) => f.write_str("stopped by the board"),
            Self::Interrupted => f.write_str("stopped by the user"),
            Self::Ordered => f.write_str("stopped by an order"),
            Self::Unplayable(_) => f.write_str("stopped, because the set-points cannot be played"),
            Self::RanOut => f.write_str("the set-points ran out"),
            Self::LinkFailed(_) => f.write_str("the link failed"),
        }
    }
}

/// One axis at the end.
#[derive(Debug, Serialize, JsonSchema)]
struct AxisSummary {
    drive: u8,
    /// Final position of the motion, from the start.
    target_counts: i32,
    /// The last set-point of the board, from the start.
    set_point_counts: i32,
    /// Position that the board read last, from the start.
    read_counts: i32,
    fault: Option<String>,
}

/// What was sent, and what came back.
#[derive(Debug, Clone, Copy, Default, Serialize, JsonSchema)]
pub(in crate::board) struct Traffic {
    /// Segments that the board has taken, of those of the motion.
    pub(super) segments_sent: u32,
    pub(super) segments: u32,
    pub(super) snapshots: u64,
    /// Messages of the board that were damaged on the way.
    pub(super) lost_messages: u64,
    pub(super) lost_events: u64,
    /// How far the clock of the board may be from what this computer knows of it.
    pub(super) clock_error_us: Option<u64>,
}

/// A whole motion.
#[derive(Debug, Serialize, JsonSchema)]
pub(in crate::board) struct Outcome {
    completed: bool,
    outcome: String,
    reason: Option<String>,
    axes: Vec<AxisSummary>,
    #[serde(flatten)]
    traffic: Traffic,
    /// Whether the board says that its drives are off.
    disabled: bool,
    /// What somebody who goes near must know.
    warnings: Vec<String>,
    #[serde(flatten)]
    pub(in crate::board) ending: Ending,
}

impl Outcome {
    /// Of a motion of these axes that was to end at these positions, in counts from the start, with so many segments.
    pub(in crate::board) fn new(
        axes: &[Axis],
        targets: &[i32],
        segments: u32,
        followed: &Followed,
    ) -> Self {
        let (end, is_off) = (&followed.end, followed.is_off);
        let is_as_wanted = is_off || followed.is_left_on;
        let axis = |(axis, target): (&Axis, &i32)| {
            let told = followed.latest.axes.get(axis.place);
            let told = told.copied().unwrap_or_default();
            let anchor = followed.anchors.get(axis.place);
            let anchor = anchor.copied().unwrap_or_default();
            AxisSummary {
                drive: axis.drive.get(),
                target_counts: *target,
                set_point_counts: told.target.wrapping_sub(anchor),
                read_counts: told.position.wrapping_sub(anchor),
                fault: (told.fault != 0).then(|| fault_name(told.fault)),
            }
        };
        let axes: Vec<AxisSummary> = axes.iter().zip(targets).map(axis).collect();
        let has_arrived = axes
            .iter()
            .all(|axis| axis.set_point_counts == axis.target_counts);
        let completed = *end == End::Completed && has_arrived && is_as_wanted;
        let cause = match end {
            End::LinkFailed(_) => Cause::Unknown,
            End::Interrupted | End::Ordered => Cause::Asked,
            End::Completed | End::Stopped(_) | End::Unplayable(_) | End::RanOut => Cause::Itself,
        };
        let warning = (!is_as_wanted).then(|| WARNING.to_owned());
        Self {
            completed,
            outcome: end.to_string(),
            reason: match end {
                End::Stopped(reason) | End::Unplayable(reason) | End::LinkFailed(reason) => {
                    Some(reason.clone())
                }
                End::Completed | End::Interrupted | End::Ordered | End::RanOut => None,
            },
            axes,
            traffic: Traffic {
                segments,
                ..followed.traffic
            },
            disabled: is_off,
            warnings: warning.into_iter().collect(),
            ending: Ending::new(cause, completed, is_as_wanted),
        }
    }

    /// The result as its page has it.
    pub(in crate::board) fn for_page(&self) -> PageOutcome {
        let facts = self.reason.iter().chain(&self.warnings).cloned();
        let axes = self.axes.iter().map(|axis| AxisOutcome {
            set_points: None,
            received_counts: None,
            reply_timeouts: None,
            state: axis.fault.clone().unwrap_or_default(),
        });
        PageOutcome {
            verdict: self.verdict(),
            is_good: self.completed,
            facts: core::iter::once(self.traffic_text()).chain(facts).collect(),
            axes: axes.collect(),
        }
    }

    /// How the motion ended, in words.
    pub(in crate::board) fn outcome(&self) -> &str {
        &self.outcome
    }

    fn verdict(&self) -> String {
        format!("The motion: {}.", self.outcome)
    }

    fn traffic_text(&self) -> String {
        let traffic = &self.traffic;
        format!(
            "{} of {} sent, {} received, {} damaged on the way",
            traffic.segments_sent,
            counted(u64::from(traffic.segments), "segment", "segments"),
            counted(traffic.snapshots, "snapshot", "snapshots"),
            counted(traffic.lost_messages, "message", "messages"),
        )
    }

    fn table(&self) -> Table {
        let mut table = Table::new();
        table.load_style(UTF8_BORDERS_ONLY).set_header([
            "drive",
            "target\ncounts",
            "set-point\ncounts",
            "read\ncounts",
            "fault",
        ]);
        for axis in &self.axes {
            table.add_row([
                axis.drive.to_string(),
                axis.target_counts.to_string(),
                axis.set_point_counts.to_string(),
                axis.read_counts.to_string(),
                axis.fault.clone().unwrap_or_default(),
            ]);
        }
        align_numbers(&mut table);
        table
    }
}

const WARNING: &str = "WARNING: the board does not say that its drives are off. Open the stop circuit before anybody goes near, and read `motionctl board info`";

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.table())?;
        writeln!(f, "{}", self.traffic_text())?;
        for warning in &self.warnings {
            writeln!(f, "{warning}")?;
        }
        f.write_str(&self.verdict())?;
        self.reason
            .as_ref()
            .map_or(Ok(()), |reason| write!(f, " {reason}"))
    }
}
