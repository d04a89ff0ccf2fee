//! How much of its motor a motion may use, and what a motion needs.
//!
//! Nothing is guessed: the limits are options with slow defaults, they are printed, and a motion that needs more is refused with
//! the option that allows it. The travel of an axis is what its motion needs, around where it stands.

use core::fmt;

use board_link::AxisLimits;
use can_motion::{Limits, StepChange, Travel};
use dyn_can::{DriveId, GearNumber, StepLimit, units};
use trajectory::{Position, RangeError};

use super::pc_master::STUCK_US;
use crate::set_points::AxisHeadroom;

/// Acceleration is a mean over so long: command counts are too coarse for less.
const WINDOW_US: u32 = 20_000;
/// An axis may end so many turns beyond the travel of its motion: a shaft that is enabled settles.
const MARGIN_TURNS: f64 = 0.05;

/// How much of its motor a motion may use.
#[derive(Debug, Clone, Copy, PartialEq, clap::Args)]
pub(crate) struct MotionLimits {
    /// Fastest speed of a motor, in r/min.
    #[arg(long, value_name = "RPM", default_value = "500", value_parser = positive)]
    max_rpm: f64,
    /// Fastest change of that speed in r/min per second, as a mean over 20 ms; a stop slows down with it.
    #[arg(long, value_name = "RPM_PER_S", default_value = "5000", value_parser = positive)]
    max_acceleration: f64,
    /// Farthest way of a motor from where it stands, in turns.
    #[arg(long, value_name = "TURNS", default_value = "10", value_parser = positive)]
    max_turns: f64,
}

/// What the motion of one axis needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Needs {
    pub(crate) rpm: f64,
    pub(crate) rpm_per_s: f64,
    /// Farthest positions from the start, in turns of the motor.
    pub(crate) min_turns: f64,
    pub(crate) max_turns: f64,
    /// Largest step from one cycle to the next, in command counts.
    largest_step: u32,
}

/// Something that a motion needs of a motor, and how much of it is allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LimitedQuantity {
    pub(crate) name: &'static str,
    pub(crate) unit: &'static str,
    /// The option of the limit.
    pub(crate) option: &'static str,
    pub(crate) needs: f64,
    pub(crate) allowed: f64,
}

/// A motion that needs more than is allowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LimitError {
    drive: DriveId,
    quantity: LimitedQuantity,
}

impl fmt::Display for LimitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LimitedQuantity {
            name,
            unit,
            option,
            needs,
            allowed,
        } = self.quantity;
        let drive = self.drive;
        let article = if name.starts_with('a') { "an" } else { "a" };
        // Rounded up, so that the option that is offered is enough.
        let enough = (needs * 100.0).ceil() / 100.0;
        write!(
            f,
            "the motion of drive {drive} needs {article} {name} of {enough} {unit}, and {option} allows {allowed}: check the file and its unit, or allow it with {option} {enough}"
        )
    }
}

impl std::error::Error for LimitError {}

impl Needs {
    /// What positions, one a cycle, in command counts from the start, need of a motor with this gear number.
    pub(crate) fn of(positions: &[i32], gear: GearNumber, cycle_us: u32) -> Self {
        let turn = f64::from(units::command_counts_per_turn(gear));
        let window = usize::try_from(WINDOW_US / cycle_us).unwrap_or(1).max(1);
        let window_s = window as f64 * f64::from(cycle_us) * 1e-6;
        // What comes before the first cycle and after the last one is rest.
        let at = |cycle: isize| {
            let last = positions.len().saturating_sub(1);
            let place = usize::try_from(cycle).unwrap_or(0).min(last);
            f64::from(positions.get(place).copied().unwrap_or(0)) / turn
        };
        let (mut rpm, mut rpm_per_s) = (0.0_f64, 0.0_f64);
        let step = window as isize;
        for cycle in -step..=(positions.len() as isize) {
            let (before, here, after) = (at(cycle - step), at(cycle), at(cycle + step));
            rpm = rpm.max((after - here).abs() / window_s * 60.0);
            let change = (after - here) - (here - before);
            rpm_per_s = rpm_per_s.max(change.abs() / (window_s * window_s) * 60.0);
        }
        let turns = positions.iter().map(|&counts| f64::from(counts) / turn);
        let steps = positions.windows(2).map(|pair| pair[0].abs_diff(pair[1]));
        Self {
            rpm,
            rpm_per_s,
            min_turns: turns.clone().fold(0.0, f64::min),
            max_turns: turns.fold(0.0, f64::max),
            largest_step: steps.max().unwrap_or(0),
        }
    }
}

