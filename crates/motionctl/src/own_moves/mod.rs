//! What `motionctl move` and `motionctl speed` have in common: axes whose drives move by themselves, and waiting for their end.

use can_motion::{
    AxisConfig, AxisState, Fault, Limits, MotorLimits, MoveError, MoveRefusal, PollPeriods, Travel,
};
use dyn_can::{DriveId, GearNumber, units};

use crate::drives::{DrivesError, read_curve};
use crate::interrupt;
use crate::link::Link;
use crate::station::{AxisOptions, BringUpError, GROUP, Seen, Station, look};

/// Shortest cycle: adapters on slow serial ports shall carry it too.
const CYCLE_US: u32 = 5_000;
/// Bit times that a cycle has at least for each drive: a set-point, a request and a reply, and room.
const CYCLE_BITS: u32 = 400;
/// Readings ten times a second; the master reads more often while a drive moves.
const POLLS: PollPeriods = PollPeriods {
    status_us: Some(100_000),
    position_us: Some(100_000),
    ..PollPeriods::OFF
};
/// Room beside the way, in turns: a drive that is enabled takes hold a little beside where it stood.
const MARGIN_TURNS: f64 = 0.05;
/// Time for drives to come back to position mode, after they stand.
const END_LIMIT_US: u64 = 20_000_000;

/// Limits of what drives do by themselves.
#[derive(Debug, Clone, Copy, clap::Args)]
pub(crate) struct OwnLimits {
    /// Highest speed of a motor, r/min. The speed of a move comes from the drive's own parameters: one that is faster is refused.
    #[arg(long, value_name = "RPM", default_value = "60", value_parser = clap::value_parser!(u32).range(1..=20_000))]
    max_rpm: u32,
    /// Fastest change of the speed, r/min per second; it comes from the drive's own parameters too.
    #[arg(long, value_name = "RPM_PER_S", default_value = "1000", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    max_acceleration: u32,
    /// Farthest way of a motor from where it stands, in turns.
    #[arg(long, value_name = "TURNS", default_value = "10", value_parser = positive)]
    max_turns: f64,
}

impl OwnLimits {
    pub(crate) fn text(&self) -> String {
        format!(
            "at most {} r/min, {} r/min per second and {} turns from where a motor stands",
            self.max_rpm, self.max_acceleration, self.max_turns
        )
    }

    pub(crate) const fn max_rpm(&self) -> u32 {
        self.max_rpm
    }

    pub(crate) const fn max_acceleration(&self) -> u32 {
        self.max_acceleration
    }

    pub(crate) const fn max_turns(&self) -> f64 {
        self.max_turns
    }
}

/// What the drives say of themselves, in ascending order.
pub(crate) fn look_at(
    link: &mut Link,
    axes: AxisOptions,
    drives: &[DriveId],
) -> Result<Vec<Seen>, DrivesError> {
    let mut sorted = drives.to_vec();
    sorted.sort_unstable();
    look(link, axes, &sorted).map_err(DrivesError::Look)
}

/// Command counts of so many turns.
pub(crate) fn counts_of(turns: f64, gear: GearNumber) -> i64 {
    (turns * f64::from(units::command_counts_per_turn(gear))).round() as i64
}

/// An axis for each drive, which may go between these ends, with the curve of its drive.
pub(crate) fn axes_of(
    link: &mut Link,
    options: AxisOptions,
    limits: OwnLimits,
    ways: &[(Seen, [i64; 2])],
) -> Result<(Vec<AxisConfig>, u32), DrivesError> {
    let bits = CYCLE_BITS.saturating_mul(u32::try_from(ways.len()).unwrap_or(u32::MAX));
    let cycle_us = CYCLE_US.max(link.bit_rate().us_covering(bits));
    let mut axes = Vec::new();
    for (seen, ends) in ways {
        let margin = counts_of(MARGIN_TURNS, seen.gear);
        let [low, high] = [ends[0].min(ends[1]) - margin, ends[0].max(ends[1]) + margin];
        let travel = Travel {
            min_counts: within_28_bit(low),
            max_counts: within_28_bit(high),
        };
        let motor = MotorLimits {
            speed_rpm: limits.max_rpm,
            acceleration_rpm_per_s: limits.max_acceleration,
        };
        let limits = Limits::of_motor(motor, travel, seen.gear, cycle_us).map_err(|error| {
            DrivesError::MoveRefused {
                drive: seen.drive,
                reason: error.to_string(),
            }
        })?;
        let curve = read_curve(link, options, seen.drive, seen.gear)?;
        axes.push(AxisConfig {
            drive_curve: Some(curve),
            ..options.axis(seen.drive, seen.gear, limits, POLLS)
        });
    }
    Ok((axes, cycle_us))
}

