//! What the application decides before anything moves, validated once.

mod error;
mod limits;
mod poll_periods;
mod read_back;
mod timeouts;
mod validate;

use dyn_can::{Dialect, DriveId, Revision};

pub use error::ConfigError;
pub use limits::Limits;
pub use poll_periods::PollPeriods;
pub use read_back::ReadBackScale;
pub use timeouts::Timeouts;

use crate::fault::Reactions;
use crate::plan::BusSetup;
use crate::procedure::WearLimits;

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

/// Axes with the same group stop together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct GroupId(pub u8);

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
    /// How the drive reads the documents.
    pub dialect: DialectChoice,
    /// Axes that stop together.
    pub group: GroupId,
    /// Limits of motion.
    pub limits: Limits,
    /// What to read and how often.
    pub polls: PollPeriods,
    /// Unit of the read-back.
    pub read_back: ReadBackScale,
    /// What each fault does.
    pub reactions: Reactions,
    /// How much its procedures may wear the drive.
    pub wear: WearLimits,
}

impl AxisConfig {
    /// Defaults for a drive: detected revision, group 0, widest limits, status and position at 50 Hz.
    #[must_use]
    pub const fn new(drive: DriveId) -> Self {
        Self {
            drive,
            dialect: DialectChoice::Detect,
            group: GroupId(0),
            limits: Limits::WIDEST,
            polls: PollPeriods::DEFAULT,
            read_back: ReadBackScale::COMMAND_COUNTS,
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
