//! The options as the homing and the master want them.

use can_motion::{AxisConfig, Limits, MotorLimits, PollPeriods, Travel};
use dyn_can::{GearNumber, units};
use homing::{Config, Homing, Watch};

use super::arguments::Arguments;
use super::error::HomeError;
use super::options::Family;
use super::scale::Scale;
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
/// Servos lag little, and are read 25 times a second.
pub(super) const SERVO: Family = Family {
    contact_degrees: 3.0,
    max_degrees: 45.0,
    max_age_us: 200_000,
    still_counts: Watch::DEFAULT.still_counts,
};

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
            cycle_us,
        };
        let config = arguments.search.config(&scale, &SERVO)?;
        // Refused here, before anything is asked.
        Homing::new(config, seen.position_counts).map_err(|refusal| scale.words(refusal))?;
        let reach = config
            .reach(seen.position_counts)
            .map_err(HomeError::Refusal)?;
        let motor = MotorLimits {
            // Of a set-point that was late, a quarter more.
            speed_rpm: (arguments.search.rpm * 1.25).ceil() as u32 + 1,
            acceleration_rpm_per_s: arguments.search.max_acceleration.ceil() as u32,
        };
        // A shaft that stands may be read a little beside where it was seen.
        let still = SERVO.still_counts.cast_signed();
        let travel = Travel {
            min_counts: reach.min_counts.saturating_sub(still),
            max_counts: reach.max_counts.saturating_add(still),
        };
        let limits = Limits::of_motor(motor, travel, gear, cycle_us)
            .map_err(|error| HomeError::Limits(error.to_string()))?;
        let most = scale.counts_of_degrees(arguments.search.max_degrees(&SERVO));
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
}
