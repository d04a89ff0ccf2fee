//! The homing with its drive, cycle by cycle.

use can_motion::{AxisSnapshot, AxisState, Instant};
use dyn_can::DriveId;
use homing::{Abort, Home, Homing, Inputs, Progress, Reading};

use super::arguments::Arguments;
use super::error::HomeError;
use super::plan::Plan;
use super::switch_lines::SwitchLines;
use crate::drives::DrivesError;
use crate::interrupt;
use crate::link::Link;
use crate::station::Station;

/// Time for a drive to be checked where nothing is enabled.
const CHECK_LIMIT_US: u64 = 10_000_000;

/// How a search ended, and whether the drive is still enabled, as it was before.
#[derive(Debug, Clone, Copy)]
pub(super) enum Ended {
    Found(Home, bool),
    Failed(Abort, bool),
    Interrupted(bool),
}

/// Enables, searches, disables.
pub(super) fn search(
    link: &mut Link,
    arguments: &Arguments,
    plan: &Plan,
    lines: Option<&SwitchLines>,
) -> Result<Ended, HomeError> {
    let mut station =
        Station::new(link, &[plan.axis], plan.cycle_us).map_err(DrivesError::Config)?;
    let mut bad_line = None;
    let ended = if arguments.search.moves() {
        station
            .bring_up()
            .map_err(DrivesError::BringUp)
            .and_then(|()| seek(&mut station, arguments, plan, lines, &mut bad_line))
    } else {
        stand(&mut station, arguments, plan)
    };
    let (progress, end) = DrivesError::after_shut_down(ended, &mut station)?;
    if let Some(text) = bad_line {
        return Err(HomeError::SwitchLine { text });
    }
    let enabled = !end.left_on.is_empty();
    Ok(match progress {
        Progress::Found(home) => Ended::Found(home, enabled),
        Progress::Failed(Abort::Cancelled) | Progress::Target(_) => Ended::Interrupted(enabled),
        Progress::Failed(abort) => Ended::Failed(abort, enabled),
    })
}

/// One search; the first Ctrl-C slows it down, the second one leaves that to the shut-down.
fn seek(
    station: &mut Station<'_>,
    arguments: &Arguments,
    plan: &Plan,
    lines: Option<&SwitchLines>,
    bad_line: &mut Option<String>,
) -> Result<Progress, DrivesError> {
    let mut homing = begin(station, arguments, plan)?;
    loop {
        let now = station.now();
        let level = lines.and_then(|lines| lines.level(now));
        if let Some(text) = lines.and_then(SwitchLines::fault) {
            *bad_line = Some(text);
            homing.cancel();
        }
        if interrupt::requests() > 0 {
            homing.cancel();
        }
        let mut progress = None;
        let mut target = Ok(());
        station.cycle(|master, _| {
            let Some(axis) = master.snapshot(0) else {
                return;
            };
            let inputs = inputs(&axis, arguments, plan, level);
            let next = homing.cycle(now.as_us(), &inputs);
            if let Progress::Target(counts) = next {
                target = master.set_target(0, counts);
            }
            progress = Some(next);
        })?;
        check(station)?;
        target.map_err(|error| fault(arguments.drive, error.to_string()))?;
        match progress {
            Some(Progress::Target(_)) if interrupt::requests() < 2 => {}
            Some(end) => return Ok(end),
            None => return Err(fault(arguments.drive, "the master has no axis".to_owned())),
        }
    }
}

/// The same for an axis that is not enabled: it only looks.
fn stand(
    station: &mut Station<'_>,
    arguments: &Arguments,
    plan: &Plan,
) -> Result<Progress, DrivesError> {
    let start = station.now();
    let is_checked =
        |axis: &AxisSnapshot| matches!(axis.state, AxisState::Ready | AxisState::FoundOn);
    while !station.snapshots().any(|axis| is_checked(&axis)) {
        station.cycle(|_, _| {})?;
        check(station)?;
        if interrupt::requests() > 0 {
            return Err(DrivesError::Interrupted);
        }
        if station.now().us_since(start) > CHECK_LIMIT_US {
            return Err(DrivesError::Incomplete {
                drive: arguments.drive.into(),
            });
        }
    }
    let mut homing = begin(station, arguments, plan)?;
    loop {
        station.cycle(|_, _| {})?;
        check(station)?;
        if interrupt::requests() > 0 {
            homing.cancel();
        }
        let now = station.now();
        let Some(axis) = station.master().snapshot(0) else {
            return Err(fault(arguments.drive, "the master has no axis".to_owned()));
        };
        match homing.cycle(now.as_us(), &inputs(&axis, arguments, plan, None)) {
            Progress::Target(_) => {}
            end => return Ok(end),
        }
    }
}

fn begin(
    station: &mut Station<'_>,
    arguments: &Arguments,
    plan: &Plan,
) -> Result<Homing, DrivesError> {
    let sent = station
        .master()
        .snapshot(0)
        .map_or(0, |axis| axis.sent_counts);
    Homing::new(plan.config, sent).map_err(|refusal| fault(arguments.drive, refusal.to_string()))
}

fn check(station: &mut Station<'_>) -> Result<(), DrivesError> {
    match station.first_fault() {
        Some((drive, fault)) => Err(DrivesError::DriveFault { drive, fault }),
        None => Ok(()),
    }
}

fn inputs(
    axis: &AxisSnapshot,
    arguments: &Arguments,
    plan: &Plan,
    switch: Option<Reading<bool>>,
) -> Inputs {
    let scale = arguments.axes.scale(plan.gear);
    let reading = |value, at: Instant| Reading {
        value,
        at_us: at.as_us(),
    };
    let read = &axis.feedback;
    Inputs {
        sent_counts: axis.sent_counts,
        position: read.position.and_then(|position| {
            let counts = scale.to_command_counts(position.value)?;
            Some(reading(counts, position.at))
        }),
        torque_permille: read.torque.map(|torque| Reading {
            // The codec has applied the sign of the revision; beyond the scale is beyond every limit.
            value: (torque.value.of_peak() * 1_000.0).round() as i16,
            at_us: torque.at.as_us(),
        }),
        switch,
    }
}

fn fault(drive: DriveId, reason: String) -> DrivesError {
    DrivesError::Fault {
        drive: drive.into(),
        reason,
    }
}
