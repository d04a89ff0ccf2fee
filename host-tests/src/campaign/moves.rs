//! Motions that drives make by themselves: what is drawn of them, and how the application lets them happen.

use can_motion::{AxisSnapshot, AxisState, DriveMove, GroupId, Instant, Limits, ServoMaster};
use dyn_can::{MaxAcceleration, MaxSpeed, ParamGroup2};

use super::draw::Draw;
use super::scenario::{MOST_AXES, MoveOrder, Scenario};

/// The streams of a group must have ended by then, or its moves are not made.
const HOLD_LIMIT_US: u64 = 400_000;
/// From the earliest move to the calm end of a run: the longest move, and its time to settle.
const LAST_US: u64 = 1_300_000;
const FIRST_US: u64 = 250_000;
/// Other draws of a scenario stay what they are.
const SALT: u64 = 0x6D6F_7665;

/// Draws the curves of the drives and the moves of a run; in a half of the runs there are none.
pub(super) fn draw(scenario: &mut Scenario) {
    let mut draw = Draw::new(scenario.seed ^ SALT);
    if !draw.chance(50) || scenario.calm_from_us < FIRST_US + LAST_US {
        return;
    }
    for axis in &mut scenario.axes {
        let curve = curve_within(&axis.config.limits);
        axis.config.drive_curve = Some(curve);
        axis.curve = Some(curve);
    }
    let count = draw.between(1, 2);
    let groups = u64::from(scenario.groups);
    let last_us = scenario.calm_from_us - LAST_US;
    let mut moves: Vec<MoveOrder> = (0..count)
        .map(|_| MoveOrder {
            at_us: draw.between(FIRST_US, last_us),
            group: GroupId(draw.between(0, groups - 1) as u8),
            by_trigger: draw.chance(50),
            is_relative: draw.chance(50),
            distances_counts: scenario
                .axes
                .iter()
                .map(|_| draw.between(0, 6_000) as i32 - 3_000)
                .collect(),
            stop_after_us: draw.chance(30).then(|| draw.between(1, 300) * 1_000),
        })
        .collect();
    moves.sort_by_key(|order| order.at_us);
    scenario.moves = moves;
}

/// The fastest curve within the limits of an axis: a slower one would slow down how its drive follows set-points, too.
fn curve_within(limits: &Limits) -> ParamGroup2 {
    // Counts a millisecond for (value + 3) squared, and a millisecond more in each for 1: manual section 7.4.1, at gear number 4096.
    const SPEED: f64 = 12.21 / 16.0 * 16_384.0 / 60_000.0;
    const ACCELERATION: f64 = 635.78 * 16_384.0 / 60.0 * 1e-6;
    let speed = (f64::from(limits.max_step.get()) / SPEED).sqrt() - 3.5;
    let change = f64::from(limits.max_step_change.per_256_cycles()) / 256.0;
    let value = |real: f64| real.floor().clamp(1.0, 127.0) as i32;
    ParamGroup2 {
        max_speed: MaxSpeed::new(value(speed)).expect("1..=127"),
        max_acceleration: MaxAcceleration::new(value(change / ACCELERATION * 0.98))
            .expect("1..=127"),
    }
}

/// What one axis was told, in the counts of the master.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Asked {
    pub(super) start: i64,
    pub(super) end: i64,
    pub(super) is_relative: bool,
    pub(super) by_trigger: bool,
}

/// How far the moves of a group are.
#[derive(Debug, Clone, Copy)]
enum Mission {
    /// The stream is ending.
    Stopping { order: usize },
    /// The drives were told.
    Moving { stop_at_us: Option<u64> },
}

/// The moves of the groups of one run.
#[derive(Debug)]
pub(super) struct Missions {
    next: usize,
    of_group: Vec<Option<Mission>>,
    /// What was told in this cycle.
    asked: Vec<(usize, Asked)>,
}

