//! Draws a scenario from a seed.

use core::num::NonZeroU64;

use crate::rig::axis_config;
use can_motion::plan::{self, BusPlan, BusSetup, ResponseWindow};
use can_motion::{
    AxisConfig, GroupId, Limits, MasterConfig, PollPeriods, Reaction, Reactions, ReadBackScale,
    StepChange, Timeouts, Travel,
};
use drive_sim::{ResponseDelay, TxOrder};
use dyn_can::{DriveId, FunctionCode, Revision, StepLimit};

use super::draw::Draw;
use super::injection::{Injection, Kind};
use super::moves;
use super::path::Path;
use super::scenario::{AxisPlan, Command, MOST_AXES, Order, Scenario, ServiceTiming};

/// Axes of a scenario with two groups at most.
const MOST_AXES_IN_GROUPS: usize = 5;

/// The drives wait this long after power-on; the master a little longer.
pub(super) const DRIVE_POWER_ON_US: u64 = 5_000;

/// Nothing moves and nothing is injected in the last part of a run, so that drift is judged.
const CALM_US: u64 = 700_000;

/// Earliest motion and earliest injection: axes may still be starting up.
const FIRST_US: u64 = 100_000;

impl Scenario {
    /// The scenario of a seed.
    pub fn from_seed(seed: u64) -> Self {
        let mut draw = Draw::new(seed);
        let duration_us = draw.between(2_000, 5_000).min(draw.between(2_000, 5_000)) * 1_000;
        let calm_from_us = duration_us - CALM_US;
        let count = draw.between(3, MOST_AXES as u64) as usize;
        let groups = draw.between(1, 2) as u8;
        // One group is enabled while the other streams: the plan has room for that on a bus with fewer axes.
        let count = if groups > 1 {
            count.min(MOST_AXES_IN_GROUPS)
        } else {
            count
        };
        let reply_us = draw.between_u32(5_000, 12_000);
        let axes = draw_axes(&mut draw, count, groups, calm_from_us);
        let orders = draw_orders(&mut draw, groups, calm_from_us);
        let injections = draw_injections(&mut draw, count, calm_from_us, reply_us);
        let tx_order = draw.pick(&[TxOrder::Fifo, TxOrder::ByIdentifier]);
        let mut scenario = Self {
            seed,
            duration_us,
            calm_from_us,
            tx_order,
            service: if draw.chance(25) {
                ServiceTiming::EveryUs(draw.pick(&[50, 100, 250]))
            } else {
                ServiceTiming::EachFrame
            },
            master: admitted(
                &axes,
                MasterConfig {
                    requests_per_cycle: draw.between(1, 2) as u8,
                    timeouts: Timeouts {
                        power_on_us: 10_000,
                        reply_us,
                        arrival_us: 100_000,
                        standstill_us: 20_000,
                        ..Timeouts::DEFAULT
                    },
                    bus: bus_of(&axes, tx_order),
                    ..MasterConfig::DEFAULT
                },
            ),
            axes,
            groups,
            orders,
            recover_after_us: draw.chance(75).then(|| draw.between(1, 80) * 1_000),
            injections,
            moves: Vec::new(),
        };
        moves::draw(&mut scenario);
        scenario
    }
}

/// The bus as the master should know it.
fn bus_of(axes: &[AxisPlan], tx_order: TxOrder) -> BusSetup {
    let delays = || axes.iter().map(|axis| axis.response_delay);
    let us = |ns: u64| u32::try_from(ns.div_ceil(1_000)).expect("drives answer within seconds");
    BusSetup {
        order: match tx_order {
            TxOrder::Fifo => plan::TxOrder::Fifo,
            TxOrder::ByIdentifier => plan::TxOrder::Identifier,
        },
        response: ResponseWindow {
            min_us: us(delays().map(ResponseDelay::min_ns).min().unwrap_or(0)),
            max_us: us(delays().map(ResponseDelay::max_ns).max().unwrap_or(0)),
        },
        ..BusSetup::DEFAULT
    }
}

