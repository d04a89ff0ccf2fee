//! What the settings become: the configuration of the master, and the limits of the link.

use board_link::AxisLimits;
use can_motion::family::Plan as _;
use can_motion::plan::{BitRate, BusPlan, BusSetup, ResponseWindow};
use can_motion::{
    AxisConfig, DialectChoice, GroupId, Limits, LimitsError, MasterConfig, PollPeriods,
    ReadBackScale, StepChange,
};
use dyn_can::units::command_counts_per_turn;
use dyn_can::{DriveId, GearNumber, StepLimit};
use heapless::Vec;
use trajectory::Position;

use crate::axis::{AxisSettings, Dialect, MotorLimits, Polls, ReadBack, Travel};
use crate::board::Board;
#[cfg(feature = "homing")]
use crate::configs_of_homing::{AxisHoming, check_pins};
use crate::refusal::{Kind, Refusal};
use crate::refusal_of_master::axis_count;
use crate::settings::{MOST_AXES, Settings};

/// A board that works: made of settings that were checked, the plan of the bus included.
#[derive(Debug, Clone)]
pub struct Configs {
    /// The master.
    pub master: MasterConfig,
    /// Its axes.
    pub axes: Vec<AxisConfig, MOST_AXES>,
    /// The limits of the axes for what comes over the link. They are those of the master: whole counts and 1/256 counts per cycle,
    /// rounded down.
    pub limits: Vec<AxisLimits, MOST_AXES>,
    /// An enable input is connected.
    pub enable_fitted: bool,
    /// How the axes find their origins. One that does has a master with the widest travel; its limits count from its origin.
    #[cfg(feature = "homing")]
    pub homings: Vec<Option<AxisHoming>, MOST_AXES>,
}

impl Configs {
    /// The plan of the bus, which was made for the check too.
    #[must_use]
    pub fn plan(&self) -> BusPlan<'_> {
        BusPlan::new(&self.master, &self.axes)
    }
}

impl Settings {
    /// Whether these settings make a board that works, and what becomes of them: the same on a board and on a host.
    ///
    /// # Errors
    /// [`Refusal`]: the first thing that is wrong. Nothing is put into its range.
    pub fn configs(&self, board: &Board) -> Result<Configs, Refusal> {
        if let Some(control) = self.name.chars().find(|char| char.is_control()) {
            return Err(Kind::Name.because(0, u32::from(control).into()));
        }
        if self.axes.is_empty() {
            return Err(axis_count(0));
        }
        let master = self.master(board)?;
        let (mut axes, mut limits) = (Vec::new(), Vec::new());
        #[cfg(feature = "homing")]
        let mut homings = Vec::new();
        #[cfg(not(feature = "homing"))]
        if let Some(place) = self.axes.iter().position(|axis| axis.homing.is_some()) {
            return Err(Kind::NoHoming.at(place, 0, 1));
        }
        for (place, axis) in self.axes.iter().enumerate() {
            if axis.group != 0 {
                return Err(Kind::Group.at(place, 0, axis.group.into()));
            }
            let at_axis = |refusal| Refusal {
                axis: Some(place as u8),
                ..refusal
            };
            #[cfg_attr(not(feature = "homing"), allow(unused_mut))]
            let (mut config, limit) = axis.config(board.cycle_us).map_err(at_axis)?;
            #[cfg(feature = "homing")]
            {
                let homing = axis.homing_of(&mut config, board);
                // As below.
                let _ = homings.push(homing.map_err(at_axis)?);
            }
            // Both lists have the room of the settings.
            let _ = axes.push(config);
            let _ = limits.push(limit);
        }
        self.check_order()?;
        #[cfg(feature = "homing")]
        check_pins(&homings, board)?;
        let configs = Configs {
            master,
            axes,
            limits,
            enable_fitted: self.inputs.enable_fitted,
            #[cfg(feature = "homing")]
            homings,
        };
        let admitted = configs.plan().admit(MOST_AXES);
        admitted.map_err(|error| Refusal::of_master(&error, board.cycle_us, &configs.axes))?;
        Ok(configs)
    }

    fn master(&self, board: &Board) -> Result<MasterConfig, Refusal> {
        let kbit_per_s = self.bus.bit_rate_kbit_per_s;
        let bit_rate = BitRate::from_kbit_per_s(kbit_per_s.into())
            .ok()
            .filter(|rate| dyn_can::knows_bit_rate(*rate))
            .ok_or(Kind::BitRate.because(1_000, kbit_per_s.into()))?;
        if !board.bit_rates.contains(&bit_rate) {
            let fastest = board.bit_rates.last().map_or(0, |rate| rate.kbit_per_s());
            return Err(Kind::BoardBitRate.because(fastest.into(), kbit_per_s.into()));
        }
        Ok(MasterConfig {
            cycle_us: board.cycle_us,
            requests_per_cycle: self.bus.requests_per_cycle,
            bus: BusSetup {
                bit_rate,
                order: board.order,
                response: ResponseWindow {
                    min_us: self.bus.response_min_us,
                    max_us: self.bus.response_max_us,
                },
                ..BusSetup::DEFAULT
            },
            ..MasterConfig::DEFAULT
        })
    }

