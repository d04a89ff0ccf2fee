//! What the homing of an axis becomes: a search, in counts and cycles.

use can_motion::{AxisConfig, Limits, Travel};
use dyn_can::GearNumber;
use dyn_can::units::command_counts_per_turn;
use homing::{Config, Direction, HardStop, Level, Method, Switch, Watch};
use trajectory::RangeError;

use crate::axis::{AxisSettings, MotorLimits};
use crate::board::Board;
use crate::homing::{HomingDirection, HomingMethod, HomingSearch, HomingSettings, SwitchLevel};
use crate::refusal::{Kind, Refusal};

/// The jerk brings the acceleration to its limit in so long.
const JERK_TIME_S: f32 = 0.05;
/// The longest way and the farthest reference, in counts: with everything around it 32 bits have room.
const FARTHEST_COUNTS: u32 = 1 << 26;
/// The first pin that a switch may hang on.
const FIRST_PIN: u8 = 3;

/// The homing of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisHoming {
    /// Its search.
    pub search: Config,
    /// The pin of port C with its switch.
    pub switch_pin: Option<u8>,
    /// Axes with a lower number are homed before; those with the same one in the order of the list.
    pub order: u8,
    /// Where its drive may be: the travel of its master.
    pub reach: homing::Travel,
}

/// Counts and cycles of an axis.
#[derive(Clone, Copy)]
struct Scale {
    gear: GearNumber,
    cycle_us: u32,
}

impl Scale {
    /// Rounded towards 0; what 32 bits do not hold is their end.
    fn counts(self, millidegrees: i64) -> i32 {
        Travel::of_motor_millidegrees(0, millidegrees, self.gear).max_counts
    }

    fn length(self, millidegrees: u32) -> u32 {
        self.counts(millidegrees.into()).unsigned_abs()
    }

    fn limits(self, speed: u16, acceleration: u32) -> Result<trajectory::Limits, RangeError> {
        let cycle_s = self.cycle_us as f32 * 1e-6;
        let per_rpm = command_counts_per_turn(self.gear) as f32 / 60.0 * cycle_s;
        let acceleration = acceleration as f32 * per_rpm * cycle_s;
        let jerk = acceleration * cycle_s / JERK_TIME_S;
        trajectory::Limits::new(f32::from(speed) * per_rpm, acceleration, jerk)
    }

    /// Rounded down.
    fn rpm(self, counts_per_cycle: f32) -> i64 {
        let cycle_s = self.cycle_us as f32 * 1e-6;
        (counts_per_cycle * 60.0 / command_counts_per_turn(self.gear) as f32 / cycle_s) as i64
    }
}

/// Refuses what is not within a range, with its nearest end.
fn within(kind: Kind, actual: u32, least: u32, most: u32) -> Result<(), Refusal> {
    if (least..=most).contains(&actual) {
        return Ok(());
    }
    let nearest = if actual < least { least } else { most };
    Err(kind.because(nearest.into(), actual.into()))
}

/// A switch of its own for each axis that has one; a pin that is free is expected, where there is one.
pub(crate) fn check_pins(homings: &[Option<AxisHoming>], board: &Board) -> Result<(), Refusal> {
    let pin_of = |homing: &Option<AxisHoming>| homing.as_ref().and_then(|homing| homing.switch_pin);
    let is_taken = |pin: &u8| homings.iter().any(|homing| pin_of(homing) == Some(*pin));
    for (axis, homing) in homings.iter().enumerate() {
        let before = homings.iter().take(axis);
        if let Some(pin) = pin_of(homing)
            && before.map(pin_of).any(|other| other == Some(pin))
        {
            let free = (FIRST_PIN..=board.last_switch_pin).find(|pin| !is_taken(pin));
            return Err(Kind::HomingPinTaken.at(axis, free.unwrap_or(pin).into(), pin.into()));
        }
    }
    Ok(())
}

impl AxisSettings {
    /// The search of this axis; `config` is that of its master, but for its travel, which is that of the settings and will be `reach`.
    pub(crate) fn search(
        &self,
        homing: &HomingSettings,
        config: &AxisConfig,
        reach: Travel,
        board: &Board,
    ) -> Result<AxisHoming, Refusal> {
        let cycle_us = board.cycle_us;
        let (gear, limits) = (config.gear, &config.limits);
        let scale = Scale { gear, cycle_us };
        let watch = Watch::DEFAULT;
        self.check_polls(&homing.method, &watch)?;
        let motor = MotorLimits {
            speed_rpm: self.speed_rpm,
            acceleration_rpm_per_s: self.acceleration_rpm_per_s,
        };
        let (method, switch_pin) =
            self.method(&homing.method, limits, (scale, board.last_switch_pin))?;
        // Nothing moves with the first: any limits will do.
        let still = HomingSearch::new(HomingDirection::Positive, 360_000);
        let search = homing.method.search();
        let (fast, slow) = check_search(search.unwrap_or(&still), motor, scale)?;
        let length = |of: fn(&HomingSearch) -> u32| search.map_or(0, |way| scale.length(of(way)));
        let reference_counts = scale.counts(homing.reference_millidegrees.into());
        let reference = reference_counts.unsigned_abs();
        within(Kind::HomingRest, reference, 0, FARTHEST_COUNTS)?;
        let config = Config {
            method,
            cycle_us,
            search: fast,
            slow,
            way_counts: length(|way| way.way_millidegrees),
            back_off_counts: length(|way| way.back_off_millidegrees),
            reference_counts,
            travel: homing::Travel {
                min_counts: limits.travel.min_counts,
                max_counts: limits.travel.max_counts,
            },
            watch,
        };
        let speed_rpm = search.map_or(0, |way| way.speed_rpm);
        let checked = config.check();
        checked.map_err(|refusal| of_search(&refusal, speed_rpm, scale))?;
        Ok(AxisHoming {
            search: config,
            switch_pin,
            order: homing.order,
            reach: homing::Travel {
                min_counts: reach.min_counts,
                max_counts: reach.max_counts,
            },
        })
    }

