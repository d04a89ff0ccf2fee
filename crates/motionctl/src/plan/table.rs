//! The plan frame by frame.

use can_motion::plan::analysis::Response;
use can_motion::plan::{BusPlan, frames};
use can_motion::{AxisConfig, MasterConfig, PollKind};
use comfy_table::presets::UTF8_BORDERS_ONLY;
use comfy_table::{CellAlignment, Table};
use dyn_can::FunctionCode;
use schemars::JsonSchema;
use serde::Serialize;

/// Frames of one kind. Times in microseconds; without a response there is no bound.
#[derive(Debug, Serialize, JsonSchema)]
pub(super) struct Row {
    pub(super) frame: String,
    pub(super) first_id: u16,
    pub(super) last_id: u16,
    pub(super) worst_bits: u16,
    pub(super) period_us: u32,
    pub(super) jitter_us: u32,
    pub(super) response_us: Option<u32>,
    pub(super) deadline_us: u32,
    pub(super) in_time: bool,
}

/// What all frames of a kind have in common.
struct Kind {
    frame: String,
    period_us: u32,
    jitter_us: u32,
    response: Response,
}

impl Kind {
    fn row(self, config: &MasterConfig, frames: impl Iterator<Item = (u16, u16)> + Clone) -> Row {
        let us = |bits| config.bus.bit_rate.us_covering(bits);
        let ids = || frames.clone().map(|(id, _)| id);
        Row {
            frame: self.frame,
            first_id: ids().min().unwrap_or(0),
            last_id: ids().max().unwrap_or(0),
            worst_bits: frames.clone().map(|(_, bits)| bits).max().unwrap_or(0),
            period_us: self.period_us,
            jitter_us: self.jitter_us,
            response_us: self.response.bits.map(us),
            deadline_us: us(self.response.deadline_bits),
            in_time: self.response.is_met(),
        }
    }
}

/// Every kind of frame: set-points one by one, polls over all drives.
pub(super) fn rows(plan: &BusPlan<'_>) -> Vec<Row> {
    let (config, axes) = (plan.config(), plan.axes());
    let mut rows = set_points(plan);
    for kind in PollKind::ALL {
        rows.extend(poll(plan, kind));
    }
    if let Some(response) = plan.cycle().alarms() {
        let kind = Kind {
            frame: format!("alarms, {} in two cycles", config.bus.alarm_burst),
            period_us: 2 * config.cycle_us,
            jitter_us: 0,
            response,
        };
        let frames = axes.iter().map(|axis| {
            let id = axis.drive.can_id(FunctionCode::DriveError);
            (id, frames::alarm_bits(axis))
        });
        rows.push(kind.row(config, frames));
    }
    rows
}

fn set_points(plan: &BusPlan<'_>) -> Vec<Row> {
    let config = plan.config();
    let row = |(index, axis): (usize, &AxisConfig)| {
        let kind = Kind {
            frame: format!("set-point of drive {}", axis.drive),
            period_us: config.cycle_us,
            jitter_us: config.bus.release_jitter_us,
            response: plan.set_point(index)?,
        };
        let id = axis.drive.can_id(FunctionCode::GoRelativePosPd);
        Some(kind.row(config, core::iter::once((id, frames::set_point_bits(axis)))))
    };
    plan.axes().iter().enumerate().filter_map(row).collect()
}

/// Request and reply of one poll, over all drives that are asked.
fn poll(plan: &BusPlan<'_>, kind: PollKind) -> Vec<Row> {
    let config = plan.config();
    let asked = plan
        .axes()
        .iter()
        .filter(|axis| axis.polls.of(kind).is_some());
    let period_us = asked.clone().filter_map(|axis| axis.polls.of(kind)).min();
    let (Some(period_us), Some(request), Some(reply)) =
        (period_us, plan.cycle().requests(), plan.cycle().replies())
    else {
        return Vec::new();
    };
    let id = |axis: &AxisConfig| axis.drive.can_id(kind.reply_kind().function());
    let us = |bits| config.bus.bit_rate.us_covering(bits);
    let requests = Kind {
        frame: format!("{kind} requests"),
        period_us,
        jitter_us: config.bus.release_jitter_us,
        response: request,
    };
    let replies = Kind {
        frame: format!("{kind} replies"),
        period_us,
        jitter_us: us(plan.cycle().reply_jitter_bits()),
        response: reply,
    };
    vec![
        requests.row(
            config,
            asked
                .clone()
                .map(|axis| (id(axis), frames::poll_bits(axis, kind))),
        ),
        replies.row(
            config,
            asked.map(|axis| (id(axis), frames::reply_bits(axis.drive, kind))),
        ),
    ]
}

/// The rows for people.
pub(super) fn of(plan: &BusPlan<'_>) -> Table {
    let mut table = Table::new();
    table.load_style(UTF8_BORDERS_ONLY).set_header([
        "frame",
        "id",
        "worst\nbits",
        "period\nus",
        "jitter\nus",
        "response\nus",
        "deadline\nus",
        "",
    ]);
    for row in rows(plan) {
        let response = row.response_us.map_or("-".to_owned(), |us| us.to_string());
        table.add_row([
            row.frame,
            if row.first_id == row.last_id {
                format!("{:03X}", row.first_id)
            } else {
                format!("{:03X}..{:03X}", row.first_id, row.last_id)
            },
            row.worst_bits.to_string(),
            row.period_us.to_string(),
            row.jitter_us.to_string(),
            response,
            row.deadline_us.to_string(),
            if row.in_time { "in time" } else { "LATE" }.to_owned(),
        ]);
    }
    for column in table.column_iter_mut().skip(2).take(5) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    table
}