impl Missions {
    pub(super) fn new(scenario: &Scenario) -> Self {
        Self {
            next: 0,
            of_group: vec![None; usize::from(scenario.groups)],
            asked: Vec::new(),
        }
    }

    /// What was told since the last call.
    pub(super) fn take_asked(&mut self) -> Vec<(usize, Asked)> {
        core::mem::take(&mut self.asked)
    }

    /// Moves whose time has come: the stream of their group ends.
    pub(super) fn begin(
        &mut self,
        scenario: &Scenario,
        master: &mut ServoMaster<MOST_AXES>,
        now: Instant,
    ) {
        while let Some(order) = scenario
            .moves
            .get(self.next)
            .filter(|o| o.at_us <= now.as_us())
        {
            let mission = &mut self.of_group[usize::from(order.group.0)];
            if mission.is_none() {
                *mission = Some(Mission::Stopping { order: self.next });
                master.stop(now, order.group);
            }
            self.next += 1;
        }
    }

    /// A fault ends the moves of its group.
    pub(super) fn forget(&mut self, group: GroupId) {
        self.of_group[usize::from(group.0)] = None;
    }

    /// One cycle of a group without a fault; true while the group has moves to make.
    pub(super) fn go_on(
        &mut self,
        scenario: &Scenario,
        master: &mut ServoMaster<MOST_AXES>,
        (group, axes): (GroupId, &[AxisSnapshot]),
        now: Instant,
    ) -> bool {
        let place = usize::from(group.0);
        let Some(mission) = self.of_group[place] else {
            return false;
        };
        let mut own = axes.iter().filter(|axis| axis.group == group);
        self.of_group[place] = match mission {
            Mission::Stopping { order } => {
                let order = &scenario.moves[order];
                let late = now.as_us() > order.at_us + HOLD_LIMIT_US;
                if own.all(|axis| axis.state == AxisState::Holding) {
                    self.tell(order, master, axes, now)
                } else {
                    (!late).then_some(mission)
                }
            }
            Mission::Moving { stop_at_us } => {
                let moves = own.any(|axis| axis.facts.has_own_move());
                let is_due = stop_at_us.is_some_and(|at_us| at_us <= now.as_us());
                if is_due {
                    master.stop(now, group);
                }
                let stop_at_us = stop_at_us.filter(|_| !is_due);
                moves.then_some(Mission::Moving { stop_at_us })
            }
        };
        self.of_group[place].is_some()
    }

    /// Tells the drives of a group; a refusal ends it, because nothing has moved.
    fn tell(
        &mut self,
        order: &MoveOrder,
        master: &mut ServoMaster<MOST_AXES>,
        axes: &[AxisSnapshot],
        now: Instant,
    ) -> Option<Mission> {
        let moves: Vec<(usize, DriveMove, Asked)> = axes
            .iter()
            .enumerate()
            .filter(|(_, axis)| axis.group == order.group)
            .map(|(index, axis)| {
                let distance = order.distances_counts[index];
                let end = axis.sent_counts + distance;
                let wanted = if order.is_relative {
                    DriveMove::By(distance)
                } else {
                    DriveMove::To(end)
                };
                let asked = Asked {
                    start: axis.sent_counts.into(),
                    end: end.into(),
                    is_relative: order.is_relative,
                    by_trigger: order.by_trigger,
                };
                (index, wanted, asked)
            })
            .collect();
        if order.by_trigger {
            let together: Vec<_> = moves
                .iter()
                .map(|(index, wanted, _)| (*index, *wanted))
                .collect();
            master.start_moves(now, &together).ok()?;
            self.asked
                .extend(moves.iter().map(|(index, _, asked)| (*index, *asked)));
        } else {
            for (index, wanted, asked) in moves {
                if master.start_move(now, index, wanted).is_ok() {
                    self.asked.push((index, asked));
                }
            }
        }
        let stop_at_us = order.stop_after_us.map(|us| now.as_us() + us);
        Some(Mission::Moving { stop_at_us })
    }
}
