//! A move by hand, streamed as a minimum-jerk profile.

use can_motion::motion::{Keyframe, KeyframeMotion};
use can_motion::{AxisState, Fault, PollPeriods};
use dyn_can::{DriveId, StepLimit, units};

use super::procedure::answering_station;
use crate::drives::{DrivesError, Jog, JogEnd};
use crate::interrupt;
use crate::link::Link;
use crate::station::{AxisOptions, GROUP, Station};

/// Shortest cycle of the set-points. A jog is slow, and adapters on slow serial ports shall carry it too.
const CYCLE_US: u32 = 5_000;
/// Bit times that a cycle has at least: a set-point, a request and a reply, and room.
const CYCLE_BITS: u32 = 400;
/// Readings ten times a second.
const POLLS: PollPeriods = PollPeriods {
    status_us: Some(100_000),
    position_us: Some(100_000),
    ..PollPeriods::OFF
};
/// Time for the drive to become ready, and to be enabled.
const START_UP_LIMIT_US: u64 = 10_000_000;
/// Time after the move for the drive to arrive and to be read once more.
const SETTLE_US: u64 = 300_000;
/// The highest speed of a minimum-jerk move is 15/8 of the mean one.
const PEAK_OVER_MEAN: f64 = 15.0 / 8.0;
const MS_PER_MINUTE: f64 = 60_000.0;

/// Enables, moves, disables.
pub(super) fn jog(
    link: &mut Link,
    axes: AxisOptions,
    drive: DriveId,
    jog: Jog,
) -> Result<JogEnd, DrivesError> {
    let asked_counts = distance_counts(link, axes, drive, jog)?;
    let keyframes = keyframes(asked_counts, jog);
    let motion = KeyframeMotion::new(&keyframes).map_err(|error| DrivesError::Fault {
        drive: drive.into(),
        reason: error.to_string(),
    })?;
    let cycle_us = CYCLE_US.max(link.bit_rate().us_covering(CYCLE_BITS));
    let axis = axes.axis(drive, catch_up(&motion, cycle_us), POLLS);
    let mut station = Station::new(link, &[axis], cycle_us).map_err(DrivesError::Config)?;
    let moved = Move {
        station: &mut station,
        drive,
    }
    .along(&motion);
    // Whatever has happened, the drive shall not stay enabled.
    let shut_down = station.shut_down();
    let (sent_counts, read_counts, interrupted) = DrivesError::after_shut_down(moved, shut_down)?;
    Ok(JogEnd {
        asked_counts,
        sent_counts,
        read_counts: read_counts.and_then(|counts| axes.scale().to_command_counts(counts)),
        interrupted,
        enabled: false,
    })
}

/// From rest to rest, with the highest speed in the middle.
fn keyframes(counts: i32, jog: Jog) -> [Keyframe<1>; 2] {
    let minutes = jog.turns.abs() * PEAK_OVER_MEAN / jog.rpm;
    // The options bound turns and speed, so the time fits.
    let duration_ms = ((minutes * MS_PER_MINUTE).ceil() as u32).max(1);
    [(0, 0), (duration_ms, counts)].map(|(at_ms, counts)| Keyframe {
        at_ms,
        positions_counts: [counts],
    })
}

/// A quarter above the largest step of the motion: an axis that is behind catches up, and never much faster than planned.
fn catch_up(motion: &KeyframeMotion<'_, 1>, cycle_us: u32) -> StepLimit {
    let [peak] = motion.peak_step_counts(cycle_us);
    let step = i32::try_from(peak + peak / 4).unwrap_or(i32::MAX);
    StepLimit::new(step).unwrap_or(StepLimit::MAX)
}

/// Turns in the command counts of the drive, which depend on its gear number.
fn distance_counts(
    link: &mut Link,
    axes: AxisOptions,
    drive: DriveId,
    jog: Jog,
) -> Result<i32, DrivesError> {
    let mut station = answering_station(link, axes, drive, PollPeriods::OFF)?;
    let axis = station.master().snapshot(0);
    let group = axis.and_then(|axis| axis.feedback.group3);
    let gear = group
        .ok_or(DrivesError::Incomplete {
            drive: drive.into(),
        })?
        .gear_number;
    let counts = jog.turns * f64::from(units::command_counts_per_turn(gear));
    Ok(counts.round() as i32)
}

struct Move<'a, 'link> {
    station: &'a mut Station<'link>,
    drive: DriveId,
}

impl Move<'_, '_> {
    /// Runs the move; returns the counts that were sent, those that were read, and whether it was interrupted.
    fn along(
        &mut self,
        motion: &KeyframeMotion<'_, 1>,
    ) -> Result<(i32, Option<i32>, bool), DrivesError> {
        self.wait_for(AxisState::Ready)?;
        let now = self.station.now();
        let enabled = self.station.master().enable(now, GROUP);
        enabled.map_err(|error| DrivesError::Fault {
            drive: self.drive.into(),
            reason: error.to_string(),
        })?;
        self.wait_for(AxisState::Streaming)?;
        let (anchor, read_anchor) = self.positions();
        let start = self.station.now();
        let end_us = motion.duration_us() + SETTLE_US;
        let mut elapsed_us = 0;
        while elapsed_us < end_us && interrupt::requests() == 0 {
            elapsed_us = self.station.now().us_since(start);
            let [offset] = motion.position(elapsed_us);
            self.station.cycle(|master, _| {
                // A refusal is an axis that stopped by a fault, which the check below tells.
                let _ = master.set_target(0, anchor.wrapping_add(offset));
            })?;
            self.check()?;
        }
        let (sent, read) = self.positions();
        let read_counts = read
            .zip(read_anchor)
            .map(|(read, anchor)| read.wrapping_sub(anchor));
        Ok((
            sent.wrapping_sub(anchor),
            read_counts,
            interrupt::requests() > 0,
        ))
    }

    /// Where the set-points have led, in command counts, and where the drive says it is, in read-back counts.
    fn positions(&mut self) -> (i32, Option<i32>) {
        self.station.master().snapshot(0).map_or((0, None), |axis| {
            let position = axis.feedback.position;
            (axis.sent_counts, position.map(|position| position.value))
        })
    }

    fn wait_for(&mut self, state: AxisState) -> Result<(), DrivesError> {
        let start = self.station.now();
        while self.station.now().us_since(start) < START_UP_LIMIT_US {
            self.station.cycle(|_, _| {})?;
            self.check()?;
            if interrupt::requests() > 0 {
                return Err(DrivesError::Interrupted);
            }
            if self.station.master().all_are(GROUP, state) {
                return Ok(());
            }
        }
        Err(DrivesError::Incomplete {
            drive: self.drive.into(),
        })
    }

    fn check(&mut self) -> Result<(), DrivesError> {
        let drive = self.drive;
        match self
            .station
            .master()
            .snapshot(0)
            .and_then(|axis| axis.fault)
        {
            None => Ok(()),
            Some(Fault::Lost) => Err(DrivesError::NoAnswer {
                drive: drive.into(),
            }),
            Some(fault) => Err(DrivesError::Fault {
                drive: drive.into(),
                reason: fault.to_string(),
            }),
        }
    }
}