/// The ends of what the protocol can say: a target beyond is refused by the master.
fn within_28_bit(counts: i64) -> i32 {
    let Travel {
        min_counts,
        max_counts,
    } = Travel::WHOLE;
    counts.clamp(min_counts.into(), max_counts.into()) as i32
}

/// Drives that hold, after those that are off were enabled.
pub(crate) fn hold(station: &mut Station<'_>) -> Result<(), DrivesError> {
    station.bring_up().map_err(DrivesError::BringUp)?;
    let now = station.now();
    station.master().stop(now, GROUP);
    station
        .wait_until(|state| state == AxisState::Holding)
        .map_err(DrivesError::BringUp)
}

/// A refusal in the units of the options. The master knows axes and counts, the user knows drives and turns.
pub(crate) fn refused(
    seen: &[Seen],
    limits: OwnLimits,
    cycle_us: u32,
    (axis, error): (usize, MoveError<Fault>),
) -> DrivesError {
    let (axis, refusal) = match error {
        MoveError::Refused { axis, refusal } => (usize::from(axis), Some(refusal)),
        MoveError::OldLoad { axis } => (usize::from(axis), None),
        _ => (axis, None),
    };
    let (drive, gear) = seen
        .get(axis)
        .map_or((DriveId::MIN, GearNumber::MAX), |seen| {
            (seen.drive, seen.gear)
        });
    let cycle_s = f64::from(cycle_us) * 1e-6;
    let rpm =
        |counts: f64| counts / f64::from(units::command_counts_per_turn(gear)) * 60.0 / cycle_s;
    let reason = match refusal {
        Some(MoveRefusal::TooFast { actual, .. }) => format!(
            "the motor would turn at {:.0} r/min, --max-rpm allows {}: lower max-speed of the drive with `motionctl write`, or ask for less",
            rpm(actual.into()),
            limits.max_rpm
        ),
        Some(MoveRefusal::TooSudden { actual, .. }) => format!(
            "the motor would change its speed by {:.0} r/min per second, --max-acceleration allows {}: lower max-acceleration of the drive with `motionctl write`, or give a larger --max-acceleration where the machine bears it",
            rpm(f64::from(actual) / 256.0) / cycle_s,
            limits.max_acceleration
        ),
        Some(refusal) => refusal.to_string(),
        None => error.to_string(),
    };
    DrivesError::MoveRefused { drive, reason }
}

/// Cycles until no drive moves by itself any more, or Ctrl-C or `is_over` stops them. Returns whether it was Ctrl-C.
pub(crate) fn until_over(
    station: &mut Station<'_>,
    mut is_over: impl FnMut(&Station<'_>) -> bool,
) -> Result<bool, DrivesError> {
    let before = interrupt::requests();
    let (mut is_stopped, mut interrupted) = (false, false);
    loop {
        station.cycle(|_, _| {})?;
        if let Some((drive, fault)) = station.first_fault() {
            return Err(DrivesError::DriveFault { drive, fault });
        }
        if !station.snapshots().any(|axis| axis.facts.has_own_move()) {
            return Ok(interrupted);
        }
        let asks = interrupt::requests() > before;
        if !is_stopped && (asks || is_over(station)) {
            (is_stopped, interrupted) = (true, asks);
            let now = station.now();
            station.master().stop(now, GROUP);
        }
        let is_loaded = |state| state == AxisState::Loaded;
        if is_stopped
            && station
                .snapshots()
                .all(|axis| is_loaded(axis.state) || !axis.facts.has_own_move())
        {
            // What is loaded stays so until it is off, which follows.
            return Ok(interrupted);
        }
    }
}

/// Waits until every drive holds, or is off behind its way back to position mode.
pub(crate) fn until_back(station: &mut Station<'_>) -> Result<(), DrivesError> {
    let start = station.now();
    while station.now().us_since(start) < END_LIMIT_US {
        station.cycle(|_, _| {})?;
        if let Some((drive, fault)) = station.first_fault() {
            return Err(DrivesError::DriveFault { drive, fault });
        }
        let is_back = |state| matches!(state, AxisState::Holding | AxisState::Ready);
        if station.snapshots().all(|axis| is_back(axis.state)) {
            return Ok(());
        }
    }
    let waits = station
        .snapshots()
        .find(|axis| axis.state != AxisState::Holding);
    match waits {
        Some(axis) => Err(DrivesError::BringUp(BringUpError::NotReady {
            drive: axis.drive,
            state: axis.state,
        })),
        None => Ok(()),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err(format!("must be a number above 0, got {text}")),
    }
}