    /// Here and not only in the plan, because a drive that is there twice has two places.
    fn check_order(&self) -> Result<(), Refusal> {
        let pairs = self.axes.iter().zip(self.axes.iter().skip(1)).zip(1..);
        for ((lower, upper), place) in pairs {
            if upper.drive <= lower.drive {
                let next = i64::from(lower.drive) + 1;
                return Err(Kind::Order.at(place, next, upper.drive.into()));
            }
        }
        Ok(())
    }
}

impl AxisSettings {
    fn config(&self, cycle_us: u32) -> Result<(AxisConfig, AxisLimits), Refusal> {
        let drive = DriveId::new(self.drive.into())
            .map_err(|_| Kind::Drive.because(self.drive.clamp(1, 63).into(), self.drive.into()))?;
        let gear = GearNumber::new(self.gear.into()).map_err(|_| {
            Kind::Gear.because(self.gear.clamp(500, 16_384).into(), self.gear.into())
        })?;
        let limits = self.limits(gear, cycle_us)?;
        let config = AxisConfig {
            dialect: match self.dialect {
                Dialect::Detect => DialectChoice::Detect,
                Dialect::V1_2A => DialectChoice::Fixed(dyn_can::Dialect::V1_2A),
                Dialect::V1_6A => DialectChoice::Fixed(dyn_can::Dialect::V1_6A),
            },
            group: GroupId(self.group),
            polls: self.polls.periods(),
            unwatched: self.unwatched,
            read_back: self.read_back.scale(gear),
            load_can_fall: self.load_can_fall,
            ..AxisConfig::new(drive, gear, limits)
        };
        let link = self.link_limits(&limits, gear, cycle_us)?;
        Ok((config, link))
    }

    /// The homing, where there is one; the master is told of no other travel than what it can read back then.
    #[cfg(feature = "homing")]
    fn homing_of(
        &self,
        config: &mut AxisConfig,
        board: &Board,
    ) -> Result<Option<AxisHoming>, Refusal> {
        let Some(homing) = &self.homing else {
            return Ok(None);
        };
        let travel = config.limits.travel;
        let widest = can_motion::Travel::WHOLE;
        if travel.min_counts > travel.max_counts {
            return Err(Kind::Travel.because(travel.min_counts.into(), travel.max_counts.into()));
        }
        for end in [travel.min_counts, travel.max_counts] {
            let nearest = end.clamp(widest.min_counts, widest.max_counts);
            if nearest != end {
                return Err(Kind::Travel.because(nearest.into(), end.into()));
            }
        }
        let reach = widest_travel(config.read_back);
        let search = self.search(homing, config, reach, board)?;
        config.limits.travel = reach;
        Ok(Some(search))
    }

    fn limits(&self, gear: GearNumber, cycle_us: u32) -> Result<Limits, Refusal> {
        let motor = MotorLimits {
            speed_rpm: self.speed_rpm,
            acceleration_rpm_per_s: self.acceleration_rpm_per_s,
        };
        let travel = match self.travel {
            Travel::Counts { min, max } => can_motion::Travel {
                min_counts: min,
                max_counts: max,
            },
            Travel::Millidegrees { min, max } => {
                can_motion::Travel::of_motor_millidegrees(min, max, gear)
            }
        };
        let limits = Limits::of_motor(motor, travel, gear, cycle_us)
            .map_err(|error| self.of_limits(error, gear, cycle_us))?;
        Ok(Limits {
            following_error_counts: self
                .following_error_counts
                .unwrap_or(limits.following_error_counts),
            drift_tolerance_counts: self
                .drift_tolerance_counts
                .unwrap_or(limits.drift_tolerance_counts),
            ..limits
        })
    }