impl Needs {
    /// What both need.
    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            rpm: self.rpm.max(other.rpm),
            rpm_per_s: self.rpm_per_s.max(other.rpm_per_s),
            min_turns: self.min_turns.min(other.min_turns),
            max_turns: self.max_turns.max(other.max_turns),
            largest_step: self.largest_step.max(other.largest_step),
        }
    }

    /// The same motion, played so many times as fast at most: its axes may take larger steps.
    pub(crate) fn at_rate(self, rate: f64) -> Self {
        Self {
            largest_step: (f64::from(self.largest_step) * rate).ceil() as u32,
            ..self
        }
    }
}

impl MotionLimits {
    /// Everything that these limits allow, for a motion that is not known yet.
    pub(crate) fn as_needs(&self, gear: GearNumber, cycle_us: u32) -> Needs {
        let (velocity, _) = per_cycle(self.max_rpm, self.max_acceleration, gear, cycle_us);
        Needs {
            rpm: self.max_rpm,
            rpm_per_s: self.max_acceleration,
            min_turns: -self.max_turns,
            max_turns: self.max_turns,
            // What rounding to whole counts may add.
            largest_step: (velocity as u32).saturating_add(1),
        }
    }

    /// What an axis has left of its limits for another speed of its motion.
    pub(crate) fn headroom(&self, needs: &Needs, gear: GearNumber, cycle_us: u32) -> AxisHeadroom {
        let (velocity, acceleration) =
            per_cycle(self.max_rpm, self.max_acceleration, gear, cycle_us);
        let (needed_velocity, needed_acceleration) =
            per_cycle(needs.rpm, needs.rpm_per_s, gear, cycle_us);
        AxisHeadroom {
            velocity,
            acceleration,
            needed_velocity,
            needed_acceleration,
        }
    }

    /// The limits of an axis that is streamed to, around where it stands; `max_jerk` is in r/min per second².
    ///
    /// # Errors
    /// When they are outside of what a trajectory can have.
    pub(crate) fn of_stream(
        &self,
        gear: GearNumber,
        cycle_us: u32,
        max_jerk: Option<f64>,
    ) -> Result<AxisLimits, RangeError> {
        let (velocity, acceleration) =
            per_cycle(self.max_rpm, self.max_acceleration, gear, cycle_us);
        let (velocity, acceleration) = (velocity as f32, acceleration as f32);
        let turn = f64::from(units::command_counts_per_turn(gear));
        let cycle_s = f64::from(cycle_us) * 1e-6;
        let motion = match max_jerk {
            Some(jerk) => {
                let jerk = jerk / 60.0 * turn * cycle_s.powi(3);
                trajectory::Limits::new(velocity, acceleration, jerk as f32)
            }
            None => trajectory::Limits::without_jerk(velocity, acceleration),
        };
        // Behind the largest there is nothing to keep from.
        let end = Position::from_counts((self.max_turns * turn) as i32);
        Ok(AxisLimits {
            motion: motion?,
            lowest: Position::ZERO.distance_from(end),
            highest: end,
        })
    }

    /// Speed, acceleration and way of a motion against their limits.
    pub(crate) fn quantities(&self, needs: &Needs) -> [LimitedQuantity; 3] {
        let farthest = needs.max_turns.max(-needs.min_turns);
        let quantity = |name, unit, option, needs, allowed| LimitedQuantity {
            name,
            unit,
            option,
            needs,
            allowed,
        };
        [
            quantity("speed", "r/min", "--max-rpm", needs.rpm, self.max_rpm),
            quantity(
                "acceleration",
                "r/min per second",
                "--max-acceleration",
                needs.rpm_per_s,
                self.max_acceleration,
            ),
            quantity(
                "way",
                "turns of its motor",
                "--max-turns",
                farthest,
                self.max_turns,
            ),
        ]
    }

