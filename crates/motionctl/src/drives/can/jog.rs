//! A move by hand, streamed on a jerk-limited profile.

use can_motion::{AxisState, Fault, PollPeriods};
use dyn_can::{DriveId, GearNumber, StepLimit, units};
use trajectory::{Limits, Position, Profile, RangeError, State, Time};

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
/// Time from standstill to the full speed at the largest acceleration, and from none to the largest acceleration: slow on purpose.
const SPEED_UP_US: f64 = 500_000.0;
const BUILD_UP_US: f64 = 250_000.0;
const US_PER_MINUTE: f64 = 60_000_000.0;

/// Enables, moves, disables.
pub(super) fn jog(
    link: &mut Link,
    axes: AxisOptions,
    drive: DriveId,
    jog: Jog,
) -> Result<JogEnd, DrivesError> {
    let gear = gear_number(link, axes, drive)?;
    let cycle_us = CYCLE_US.max(link.bit_rate().us_covering(CYCLE_BITS));
    let counts_per_turn = f64::from(units::command_counts_per_turn(gear));
    let asked_counts = (jog.turns * counts_per_turn).round() as i32;
    let fault = |reason: String| DrivesError::Fault {
        drive: drive.into(),
        reason,
    };
    let limits =
        limits(jog.rpm * counts_per_turn, cycle_us).map_err(|error| fault(error.to_string()))?;
    let target = Position::from_counts(asked_counts);
    let motion = Profile::to_rest(&State::at_rest(0), target, &limits)
        .map_err(|error| fault(error.to_string()))?;
    let axis = axes.axis(drive, catch_up(&limits), POLLS);
    let mut station = Station::new(link, &[axis], cycle_us).map_err(DrivesError::Config)?;
    let moved = Move {
        station: &mut station,
        drive,
        cycle_us,
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

/// No faster than so many counts per minute.
fn limits(counts_per_minute: f64, cycle_us: u32) -> Result<Limits, RangeError> {
    let cycle_us = f64::from(cycle_us);
    let velocity = counts_per_minute * cycle_us / US_PER_MINUTE;
    let acceleration = velocity * cycle_us / SPEED_UP_US;
    let jerk = acceleration * cycle_us / BUILD_UP_US;
    Limits::new(velocity as f32, acceleration as f32, jerk as f32)
}

/// A quarter above the highest velocity, and a count for rounding: an axis that is behind catches up, and never much faster than allowed.
fn catch_up(limits: &Limits) -> StepLimit {
    let step = (1.25 * limits.velocity()).ceil() as i32 + 1;
    StepLimit::new(step).unwrap_or(StepLimit::MAX)
}

/// The gear number of the drive, on which its command counts depend.
fn gear_number(
    link: &mut Link,
    axes: AxisOptions,
    drive: DriveId,
) -> Result<GearNumber, DrivesError> {
    let mut station = answering_station(link, axes, drive, PollPeriods::OFF)?;
    let axis = station.master().snapshot(0);
    let group = axis.and_then(|axis| axis.feedback.group3);
    group
        .map(|group| group.gear_number)
        .ok_or(DrivesError::Incomplete {
            drive: drive.into(),
        })
}

struct Move<'a, 'link> {
    station: &'a mut Station<'link>,
    drive: DriveId,
    cycle_us: u32,
}

impl Move<'_, '_> {
    /// Runs the move; returns the counts that were sent, those that were read, and whether it was interrupted.
    fn along(&mut self, motion: &Profile) -> Result<(i32, Option<i32>, bool), DrivesError> {
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
        let settle = Time::from_units(SETTLE_US, self.cycle_us);
        let end = motion.duration().after(settle);
        let mut elapsed = Time::ZERO;
        while elapsed < end && interrupt::requests() == 0 {
            elapsed = Time::from_units(self.station.now().us_since(start), self.cycle_us);
            let offset = motion.position(elapsed).counts();
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