/// The configuration as it was drawn, or with one request a cycle where the bus has no room for two.
fn admitted(axes: &[AxisPlan], drawn: MasterConfig) -> MasterConfig {
    let axes: Vec<AxisConfig> = axes.iter().map(|axis| axis.config).collect();
    let requests_per_cycle = match BusPlan::new(&drawn, &axes).check() {
        Ok(()) => drawn.requests_per_cycle,
        Err(_) => 1,
    };
    MasterConfig {
        requests_per_cycle,
        ..drawn
    }
}

fn draw_axes(draw: &mut Draw, count: usize, groups: u8, calm_from_us: u64) -> Vec<AxisPlan> {
    let mut ids: Vec<DriveId> = Vec::new();
    while ids.len() < count {
        let id = DriveId::new(draw.between(1, 63) as i32).expect("1..=63 are drive ids");
        if !ids.contains(&id) {
            ids.push(id);
        }
    }
    ids.sort_unstable();
    let reactions = draw_reactions(draw);
    let plans = ids.iter().enumerate().map(|(index, &drive)| {
        let group = match index {
            // Every group has an axis.
            0 => GroupId(0),
            1 => GroupId(groups - 1),
            _ => GroupId(draw.between(0, u64::from(groups) - 1) as u8),
        };
        draw_axis(draw, drive, group, reactions, calm_from_us)
    });
    plans.collect()
}

fn draw_reactions(draw: &mut Draw) -> Reactions {
    let mut reactions = Reactions::DEFAULT;
    if draw.chance(30) {
        reactions.alarm = Reaction::Disable;
    }
    if draw.chance(30) {
        reactions.lost = Reaction::Halt;
    }
    if draw.chance(30) {
        reactions.position = draw.pick(&[Reaction::RampDown, Reaction::Disable]);
    }
    reactions
}

fn draw_axis(
    draw: &mut Draw,
    drive: DriveId,
    group: GroupId,
    reactions: Reactions,
    calm_from_us: u64,
) -> AxisPlan {
    let revision = draw.pick(&[Revision::V1_6A, Revision::V1_2A]);
    let most_counts = draw.real(4.0, 60.0);
    let fine_read_back = draw.chance(30);
    let max_step = (most_counts * draw.real(1.5, 4.0)) as i32 + 2;
    let delay_us = draw.between(100, 2_000);
    let spread_us = delay_us * draw.between(0, 40) / 100;
    let window = ResponseDelay::between(
        (delay_us - spread_us) * 1_000,
        (delay_us + spread_us) * 1_000,
    );
    let from_us = FIRST_US + draw.between(0, 100_000);
    AxisPlan {
        config: AxisConfig {
            group,
            limits: Limits {
                max_step: StepLimit::new(max_step).expect("a step of at most 242 counts"),
                max_step_change: StepChange::from_counts(draw.between_u32(1, 20))
                    .expect("at most 20 counts"),
                travel: Travel {
                    min_counts: -(1 << 24),
                    max_counts: 1 << 24,
                },
                backlog_counts: draw.between_u32(300, 5_000),
                following_error_counts: draw.between_u32(1_500, 8_000),
                drift_tolerance_counts: draw.between_u32(0, 16),
            },
            polls: draw_polls(draw),
            read_back: if fine_read_back {
                ReadBackScale::movement_positions(axis_config(drive).gear)
            } else {
                ReadBackScale::COMMAND_COUNTS
            },
            reactions,
            ..axis_config(drive)
        },
        revision,
        fine_read_back,
        start_counts: draw.between(0, 2_000_000) as i64 - 1_000_000,
        response_delay: window.expect("the spread is below the delay"),
        delay_seed: draw.seed(),
        curve: None,
        path: Path::draw(draw, from_us, calm_from_us, most_counts),
    }
}

