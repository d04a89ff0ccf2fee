//! A move by hand, streamed on a jerk-limited profile.

use can_motion::PollPeriods;
use dyn_can::{DriveId, GearNumber, units};
use trajectory::curve::{Keyframe, KeyframeMotion};

use crate::drives::{DrivesError, Jog, JogEnd};
use crate::interrupt;
use crate::link::Link;
use crate::station::{AxisOptions, Needs, Station, look};

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
/// Time after the move for the drive to arrive and to be read once more.
const SETTLE_US: u64 = 300_000;
/// Highest speed of a minimum-jerk move of one turn in one second, in turns per second.
const PEAK_SPEED: f64 = 15.0 / 8.0;
/// Highest acceleration of the same, in turns per second squared: 10 / sqrt(3).
const PEAK_ACCELERATION: f64 = 5.773_502_691_896_258;

/// Enables, moves, disables.
pub(super) fn jog(
    link: &mut Link,
    axes: AxisOptions,
    drive: DriveId,
    jog: Jog,
) -> Result<JogEnd, DrivesError> {
    let seen = look(link, axes, &[drive]).map_err(DrivesError::Look)?;
    let seen = seen.first().ok_or(DrivesError::Incomplete {
        drive: drive.into(),
    })?;
    let gear = seen.gear;
    if let Some(expected) = jog.gear.filter(|expected| *expected != gear) {
        return Err(DrivesError::Gear {
            drive,
            expected,
            actual: gear,
        });
    }
    let asked_counts = (jog.turns * f64::from(units::command_counts_per_turn(gear))).round() as i32;
    let keyframes = keyframes(asked_counts, jog);
    let motion = KeyframeMotion::new(&keyframes).map_err(|error| DrivesError::Fault {
        drive: drive.into(),
        reason: error.to_string(),
    })?;
    let cycle_us = CYCLE_US.max(link.bit_rate().us_covering(CYCLE_BITS));
    let needs = needs(&motion, gear, cycle_us);
    let limits = jog
        .limits
        .of_axis(&needs, seen.position_counts, gear, cycle_us);
    let axis = axes.axis(drive, gear, limits, POLLS);
    let mut station = Station::new(link, &[axis], cycle_us).map_err(DrivesError::Config)?;
    let moved = along(&mut station, drive, &motion);
    let (moved, end) = DrivesError::after_shut_down(moved, &mut station)?;
    Ok(JogEnd {
        asked_counts,
        sent_counts: moved.sent_counts,
        read_counts: moved
            .read_back_counts
            .and_then(|counts| axes.scale(gear).to_command_counts(counts)),
        interrupted: moved.interrupted,
        enabled: !end.left_on.is_empty(),
    })
}

/// From rest to rest, with the highest speed in the middle, as fast as speed and acceleration allow.
fn keyframes(counts: i32, jog: Jog) -> [Keyframe<1>; 2] {
    let turns = jog.turns.abs();
    let by_speed_s = turns * PEAK_SPEED / (jog.rpm / 60.0);
    let by_acceleration_s =
        (turns * PEAK_ACCELERATION / (jog.limits.acceleration_rpm_per_s() / 60.0)).sqrt();
    // The options bound turns, speed and acceleration, so the time fits.
    let duration_ms = ((by_speed_s.max(by_acceleration_s) * 1_000.0).ceil() as u32).max(1);
    [(0, 0), (duration_ms, counts)].map(|(at_ms, counts)| Keyframe {
        at_ms,
        positions_counts: [counts],
    })
}

fn needs(motion: &KeyframeMotion<'_, 1>, gear: GearNumber, cycle_us: u32) -> Needs {
    let cycles = 0..=motion.duration_us() / u64::from(cycle_us) + 1;
    let positions: Vec<i32> = cycles
        .map(|cycle| {
            let [position] = motion.position(cycle * u64::from(cycle_us));
            position
        })
        .collect();
    Needs::of(&positions, gear, cycle_us)
}

/// Where a move has led.
struct Moved {
    sent_counts: i32,
    /// In read-back counts.
    read_back_counts: Option<i32>,
    interrupted: bool,
}

/// Runs the move.
fn along(
    station: &mut Station<'_>,
    drive: DriveId,
    motion: &KeyframeMotion<'_, 1>,
) -> Result<Moved, DrivesError> {
    station.bring_up().map_err(DrivesError::BringUp)?;
    let (anchor, read_anchor) = positions(station);
    let start = station.now();
    let end_us = motion.duration_us() + SETTLE_US;
    let mut elapsed_us = 0;
    while elapsed_us < end_us && interrupt::requests() == 0 {
        elapsed_us = station.now().us_since(start);
        let [offset] = motion.position(elapsed_us);
        let mut target = Ok(());
        station.cycle(|master, _| target = master.set_target(0, anchor.wrapping_add(offset)))?;
        if let Some((drive, fault)) = station.first_fault() {
            return Err(DrivesError::DriveFault { drive, fault });
        }
        target.map_err(|error| DrivesError::Fault {
            drive: drive.into(),
            reason: error.to_string(),
        })?;
    }
    let (sent, read) = positions(station);
    let read_back_counts = read
        .zip(read_anchor)
        .map(|(read, anchor)| read.wrapping_sub(anchor));
    Ok(Moved {
        sent_counts: sent.wrapping_sub(anchor),
        read_back_counts,
        interrupted: interrupt::requests() > 0,
    })
}

/// Where the set-points have led, in command counts, and where the drive says it is, in read-back counts.
fn positions(station: &mut Station<'_>) -> (i32, Option<i32>) {
    station.master().snapshot(0).map_or((0, None), |axis| {
        let position = axis.feedback.position;
        (axis.sent_counts, position.map(|position| position.value))
    })
}