    /// Every limit that a motion exceeds.
    pub(crate) fn exceeded(
        &self,
        drive: DriveId,
        needs: &Needs,
    ) -> impl Iterator<Item = LimitError> + use<> {
        let quantities = self.quantities(needs).into_iter();
        quantities
            .filter(|quantity| quantity.needs > quantity.allowed)
            .map(move |quantity| LimitError { drive, quantity })
    }

    /// Refuses a motion that needs more than is allowed.
    pub(crate) fn check(&self, drive: DriveId, needs: &Needs) -> Result<(), LimitError> {
        self.exceeded(drive, needs).next().map_or(Ok(()), Err)
    }

    /// The limits of an axis that stands at this position: an axis that is behind catches up a quarter faster than the motion is.
    pub(crate) fn of_axis(
        &self,
        needs: &Needs,
        position_counts: i32,
        gear: GearNumber,
        cycle_us: u32,
    ) -> Limits {
        // The check of the motion is before: what does not fit is a motion that was refused.
        let step = i32::try_from(needs.largest_step).unwrap_or(i32::MAX);
        let max_step =
            StepLimit::new(step.saturating_add(step / 4).max(1)).unwrap_or(StepLimit::MAX);
        let turn = f64::from(units::command_counts_per_turn(gear));
        let counts = |turns: f64| position_counts.saturating_add((turns * turn).round() as i32);
        let travel = Travel {
            min_counts: counts(needs.min_turns - MARGIN_TURNS),
            max_counts: counts(needs.max_turns + MARGIN_TURNS),
        };
        let limits = Limits::new(
            max_step,
            step_change(self.max_acceleration, turn, cycle_us),
            travel,
        );
        Limits {
            // What a pause of this computer may leave owing.
            backlog_counts: limits
                .backlog_counts
                .saturating_add(u32::from(max_step.get()) * (STUCK_US / cycle_us)),
            ..limits
        }
    }

    /// The limits of a move by hand, whose way is checked on the command line.
    pub(crate) const fn of_jog(rpm: f64, rpm_per_s: f64) -> Self {
        Self {
            max_rpm: rpm,
            max_acceleration: rpm_per_s,
            max_turns: f64::INFINITY,
        }
    }

    /// The fastest change of speed, in r/min per second.
    pub(crate) fn acceleration_rpm_per_s(&self) -> f64 {
        self.max_acceleration
    }
}

impl fmt::Display for MotionLimits {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (rpm, rpm_per_s, turns) = (self.max_rpm, self.max_acceleration, self.max_turns);
        write!(
            f,
            "at most {rpm} r/min, {rpm_per_s} r/min per second and {turns} turns from where a motor stands; without a set-point for {} ms it ends",
            STUCK_US / 1_000
        )
    }
}

/// Speed and acceleration of a motor in counts per cycle, and per cycle and cycle.
fn per_cycle(rpm: f64, rpm_per_s: f64, gear: GearNumber, cycle_us: u32) -> (f64, f64) {
    let turn = f64::from(units::command_counts_per_turn(gear));
    let cycle_s = f64::from(cycle_us) * 1e-6;
    (
        rpm / 60.0 * turn * cycle_s,
        rpm_per_s / 60.0 * turn * cycle_s * cycle_s,
    )
}