fn draw_polls(draw: &mut Draw) -> PollPeriods {
    let mut sometimes = |percent| {
        draw.chance(percent)
            .then(|| draw.between_u32(20, 100) * 1_000)
    };
    PollPeriods {
        torque_us: sometimes(30),
        speed_us: sometimes(20),
        counter_us: sometimes(40),
        status_us: Some(draw.between_u32(20, 50) * 1_000),
        position_us: Some(draw.between_u32(20, 50) * 1_000),
    }
}

fn draw_orders(draw: &mut Draw, groups: u8, calm_from_us: u64) -> Vec<Order> {
    let count = if draw.chance(40) {
        draw.between(1, 2)
    } else {
        0
    };
    let mut orders: Vec<Order> = (0..count)
        .map(|_| Order {
            at_us: draw.between(FIRST_US + 100_000, calm_from_us),
            group: GroupId(draw.between(0, u64::from(groups) - 1) as u8),
            command: draw.pick(&[Command::Stop, Command::Halt, Command::Disable]),
            rest_us: draw.between(1, 150) * 1_000,
        })
        .collect();
    orders.sort_unstable_by_key(|order| order.at_us);
    orders
}

fn draw_injections(
    draw: &mut Draw,
    axes: usize,
    calm_from_us: u64,
    reply_us: u32,
) -> Vec<Injection> {
    let count = draw.between(0, 4);
    let mut injections: Vec<Injection> = (0..count)
        .map(|_| Injection {
            at_us: draw.between(FIRST_US, calm_from_us),
            kind: draw_kind(draw, axes, u64::from(reply_us)),
        })
        .collect();
    injections.sort_unstable_by_key(|injection| injection.at_us);
    injections
}

fn draw_kind(draw: &mut Draw, axes: usize, reply_us: u64) -> Kind {
    let axis = draw.between(0, axes as u64 - 1) as usize;
    let function = draw.pick(&[FunctionCode::ReadDriveStatus, FunctionCode::GeneralRead]);
    match draw.between(0, 19) {
        0 => Kind::Alarm {
            axis,
            repeat_us: None,
        },
        1 => Kind::Alarm {
            axis,
            repeat_us: NonZeroU64::new(draw.between(500, 5_000)),
        },
        2 => Kind::Silence {
            axis,
            deaf: draw.chance(50),
            for_us: draw.chance(60).then(|| draw.between(1, 200) * 1_000),
        },
        3 => Kind::DropReply { axis },
        // Within the timeout, or behind it but within the quarantine: no protocol can tell a reply that is later still from the
        // reply to the next request.
        4 => Kind::DelayReply {
            axis,
            by_us: draw.between(500, reply_us / 2),
        },
        5 => Kind::DelayReply {
            axis,
            by_us: draw.between(reply_us, reply_us * 3 / 2),
        },
        6 => Kind::DoubleReply { axis },
        7 => Kind::ShortReply { axis },
        8 => Kind::LongReply { axis },
        9 => Kind::DisableItself { axis },
        10 => Kind::PowerCycle {
            axis,
            off_us: draw.between(0, 50_000),
        },
        11 => Kind::Corrupt {
            frames: draw.between_u32(1, 10),
            at_bit: draw.between_u32(2, 60),
        },
        12 => Kind::RepeatSetPoint { axis },
        13 => Kind::RepeatReply { axis, function },
        14 => Kind::RepeatRequest { axis, function },
        15 => Kind::LoseSetPoint { axis },
        16 => Kind::LoseReply { axis, function },
        17 => draw_outage(draw),
        18 => Kind::MissCycles {
            cycles: draw.between(1, 20),
        },
        _ => Kind::Collide { axis },
    }
}

fn draw_outage(draw: &mut Draw) -> Kind {
    // Below what the master bridges, or far beyond it.
    let for_us = if draw.chance(50) {
        draw.between(1_000, 20_000)
    } else {
        draw.between(30_000, 1_200_000)
    };
    if draw.chance(40) {
        Kind::Block { for_us }
    } else if draw.chance(50) {
        Kind::Unplug { for_us }
    } else {
        Kind::Disturb {
            for_us: draw.between(2_000, 10_000),
        }
    }
}
