//! A simple application: enables what is ready, follows its paths, gives some commands, and recovers after faults.

use can_motion::{AxisSnapshot, AxisState, GroupId, Instant, ServoMaster};

use super::moves::{Asked, Missions};
use super::scenario::MOST_AXES;
use super::scenario::{Command, Scenario};

/// How often one group is cleared before the application gives up.
const MOST_CLEARS: u32 = 4;

/// What the application did in this cycle that lets a group move again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Permission {
    /// `enable` was accepted.
    Enable(GroupId),
    /// `resume` was accepted.
    Resume(GroupId),
}

#[derive(Debug, Clone, Copy, Default)]
struct GroupPlan {
    rest_until_us: u64,
    clear_at_us: Option<u64>,
    clears: u32,
}

/// The application of one run.
#[derive(Debug)]
pub(super) struct Application {
    groups: Vec<GroupPlan>,
    next_order: usize,
    missions: Missions,
    /// Where each path starts, in command counts; `None` while the axis does not stream.
    bases: Vec<Option<i32>>,
}

impl Application {
    pub(super) fn new(scenario: &Scenario) -> Self {
        Self {
            groups: vec![GroupPlan::default(); usize::from(scenario.groups)],
            next_order: 0,
            missions: Missions::new(scenario),
            bases: vec![None; scenario.axes.len()],
        }
    }

    /// One cycle. `repair` is told the axes whose group is about to be cleared.
    pub(super) fn act(
        &mut self,
        scenario: &Scenario,
        master: &mut ServoMaster<MOST_AXES>,
        now: Instant,
        mut repair: impl FnMut(usize),
        permissions: &mut Vec<Permission>,
    ) {
        self.give_orders(scenario, master, now);
        self.missions.begin(scenario, master, now);
        let axes: Vec<AxisSnapshot> = (0..scenario.axes.len())
            .filter_map(|axis| master.snapshot(axis))
            .collect();
        for group in scenario.group_ids() {
            let of_group: Vec<&AxisSnapshot> =
                axes.iter().filter(|axis| axis.group == group).collect();
            if of_group.iter().any(|axis| axis.fault.is_some()) {
                self.missions.forget(group);
                if self.plan_recovery(scenario, group, now) {
                    (0..axes.len())
                        .filter(|&axis| axes[axis].group == group)
                        .for_each(&mut repair);
                }
                self.recover(master, group, now);
            } else if !self.missions.go_on(scenario, master, (group, &axes), now) {
                self.set_going(master, group, &of_group, now, permissions);
            }
        }
        self.set_targets(scenario, master, now);
    }

    /// What the drives were told in this cycle.
    pub(super) fn take_asked(&mut self) -> Vec<(usize, Asked)> {
        self.missions.take_asked()
    }

    fn give_orders(
        &mut self,
        scenario: &Scenario,
        master: &mut ServoMaster<MOST_AXES>,
        now: Instant,
    ) {
        while let Some(order) = scenario
            .orders
            .get(self.next_order)
            .filter(|order| order.at_us <= now.as_us())
        {
            self.next_order += 1;
            match order.command {
                Command::Stop => master.stop(now, order.group),
                Command::Halt => master.halt(now, order.group),
                Command::Disable => master.disable(now, order.group),
            }
            self.groups[usize::from(order.group.0)].rest_until_us = now.as_us() + order.rest_us;
        }
    }

    /// Returns true when a recovery has just been planned.
    fn plan_recovery(&mut self, scenario: &Scenario, group: GroupId, now: Instant) -> bool {
        let plan = &mut self.groups[usize::from(group.0)];
        let Some(wait_us) = scenario.recover_after_us else {
            return false;
        };
        let at_us = now.as_us() + wait_us;
        if plan.clear_at_us.is_some() || plan.clears >= MOST_CLEARS || at_us > scenario.calm_from_us
        {
            return false;
        }
        plan.clears += 1;
        plan.clear_at_us = Some(at_us);
        true
    }

    fn recover(&mut self, master: &mut ServoMaster<MOST_AXES>, group: GroupId, now: Instant) {
        let plan = &mut self.groups[usize::from(group.0)];
        if plan.clear_at_us.is_some_and(|at_us| at_us <= now.as_us())
            && master.clear(now, group).is_ok()
        {
            plan.clear_at_us = None;
        }
    }

    fn set_going(
        &mut self,
        master: &mut ServoMaster<MOST_AXES>,
        group: GroupId,
        axes: &[&AxisSnapshot],
        now: Instant,
        permissions: &mut Vec<Permission>,
    ) {
        if now.as_us() < self.groups[usize::from(group.0)].rest_until_us {
            return;
        }
        let is_in = |states: &[AxisState]| axes.iter().all(|axis| states.contains(&axis.state));
        if is_in(&[AxisState::Holding]) {
            let resumed = master.resume(now, group).is_ok();
            permissions.extend(resumed.then_some(Permission::Resume(group)));
        } else if is_in(&[AxisState::Ready, AxisState::Holding]) {
            let enabled = master.enable(now, group).is_ok();
            permissions.extend(enabled.then_some(Permission::Enable(group)));
        } else if is_in(&[AxisState::Ready, AxisState::Holding, AxisState::FoundOn]) {
            self.take_found(master, group, now);
        }
    }

    /// Drives that came up with their servo on are taken over by one half of the groups and switched off by the other.
    fn take_found(&self, master: &mut ServoMaster<MOST_AXES>, group: GroupId, now: Instant) {
        if group.0.is_multiple_of(2) {
            // The next cycle tries again.
            let _ = master.adopt(now, group);
        } else {
            master.disable(now, group);
        }
    }

    fn set_targets(
        &mut self,
        scenario: &Scenario,
        master: &mut ServoMaster<MOST_AXES>,
        now: Instant,
    ) {
        for (index, plan) in scenario.axes.iter().enumerate() {
            let Some(axis) = master
                .snapshot(index)
                .filter(|axis| axis.state == AxisState::Streaming)
            else {
                self.bases[index] = None;
                continue;
            };
            let offset = plan.path.at(now.as_us());
            let base = *self.bases[index].get_or_insert(axis.target_counts - offset);
            // The axis streams and every path stays far within the travel.
            let _ = master.set_target(index, base + offset);
        }
    }
}
