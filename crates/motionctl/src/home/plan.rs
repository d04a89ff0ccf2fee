//! The options as the homing and the master want them.

use can_motion::{AxisConfig, Limits, MotorLimits, PollPeriods, Travel};
use dyn_can::{GearNumber, units};
use homing::{Config, HardStop, Homing, Level, Method, Refusal, Switch, Watch};

use super::arguments::{Arguments, DirectionOption, LevelOption, MethodOption};
use super::error::HomeError;
use crate::link::Link;
use crate::station::Seen;

/// Shortest cycle of the set-points: the steps of a longer one jerk at the motor, which shows in its torque. An adapter at 115200 baud
/// carries it.
const CYCLE_US: u32 = 2_000;
/// Bit times that a cycle has at least: a set-point, a request and a reply, and room.
const CYCLE_BITS: u32 = 400;
/// Position and torque 25 times a second each.
const POLLS: PollPeriods = PollPeriods {
    status_us: Some(100_000),
    position_us: Some(40_000),
    torque_us: Some(40_000),
    ..PollPeriods::OFF
};
/// A reading may be this old: a PC lets a program wait, and adapters on USB hold bytes back.
const MAX_AGE_US: u32 = 200_000;
/// The jerk brings the acceleration to its limit in so long.
const JERK_TIME_S: f64 = 0.05;

/// What is done, and with which limits.
pub(super) struct Plan {
    pub(super) gear: GearNumber,
    pub(super) cycle_us: u32,
    pub(super) axis: AxisConfig,
    pub(super) config: Config,
    pub(super) turn_counts: f64,
}

impl Plan {
    pub(super) fn new(arguments: &Arguments, link: &Link, seen: &Seen) -> Result<Self, HomeError> {
        let cycle_us = CYCLE_US.max(link.bit_rate().us_covering(CYCLE_BITS));
        let gear = seen.gear;
        let scale = Scale {
            turn: f64::from(units::command_counts_per_turn(gear)),
            cycle_s: f64::from(cycle_us) * 1e-6,
        };
        let config = config(arguments, &scale, cycle_us)?;
        // Refused here, before anything is asked.
        Homing::new(config, seen.position_counts).map_err(|refusal| scale.words(refusal))?;
        let reach = config
            .reach(seen.position_counts)
            .map_err(HomeError::Refusal)?;
        let motor = MotorLimits {
            // Of a set-point that was late, a quarter more.
            speed_rpm: (arguments.rpm * 1.25).ceil() as u32 + 1,
            acceleration_rpm_per_s: arguments.max_acceleration.ceil() as u32,
        };
        let travel = Travel {
            min_counts: reach.min_counts,
            max_counts: reach.max_counts,
        };
        let limits = Limits::of_motor(motor, travel, gear, cycle_us)
            .map_err(|error| HomeError::Limits(error.to_string()))?;
        let most = scale.counts_of_degrees(arguments.max_degrees);
        let limits = Limits {
            // What a pause of this computer may leave owing, until the homing waits for it.
            backlog_counts: limits.backlog_counts.saturating_mul(4),
            // The homing sees both first, and says more.
            following_error_counts: most.saturating_mul(2),
            drift_tolerance_counts: most,
            ..limits
        };
        Ok(Self {
            gear,
            cycle_us,
            axis: arguments.axes.axis(arguments.drive, gear, limits, POLLS),
            config,
            turn_counts: scale.turn,
        })
    }

    /// Counts in turns of the motor.
    pub(super) fn turns(&self, counts: i64) -> f64 {
        counts as f64 / self.turn_counts
    }
}

struct Scale {
    /// Counts of a turn.
    turn: f64,
    cycle_s: f64,
}

impl Scale {
    fn counts(&self, turns: f64) -> i32 {
        (turns * self.turn).round() as i32
    }

    fn counts_of_degrees(&self, degrees: f64) -> u32 {
        (degrees / 360.0 * self.turn).round() as u32
    }

    fn limits(&self, rpm: f64, rpm_per_s: f64) -> Result<trajectory::Limits, HomeError> {
        let velocity = rpm / 60.0 * self.turn * self.cycle_s;
        let acceleration = rpm_per_s / 60.0 * self.turn * self.cycle_s * self.cycle_s;
        let jerk = acceleration * self.cycle_s / JERK_TIME_S;
        trajectory::Limits::new(velocity as f32, acceleration as f32, jerk as f32)
            .map_err(|error| HomeError::Limits(error.to_string()))
    }

    /// A refusal in the words of the options.
    fn words(&self, refusal: Refusal) -> HomeError {
        let rpm = |counts: f32| f64::from(counts) / self.turn / self.cycle_s * 60.0;
        match refusal {
            Refusal::TooFast { most, actual } => HomeError::TooFast {
                most_rpm: (rpm(most) * 10.0).floor() / 10.0,
                actual_rpm: (rpm(actual) * 10.0).round() / 10.0,
            },
            Refusal::SlowIsFaster { most, actual } => HomeError::Order {
                what: "--slow-rpm",
                than: "--rpm",
                actual: (rpm(actual) * 10.0).round() / 10.0,
                most: (rpm(most) * 10.0).round() / 10.0,
            },
            other => HomeError::Refusal(other),
        }
    }
}

fn config(arguments: &Arguments, scale: &Scale, cycle_us: u32) -> Result<Config, HomeError> {
    let permille = |percent: f64| (percent * 10.0).round() as u16;
    let direction = arguments
        .direction
        .unwrap_or(DirectionOption::Positive)
        .into();
    let most_counts = scale.counts_of_degrees(arguments.max_degrees);
    let method = match arguments.method {
        MethodOption::Here => Method::Here,
        MethodOption::Stop => Method::HardStop(HardStop {
            direction,
            contact_permille: permille(arguments.torque),
            most_permille: permille(arguments.max_torque),
            contact_counts: scale.counts_of_degrees(arguments.contact_degrees),
            most_counts,
            repeat_counts: scale.counts_of_degrees(arguments.contact_degrees),
        }),
        MethodOption::Switch => Method::Switch(Switch {
            direction,
            operated: match arguments.switch_active {
                LevelOption::High => Level::High,
                LevelOption::Low => Level::Low,
            },
            most_counts,
            most_permille: Some(permille(arguments.max_torque)),
        }),
    };
    let way = scale.counts(arguments.max_turns.unwrap_or_default());
    let (min, max) = match arguments.travel {
        Some((min, max)) => (scale.counts(min), scale.counts(max)),
        None => (i32::MIN / 4, i32::MAX / 4),
    };
    let acceleration = arguments.max_acceleration;
    Ok(Config {
        method,
        cycle_us,
        search: scale.limits(arguments.rpm, acceleration)?,
        slow: scale.limits(arguments.slow_rpm, acceleration)?,
        way_counts: way.unsigned_abs(),
        back_off_counts: scale.counts(arguments.back_off).unsigned_abs(),
        reference_counts: scale.counts(arguments.reference),
        travel: homing::Travel {
            min_counts: min,
            max_counts: max,
        },
        watch: Watch {
            max_age_us: MAX_AGE_US,
            ..Watch::DEFAULT
        },
    })
}
