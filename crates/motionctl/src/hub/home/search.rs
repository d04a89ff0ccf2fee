//! The homing with its wheel, cycle by cycle.

use can_motion::Instant;
use can_motion::wheel::WheelSnapshot;
use homing::{Abort, Homing, Inputs, Progress, Reading};
use zlac8030l::objects;

use super::Ended;
use super::plan::{CYCLE_US, Plan};
use super::switch::Switch;
use crate::home::HomeError;
use crate::hub::bus::Bus;
use crate::hub::error::HubError;
use crate::hub::station::WheelStation;
use crate::interrupt;

/// Enables, searches, switches off.
pub(super) fn search(
    bus: &mut Bus,
    plan: &Plan,
    switch: Option<&Switch>,
) -> Result<Ended, HubError> {
    let mut station = WheelStation::new(bus.link(), &[plan.wheel], CYCLE_US)?;
    let sought = seek(&mut station, plan, switch);
    let (ended, _) = station.end(sought)?;
    Ok(ended)
}

/// One search; the first Ctrl-C slows it down, the second one leaves that to the end of the station.
fn seek(
    station: &mut WheelStation<'_>,
    plan: &Plan,
    switch: Option<&Switch>,
) -> Result<Ended, HubError> {
    station.bring_up()?;
    let sent = station.snapshots().next().map_or(0, |wheel| wheel.sent);
    let mut homing = Homing::new(plan.config, sent).map_err(HomeError::Refusal)?;
    let mut bad_line = None;
    loop {
        let now = station.now();
        let level = switch.and_then(|switch| switch.level(station));
        if let Some(text) = switch.and_then(Switch::fault) {
            bad_line = Some(text);
            homing.cancel();
        }
        if interrupt::requests() > 0 {
            homing.cancel();
        }
        let mut progress = None;
        let mut is_refused = false;
        station.cycle(|master, _| {
            let Some(wheel) = master.snapshot(0) else {
                return;
            };
            let next = homing.cycle(now.as_us(), &inputs(&wheel, plan, level));
            if let Progress::Target(counts) = next {
                is_refused = master.set_target(0, counts).is_err();
            }
            progress = Some(next);
        })?;
        if let Some((node, fault)) = station.first_fault() {
            return Err(HubError::WheelFault { node, fault });
        }
        if is_refused {
            let values = plan.wheel.limits.values;
            return Err(HubError::Input(format!(
                "the search left {}..={} counts, within which its options keep it: it was stopped",
                values.min, values.max
            )));
        }
        match (progress, bad_line.take()) {
            (Some(Progress::Target(_)), line) if interrupt::requests() < 2 => bad_line = line,
            (_, Some(text)) => return Err(HomeError::SwitchLine { text }.into()),
            (Some(end), None) => return Ok(ended(end)),
            (None, None) => return Err(HubError::NothingGetsOut),
        }
    }
}

fn ended(progress: Progress) -> Ended {
    match progress {
        Progress::Found(home) => Ended::Found(home),
        Progress::Failed(Abort::Cancelled) | Progress::Target(_) => Ended::Interrupted,
        Progress::Failed(abort) => Ended::Failed(abort),
    }
}

/// The same for an axis that is not enabled: it only looks.
pub(super) fn stand(bus: &mut Bus, plan: &Plan) -> Result<Ended, HubError> {
    let sent_counts = bus.read(plan.node, objects::ACTUAL_POSITION)?;
    let mut homing = Homing::new(plan.config, sent_counts).map_err(HomeError::Refusal)?;
    loop {
        if interrupt::requests() > 0 {
            homing.cancel();
        }
        let value = bus.read(plan.node, objects::ACTUAL_POSITION)?;
        let now_us = (bus.seconds() * 1e6) as u64;
        let inputs = Inputs {
            sent_counts,
            position: Some(Reading {
                value,
                at_us: now_us,
            }),
            torque_permille: None,
            switch: None,
        };
        match homing.cycle(now_us, &inputs) {
            Progress::Target(_) => bus.wait(CYCLE_US)?,
            end => return Ok(ended(end)),
        }
    }
}

fn inputs(wheel: &WheelSnapshot, plan: &Plan, switch: Option<Reading<bool>>) -> Inputs {
    let at = |at: Instant| at.as_us();
    let read = &wheel.feedback;
    Inputs {
        sent_counts: wheel.sent,
        position: read.position_counts.map(|position| Reading {
            value: position.value,
            at_us: at(position.at),
        }),
        torque_permille: read.torque.map(|torque| Reading {
            value: plan.permille(torque.value),
            at_us: at(torque.at),
        }),
        switch,
    }
}