/// An acceleration in command counts per cycle and cycle.
fn step_change(rpm_per_s: f64, turn: f64, cycle_us: u32) -> StepChange {
    let cycle_s = f64::from(cycle_us) * 1e-6;
    let per_256 = rpm_per_s / 60.0 * turn * cycle_s * cycle_s * 256.0;
    // Larger than the largest is the largest: a cycle so long takes the whole step at once.
    StepChange::from_256ths((per_256 as u32).max(1)).unwrap_or(StepChange::MAX)
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() && number > 0.0 => Ok(number),
        _ => Err(format!("must be a number above 0, got {text}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GEAR: GearNumber = match GearNumber::new(4_096) {
        Ok(gear) => gear,
        Err(_) => panic!("a gear number"),
    };
    const LIMITS: MotionLimits = MotionLimits {
        max_rpm: 300.0,
        max_acceleration: 3_000.0,
        max_turns: 10.0,
    };

    /// A second at constant acceleration, then a second at constant speed.
    fn ramp(rpm: f64) -> Vec<i32> {
        let turns = |ms: i32| {
            let s = f64::from(ms) / 1_000.0;
            let accelerating = s.min(1.0);
            rpm / 60.0 * (accelerating * accelerating / 2.0 + (s - accelerating))
        };
        (0..2_000)
            .map(|ms| (turns(ms) * 16_384.0).round() as i32)
            .collect()
    }

    #[test]
    fn speed_acceleration_and_way_are_those_of_the_motor() {
        let mut positions = ramp(60.0);
        // Down again, so that the end is at rest: the sudden end alone would be an acceleration.
        let top = positions.last().copied().unwrap();
        let down: Vec<i32> = positions
            .iter()
            .rev()
            .skip(1)
            .map(|counts| 2 * top - counts)
            .collect();
        positions.extend(down);
        let needs = Needs::of(&positions, GEAR, 1_000);
        assert!((needs.rpm - 60.0).abs() < 0.5, "{needs:?}");
        assert!((needs.rpm_per_s - 60.0).abs() < 25.0, "{needs:?}");
        assert!((needs.max_turns - 3.0).abs() < 0.01, "{needs:?}");
        assert_eq!(LIMITS.check(DriveId::MIN, &needs), Ok(()));
    }

    #[test]
    fn each_limit_is_refused_with_its_option() {
        let refused = |positions: &[i32]| {
            let needs = Needs::of(positions, GEAR, 1_000);
            LIMITS.check(DriveId::MIN, &needs).unwrap_err().to_string()
        };
        let fast: Vec<i32> = (0..500).map(|ms| ms * 100).collect();
        assert!(
            refused(&fast).contains("drive 1 needs a speed of"),
            "{}",
            refused(&fast)
        );
        assert!(
            refused(&fast).contains("allow it with --max-rpm 366"),
            "{}",
            refused(&fast)
        );
        // 240 r/min from one cycle to the next are 12000 r/min per second over 20 ms.
        let sudden: Vec<i32> = (0..500).map(|ms| ms * 66).collect();
        assert!(
            refused(&sudden).contains("--max-acceleration 12"),
            "{}",
            refused(&sudden)
        );
        let far: Vec<i32> = ramp(299.0)
            .into_iter()
            .flat_map(|counts| [counts, counts])
            .collect();
        let far: Vec<i32> = far
            .iter()
            .chain(
                &far.iter()
                    .map(|counts| counts - 200_000)
                    .collect::<Vec<_>>(),
            )
            .copied()
            .collect();
        let needs = Needs {
            rpm: 1.0,
            rpm_per_s: 1.0,
            ..Needs::of(&far, GEAR, 1_000)
        };
        let error = LIMITS.check(DriveId::MIN, &needs).unwrap_err().to_string();
        assert!(error.contains("--max-turns 12.2"), "{error}");
    }

    #[test]
    fn an_axis_gets_the_travel_of_its_motion_around_where_it_stands() {
        let needs = Needs::of(&[0, 40, 80, 4_096], GEAR, 1_000);
        let limits = LIMITS.of_axis(&needs, 100_000, GEAR, 1_000);
        assert_eq!(
            (limits.travel.min_counts, limits.travel.max_counts),
            (99_181, 104_915)
        );
        assert_eq!(limits.max_step.get(), 4_016 + 1_004);
        // 3000 r/min per second are 819,200 counts per second squared, 0.8192 per cycle squared.
        assert_eq!(limits.max_step_change.per_256_cycles(), 209);
        assert!(limits.backlog_counts > 500 * 5_020);
    }
}
