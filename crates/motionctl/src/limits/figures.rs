//! The figures, their targets, and how they are shown.

use core::fmt;

use comfy_table::presets::UTF8_BORDERS_ONLY;
use comfy_table::{CellAlignment, Table};
use schemars::JsonSchema;
use serde::Serialize;

use super::measure::Bounds;
use crate::counted::counted;

/// The largest number of axes without polls.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct SetPointsOnly {
    pub(crate) axes: usize,
}

/// The largest number of axes with status and position of each at 50 Hz.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Polled {
    pub(crate) delay_us: u32,
    pub(crate) axes: usize,
    /// What kept one axis more from being run, or from being in time.
    pub(crate) one_more: String,
    pub(crate) worst_poll_age_periods: Option<f64>,
    pub(crate) bounds: Bounds,
}

/// Share of the time in which set-points are on the wire, at the largest number of axes.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct WireShare {
    pub(crate) polled: f64,
    pub(crate) set_points_only: f64,
}

/// Everything that was measured.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Figures {
    pub(crate) targets_met: bool,
    pub(crate) cycles: u64,
    pub(crate) set_points_only: SetPointsOnly,
    pub(crate) polled: Vec<Polled>,
    pub(crate) jitter_bits: u64,
    pub(crate) skew_ratio: f64,
    pub(crate) wire_share: WireShare,
    pub(crate) late_after_outage: u64,
    pub(crate) own_collisions: u64,
    pub(crate) bound_violations: u64,
    pub(crate) worst_poll_age_periods: Option<f64>,
}

/// A figure with its target.
struct Row {
    figure: String,
    measured: String,
    target: String,
    is_met: bool,
}

impl Row {
    fn at_least(figure: String, measured: usize, target: usize) -> Self {
        Self {
            figure,
            measured: measured.to_string(),
            target: format!("at least {target}"),
            is_met: measured >= target,
        }
    }

    fn share(figure: &str, measured: f64, target: f64) -> Self {
        Self {
            figure: figure.to_owned(),
            measured: format!("{measured:.3}"),
            target: format!("at least {target}"),
            is_met: measured >= target,
        }
    }

    /// A poll that never had a reply is no small figure.
    fn oldest_poll(periods: Option<f64>) -> Self {
        let row = Self::at_most(
            "oldest poll, periods",
            periods.unwrap_or(f64::INFINITY),
            1.5,
            2,
        );
        match periods {
            Some(_) => row,
            None => Self {
                measured: "never read".to_owned(),
                ..row
            },
        }
    }

    fn at_most(figure: &str, measured: f64, target: f64, digits: usize) -> Self {
        Self {
            figure: figure.to_owned(),
            measured: format!("{measured:.digits$}"),
            target: format!("at most {target}"),
            is_met: measured <= target,
        }
    }
}

/// Axes with polls that are the target at each response delay.
const POLLED_TARGETS: [(u32, usize); 3] = [(200, 11), (500, 11), (2_000, 10)];

impl Figures {
    /// Compares with the targets.
    pub(crate) fn judged(mut self) -> Self {
        self.targets_met = self.rows().iter().all(|row| row.is_met);
        self
    }

    fn rows(&self) -> Vec<Row> {
        let mut rows = vec![Row::at_least(
            "axes, set-points only".to_owned(),
            self.set_points_only.axes,
            14,
        )];
        for (delay_us, target) in POLLED_TARGETS {
            let at_delay = self
                .polled
                .iter()
                .find(|polled| polled.delay_us == delay_us);
            let axes = at_delay.map_or(0, |polled| polled.axes);
            let figure = format!("axes, polls at 50 Hz, drives answer in {delay_us} us +-25 %");
            rows.push(Row::at_least(figure, axes, target));
        }
        let share = &self.wire_share;
        rows.extend([
            Row::at_most(
                "jitter of the worst of 8 axes, bit times",
                self.jitter_bits as f64,
                25.0,
                0,
            ),
            Row::at_most(
                "skew of 8 axes / shortest possible",
                self.skew_ratio,
                1.15,
                3,
            ),
            Row::share("set-points on the wire, with polls", share.polled, 0.72),
            Row::share(
                "set-points on the wire, without",
                share.set_points_only,
                0.91,
            ),
            Row::at_most(
                "late frames after 10 ms of outage, 8 axes",
                self.late_after_outage as f64,
                7.0,
                0,
            ),
            Row::at_most(
                "collisions on an own identifier",
                self.own_collisions as f64,
                0.0,
                0,
            ),
            Row::at_most(
                "frames beyond their bound",
                self.bound_violations as f64,
                0.0,
                0,
            ),
            Row::oldest_poll(self.worst_poll_age_periods),
        ]);
        rows
    }

    fn bounds_table(&self) -> Table {
        let mut table = Table::new();
        table.load_style(UTF8_BORDERS_ONLY).set_header([
            "bit times from the start of the cycle",
            "set-points\nobserved",
            "\nbound",
            "requests\nobserved",
            "\nbound",
            "replies\nobserved",
            "\nbound",
        ]);
        for polled in &self.polled {
            let Bounds {
                set_points,
                requests,
                replies,
            } = polled.bounds;
            let mut row = vec![format!(
                "{}, {} us",
                counted(polled.axes, "axis", "axes"),
                polled.delay_us
            )];
            for observed in [set_points, requests, replies] {
                row.push(observed.observed_bits.to_string());
                row.push(observed.bound_bits.to_string());
            }
            table.add_row(row);
        }
        align(&mut table, 1);
        table
    }
}

fn align(table: &mut Table, from: usize) {
    for column in table.column_iter_mut().skip(from) {
        column.set_cell_alignment(CellAlignment::Right);
    }
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut table = Table::new();
        table.load_style(UTF8_BORDERS_ONLY).set_header([
            "1 kHz, 1 Mbit/s, 2-byte set-points",
            "measured",
            "target",
            "",
        ]);
        for row in self.rows() {
            let verdict = if row.is_met { "met" } else { "MISSED" };
            table.add_row([row.figure, row.measured, row.target, verdict.to_owned()]);
        }
        writeln!(f, "{table}\n{}", self.bounds_table())?;
        for polled in &self.polled {
            let Polled {
                delay_us,
                axes,
                one_more,
                ..
            } = polled;
            writeln!(
                f,
                "{} at {delay_us} us: {one_more}",
                counted(axes + 1, "axis", "axes")
            )?;
        }
        write!(f, "{} cycles for each number of axes", self.cycles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_poll_that_never_had_a_reply_misses_its_target_in_words() {
        let row = Row::oldest_poll(None);
        assert_eq!((row.measured.as_str(), row.is_met), ("never read", false));
        let row = Row::oldest_poll(Some(1.25));
        assert_eq!((row.measured.as_str(), row.is_met), ("1.25", true));
    }
}
