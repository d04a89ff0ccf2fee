//! The plan frame by frame, as `motionctl plan --json` has it.

use can_motion::plan::analysis::Response;
use can_motion::plan::{BusPlan, frames};
use can_motion::{AxisConfig, MasterConfig, PollKind};
use dyn_can::FunctionCode;
use serde::Serialize;

/// Frames of one kind.
#[derive(Serialize)]
pub(super) struct Row {
    frame: String,
    first_id: u16,
    last_id: u16,
    worst_bits: u16,
    period_us: u32,
    jitter_us: u32,
    response_us: Option<u32>,
    deadline_us: u32,
    in_time: bool,
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
