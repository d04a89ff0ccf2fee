//! Steps there and back, and the positions meanwhile.

use can_motion::{Instant, Limits, PollPeriods, StepChange, Travel};
use dyn_can::{StepLimit, units};

use super::arguments::Arguments;
use crate::drives::DrivesError;
use crate::interrupt;
use crate::link::Link;
use crate::station::{Station, look};

/// Cycle of the set-points and of the position reads.
pub(super) const CYCLE_US: u32 = 2_000;
/// Bit times that a cycle has at least: a set-point, a request and a reply, and room.
pub(super) const CYCLE_BITS: u32 = 400;
/// Time before the first step.
const REST_US: u64 = 200_000;

/// A reading and what it should be, from where both were at the start: positions in counts, speeds in 0.1 r/min.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    /// Since the first step.
    pub(crate) at_ms: f64,
    pub(crate) set_point: i32,
    pub(crate) actual: i32,
}

/// What was measured.
pub(crate) struct Measured {
    pub(crate) samples: Vec<Sample>,
    /// Nobody stopped it.
    pub(crate) is_complete: bool,
}

/// Enables, steps, disables.
pub(super) fn measure(link: &mut Link, arguments: &Arguments) -> Result<Measured, DrivesError> {
    let drive = arguments.drive;
    let seen = look(link, arguments.axes, &[drive]).map_err(DrivesError::Look)?;
    let seen = seen.first().ok_or(DrivesError::Incomplete {
        drive: drive.into(),
    })?;
    let turn = f64::from(units::command_counts_per_turn(seen.gear));
    let step = (arguments.amplitude * turn).round() as i32;
    let cycle_us = CYCLE_US.max(link.bit_rate().us_covering(CYCLE_BITS));
    let polls = PollPeriods {
        status_us: Some(100_000),
        position_us: Some(cycle_us),
        ..PollPeriods::OFF
    };
    let axis = arguments
        .axes
        .axis(drive, seen.gear, limits(seen.position_counts, step), polls);
    let mut station = Station::new(link, &[axis], cycle_us).map_err(DrivesError::Config)?;
    let measured = station
        .bring_up()
        .map_err(DrivesError::BringUp)
        .and_then(|()| {
            steps(&mut station, arguments, step, |counts| {
                arguments.axes.scale(seen.gear).to_command_counts(counts)
            })
        });
    let (measured, _) = DrivesError::after_shut_down(measured, &mut station)?;
    Ok(measured)
}

/// A whole step in one frame, and a travel that has room for an answer which overshoots.
pub(super) fn limits(position_counts: i32, step: i32) -> Limits {
    let most = i32::try_from(step.unsigned_abs().max(1)).unwrap_or(i32::MAX);
    let room = 4 * most + 1_000;
    let travel = Travel {
        min_counts: position_counts.saturating_sub(room),
        max_counts: position_counts.saturating_add(room),
    };
    let max_step = StepLimit::new(most).unwrap_or(StepLimit::MAX);
    Limits {
        // The answer is what is looked at; an axis that rests half a step away is blocked.
        drift_tolerance_counts: most.unsigned_abs() / 2 + 500,
        ..Limits::new(max_step, StepChange::MAX, travel)
    }
}

fn steps(
    station: &mut Station<'_>,
    arguments: &Arguments,
    step: i32,
    to_counts: impl Fn(i32) -> Option<i32>,
) -> Result<Measured, DrivesError> {
    let hold_us = u64::from(arguments.hold_ms) * 1_000;
    let end_us = 2 * hold_us * u64::from(arguments.periods());
    let anchor = station
        .master()
        .snapshot(0)
        .map_or(0, |axis| axis.sent_counts);
    let start = station.now();
    let first_us = start.as_us() + REST_US;
    let mut samples = Vec::new();
    let mut seen_at: Option<Instant> = None;
    while interrupt::requests() == 0 {
        let elapsed_us = station.now().as_us().saturating_sub(first_us);
        let is_before = station.now().as_us() < first_us;
        if elapsed_us >= end_us {
            return Ok(Measured {
                samples,
                is_complete: true,
            });
        }
        let is_up = !is_before && (elapsed_us / hold_us).is_multiple_of(2);
        let target = anchor.wrapping_add(if is_up { step } else { 0 });
        let mut refused = Ok(());
        station.cycle(|master, _| refused = master.set_target(0, target))?;
        if let Some((drive, fault)) = station.first_fault() {
            return Err(DrivesError::DriveFault { drive, fault });
        }
        refused.map_err(|error| DrivesError::Fault {
            drive: arguments.drive.into(),
            reason: error.to_string(),
        })?;
        let Some(axis) = station.master().snapshot(0) else {
            break;
        };
        if let Some(position) = axis
            .feedback
            .position
            .filter(|read| Some(read.at) != seen_at)
            && let Some(counts) = to_counts(position.value)
        {
            seen_at = Some(position.at);
            samples.push(Sample {
                at_ms: (position.at.as_us() as f64 - first_us as f64) / 1_000.0,
                set_point: axis.sent_counts.wrapping_sub(anchor),
                actual: counts.wrapping_sub(anchor),
            });
        }
    }
    Ok(Measured {
        samples,
        is_complete: false,
    })
}