    /// The nearest value that is allowed.
    fn of_limits(&self, error: LimitsError, gear: GearNumber, cycle_us: u32) -> Refusal {
        // Counts in a minute for each r/min, times microseconds: at most 2^20 * 2^32. All is done with 64 bits: a processor of 32 has no
        // division of 128, which takes 1 KB.
        let per_rpm = u64::from(command_counts_per_turn(gear)).saturating_mul(cycle_us.into());
        let per_rpm = per_rpm.max(1);
        let second = 60_000_000_u64;
        match error {
            LimitsError::Speed { step_counts, .. } => {
                let least = second.div_ceil(per_rpm);
                let most = StepLimit::MAX.get();
                let most = ((u64::from(most) + 1) * second - 1) / per_rpm;
                let nearest = if step_counts == 0 { least } else { most };
                Kind::Speed.because(narrowed(nearest), self.speed_rpm.into())
            }
            LimitsError::Acceleration {
                least_rpm_per_s, ..
            } => {
                let given = u64::from(self.acceleration_rpm_per_s);
                // 16384 counts per cycle and cycle, in 256ths as rounded down; 256 is taken out of the square of a second, so that it fits.
                const SQUARE_OF_SECOND: u64 = 60_000_000 * 1_000_000 / 256;
                let largest = u64::from(StepChange::MAX.per_256_cycles()) + 1;
                let squared = per_rpm.saturating_mul(cycle_us.into());
                let most = (largest * SQUARE_OF_SECOND - 1) / squared.max(1);
                let nearest = if given < least_rpm_per_s {
                    least_rpm_per_s
                } else {
                    most
                };
                Kind::Acceleration.because(narrowed(nearest), self.acceleration_rpm_per_s.into())
            }
            _ => Kind::Master.because(0, 0),
        }
    }

    fn link_limits(
        &self,
        limits: &Limits,
        gear: GearNumber,
        cycle_us: u32,
    ) -> Result<AxisLimits, Refusal> {
        let velocity = limits.max_step.get() as f32;
        let acceleration = limits.max_step_change.per_256_cycles() as f32 / 256.0;
        let motion = match self.jerk_rpm_per_s2 {
            None => trajectory::Limits::without_jerk(velocity, acceleration),
            Some(jerk) => {
                let cycle_s = cycle_us as f32 * 1e-6;
                let jerk = jerk as f32 / 60.0 * command_counts_per_turn(gear) as f32;
                trajectory::Limits::new(velocity, acceleration, jerk * cycle_s * cycle_s * cycle_s)
            }
        };
        let travel = limits.travel;
        Ok(AxisLimits {
            motion: motion.map_err(|_| self.of_jerk(gear, cycle_us))?,
            lowest: Position::from_counts(travel.min_counts),
            highest: Position::from_counts(travel.max_counts),
        })
    }

    /// Speed and acceleration of a master are always within the range of a motion, so it is the jerk. The nearest value that is allowed,
    /// in whole r/min per second².
    fn of_jerk(&self, gear: GearNumber, cycle_us: u32) -> Refusal {
        let given = self.jerk_rpm_per_s2.unwrap_or_default();
        let cycle_s = cycle_us as f32 * 1e-6;
        let one = command_counts_per_turn(gear) as f32 / 60.0 * cycle_s * cycle_s * cycle_s;
        let (least, most) = trajectory::Limits::JERK;
        // A conversion to an integer cuts off.
        let (least, most) = ((least / one) as i64 + 1, (most / one) as i64);
        let given = i64::from(given);
        Kind::Jerk.because(if given < least { least } else { most }, given)
    }
}

impl Polls {
    const fn periods(&self) -> PollPeriods {
        const fn period(us: u32) -> Option<u32> {
            if us == 0 { None } else { Some(us) }
        }
        PollPeriods {
            status_us: period(self.status_us),
            position_us: period(self.position_us),
            torque_us: period(self.torque_us),
            speed_us: period(self.speed_us),
            counter_us: period(self.counter_us),
        }
    }
}

impl ReadBack {
    const fn scale(self, gear: GearNumber) -> ReadBackScale {
        match self {
            Self::CommandCounts => ReadBackScale::COMMAND_COUNTS,
            Self::MovementPositions => ReadBackScale::movement_positions(gear),
            Self::MotorSteps => ReadBackScale::motor_steps(gear),
            Self::Ratio {
                read_back_counts,
                command_counts,
            } => ReadBackScale {
                read_back_counts,
                command_counts,
            },
        }
    }
}

/// All positions that can be read back.
#[cfg(feature = "homing")]
fn widest_travel(read_back: ReadBackScale) -> can_motion::Travel {
    let most = i64::from(can_motion::Travel::WHOLE.max_counts);
    // A scale of 0 is refused by the master.
    let divisor = i64::from(read_back.read_back_counts).max(1);
    let reached = most * i64::from(read_back.command_counts) / divisor;
    let end = reached.min(most) as i32;
    can_motion::Travel {
        min_counts: -end,
        max_counts: end,
    }
}

fn narrowed(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}
