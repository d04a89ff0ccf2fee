//! What the application decides before anything moves, validated once.

mod error;
mod limits;
mod poll_periods;
mod read_back;
mod timeouts;
mod validate;

use bus_plan::BusSetup;
use dyn_can::{Dialect, DriveId, GearNumber, ParamGroup2, Revision};

pub use error::ConfigError;
pub use limits::{Limits, LimitsError, MotorLimits, StepChange, Travel};
pub use poll_periods::PollPeriods;
pub use read_back::ReadBackScale;
pub use timeouts::Timeouts;

use crate::core::family::{CycleConfig, GroupId, STUCK_CYCLES};
use crate::servo::fault::Reactions;
use crate::servo::procedure::WearLimits;

/// Settings of the whole master.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct MasterConfig {
    /// Time from one cycle to the next in microseconds, 250 ..= 1_000_000.
    pub cycle_us: u32,
    /// Requests that may go out in one cycle, at least 1. The bus plan decides how many fit.
    pub requests_per_cycle: u8,
    /// Waiting times.
    pub timeouts: Timeouts,
    /// The bus: bit rate, order of transmission, and how long the drives take to answer. The plan is made for it.
    pub bus: BusSetup,
}

impl MasterConfig {
    /// 1 kHz, one request a cycle, default waiting times, 1 Mbit/s.
    pub const DEFAULT: Self = Self {
        cycle_us: 1_000,
        requests_per_cycle: 1,
        timeouts: Timeouts::DEFAULT,
        bus: BusSetup::DEFAULT,
    };
}

impl Default for MasterConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

impl CycleConfig for MasterConfig {
    fn cycle_us(&self) -> u32 {
        self.cycle_us
    }

    fn requests_per_cycle(&self) -> u8 {
        self.requests_per_cycle
    }

    fn stuck_us(&self) -> u32 {
        self.timeouts
            .stuck_us
            .max(STUCK_CYCLES.saturating_mul(self.cycle_us))
    }

    fn confirm_us(&self) -> u32 {
        self.timeouts.confirm_us
    }

    fn standstill_limit_us(&self) -> u32 {
        self.timeouts.standstill_limit_us
    }
}

/// Where a drive's revision comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum DialectChoice {
    /// The user knows it.
    Fixed(Dialect),
    /// The preset of the revision that the length of the Read_Param_Group3 reply tells (D62).
    Detect,
}

/// Settings of one axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisConfig {
    /// The drive.
    pub drive: DriveId,
    /// The gear number that the drive must have: it makes command counts an angle. One with another number is refused before anything
    /// moves.
    pub gear: GearNumber,
    /// How the drive reads the documents.
    pub dialect: DialectChoice,
    /// Axes that stop together.
    pub group: GroupId,
    /// Limits of motion.
    pub limits: Limits,
    /// What to read and how often.
    pub polls: PollPeriods,
    /// Nobody watches the drive while it moves: its status is not polled, so that a drive that left the bus, lost its power or reports
    /// an alarm by its status only is not noticed.
    pub unwatched: bool,
    /// Unit of the read-back.
    pub read_back: ReadBackScale,
    /// Maximum speed and acceleration of the drive (parameter group 2), where they are known to be these; `None`: they are read by
    /// [`Procedure::ReadGroup2`](crate::Procedure::ReadGroup2), which counts in any case, before the drive moves by itself.
    pub drive_curve: Option<ParamGroup2>,
    /// A load hangs on the axis that falls without power: its drive must operate a brake (on-position range 127, D54), or the axis is
    /// not enabled.
    pub load_can_fall: bool,
    /// What each fault does.
    pub reactions: Reactions,
    /// How much its procedures may wear the drive.
    pub wear: WearLimits,
}

impl AxisConfig {
    /// A drive with its gear number and the limits of its axis; detected revision, group 0, status and position at 50 Hz, read-back in
    /// command counts.
    #[must_use]
    pub const fn new(drive: DriveId, gear: GearNumber, limits: Limits) -> Self {
        Self {
            drive,
            gear,
            dialect: DialectChoice::Detect,
            group: GroupId(0),
            limits,
            polls: PollPeriods::DEFAULT,
            unwatched: false,
            read_back: ReadBackScale::COMMAND_COUNTS,
            drive_curve: None,
            load_can_fall: false,
            reactions: Reactions::DEFAULT,
            wear: WearLimits::DEFAULT,
        }
    }

    pub(crate) fn initial_dialect(&self) -> Dialect {
        match self.dialect {
            DialectChoice::Fixed(dialect) => dialect,
            // Everything asked before the revision is known reads the same in both.
            DialectChoice::Detect => Dialect::of(Revision::V1_6A),
        }
    }
}

/// An axis without limits of its own, for tests.
#[cfg(test)]
pub(crate) fn test_axis(drive: i32) -> AxisConfig {
    let limits = Limits::new(dyn_can::StepLimit::MAX, StepChange::MAX, Travel::WHOLE);
    let gear = GearNumber::new(4_096).expect("a gear number");
    AxisConfig::new(DriveId::new(drive).expect("a drive id"), gear, limits)
}