    /// Every reading must be there twice before it is too old.
    fn check_polls(&self, method: &HomingMethod, watch: &Watch) -> Result<(), Refusal> {
        let most = watch.max_age_us / 2;
        within(Kind::HomingPositionPoll, self.polls.position_us, 1, most)
            .map_err(|refusal| at_most(refusal, most))?;
        let torque_us = self.polls.torque_us;
        match method {
            HomingMethod::Stop { .. } => within(Kind::HomingTorquePoll, torque_us, 1, most),
            HomingMethod::Switch { .. } => within(Kind::HomingTorquePoll, torque_us, 0, most),
            HomingMethod::Here => Ok(()),
        }
        .map_err(|refusal| at_most(refusal, most))
    }

    fn method(
        &self,
        method: &HomingMethod,
        limits: &Limits,
        (scale, last_pin): (Scale, u8),
    ) -> Result<(Method, Option<u8>), Refusal> {
        let most_of = |search: &HomingSearch| {
            let most = scale.length(search.most_millidegrees);
            let permille = search.most_torque_permille;
            within(Kind::HomingMostTorque, permille.into(), 1, 1_000)?;
            let below = limits.following_error_counts.saturating_sub(1);
            within(Kind::HomingMost, most, 1, below)?;
            Ok((most, permille))
        };
        Ok(match *method {
            HomingMethod::Here => (Method::Here, None),
            HomingMethod::Stop {
                search,
                torque_permille,
                contact_millidegrees,
            } => {
                let (most_counts, most_permille) = most_of(&search)?;
                let contact_counts = scale.length(contact_millidegrees);
                let (torque, most) = (torque_permille.into(), most_permille.into());
                within(Kind::HomingTorque, torque, 1, most)?;
                within(Kind::HomingContact, contact_counts, 1, most_counts - 1)?;
                let stop = HardStop {
                    direction: search.direction.into(),
                    contact_permille: torque_permille,
                    most_permille,
                    contact_counts,
                    most_counts,
                    repeat_counts: contact_counts,
                };
                (Method::HardStop(stop), None)
            }
            HomingMethod::Switch {
                search,
                pin,
                active,
            } => {
                let (most_counts, most_permille) = most_of(&search)?;
                let (first, last) = (FIRST_PIN.into(), last_pin.into());
                within(Kind::HomingPin, pin.into(), first, last)?;
                let switch = Switch {
                    direction: search.direction.into(),
                    operated: match active {
                        SwitchLevel::Low => Level::Low,
                        SwitchLevel::High => Level::High,
                    },
                    most_counts,
                    most_permille: (self.polls.torque_us > 0).then_some(most_permille),
                };
                (Method::Switch(switch), Some(pin))
            }
        })
    }
}

/// The limits of the search and of the second approach.
fn check_search(
    search: &HomingSearch,
    motor: MotorLimits,
    scale: Scale,
) -> Result<(trajectory::Limits, trajectory::Limits), Refusal> {
    let speed = search.speed_rpm;
    within(Kind::HomingSpeed, speed.into(), 1, motor.speed_rpm)?;
    let (slow, most) = (search.slow_speed_rpm, speed.into());
    within(Kind::HomingSlowSpeed, slow.into(), 1, most)?;
    let acceleration = search.acceleration_rpm_per_s;
    let most = motor.acceleration_rpm_per_s;
    within(Kind::HomingAcceleration, acceleration, 1, most)?;
    let way = scale.length(search.way_millidegrees);
    within(Kind::HomingWay, way, 1, FARTHEST_COUNTS)?;
    let back_off = scale.length(search.back_off_millidegrees);
    within(Kind::HomingBackOff, back_off, 1, way)?;
    let limits = |speed| {
        let limits = scale.limits(speed, acceleration);
        limits.map_err(|_| Kind::HomingAcceleration.because(most.into(), acceleration.into()))
    };
    Ok((limits(speed)?, limits(slow)?))
}

/// What is not read at all is to be read as seldom as may be.
fn at_most(refusal: Refusal, most: u32) -> Refusal {
    Refusal {
        expected: most.into(),
        ..refusal
    }
}

fn of_search(refusal: &homing::Refusal, speed_rpm: u16, scale: Scale) -> Refusal {
    match *refusal {
        homing::Refusal::TooFast { most, .. } => {
            Kind::HomingTooFast.because(scale.rpm(most), speed_rpm.into())
        }
        homing::Refusal::RestOutsideTravel { min, max, actual } => {
            let nearest = actual.clamp(min.into(), max.max(min).into());
            Kind::HomingRest.because(nearest, actual)
        }
        _ => Kind::HomingSearch.because(0, 0),
    }
}

impl From<HomingDirection> for Direction {
    fn from(direction: HomingDirection) -> Self {
        match direction {
            HomingDirection::Positive => Self::Positive,
            HomingDirection::Negative => Self::Negative,
        }
    }
}
