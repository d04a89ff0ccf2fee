//! What the application decides before anything moves, validated once.

use core::fmt;

use dyn_can::{Counts28, Dialect, DriveId, Revision, StepLimit};

use crate::fault::Reactions;
use crate::plan::{BusSetup, Refusal, Remedies};
use crate::polls::PollKind;
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

/// Waiting times in microseconds, each with the reason for its default.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Timeouts {
    /// From the start to the first request. The manual states 150 ms after power-on for pulse and analog commands;
    /// applied to CAN too (D58).
    pub power_on_us: u32,
    /// From a request to the end of waiting for its reply. The documents lost their figure (D65): 10 ms is longer than
    /// the worst response and queueing that were measured. After it the drive is not asked again for the same time.
    pub reply_us: u32,
    /// After a reply, before the next request to the same drive: a frame that CAN repeats follows at once, so one
    /// millisecond is enough to recognise it.
    pub settle_us: u32,
    /// After the first alarm frame of a drive, before the next request to any drive. Repeated alarm frames do not prolong it.
    pub alarm_quiet_us: u32,
    /// Without a step for this long, an axis should have arrived: from then on the drift tolerance applies.
    pub arrival_us: u32,
    /// The shaft must have stood still this long before enabling (D59; the documents lost their figure).
    pub standstill_us: u32,
    /// How long to wait for that standstill.
    pub standstill_limit_us: u32,
    /// From the enable or disable command to its confirmation in the status byte.
    pub confirm_us: u32,
    /// Timeouts in a row after which a drive is lost.
    pub lost_after: u8,
}

impl Timeouts {
    /// The defaults explained at each field.
    pub const DEFAULT: Self = Self {
        power_on_us: 150_000,
        reply_us: 10_000,
        settle_us: 1_000,
        alarm_quiet_us: 20_000,
        arrival_us: 200_000,
        standstill_us: 150_000,
        standstill_limit_us: 5_000_000,
        confirm_us: 200_000,
        lost_after: 3,
    };
}

impl Default for Timeouts {
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

/// Read-back counts per command count as a fraction (D44).
///
/// The documents do not state the unit of the read-back: command counts (16384 a turn at gear 4096) or encoder counts
/// (65536 a turn). Turn the shaft once by a command and compare before you trust either.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ReadBackScale {
    /// Read-back counts ...
    pub read_back_counts: u32,
    /// ... for this many command counts.
    pub command_counts: u32,
}

impl ReadBackScale {
    /// The drive reports command counts.
    pub const COMMAND_COUNTS: Self = Self {
        read_back_counts: 1,
        command_counts: 1,
    };
    /// The drive reports encoder counts, 65536 a turn, at gear number 4096.
    pub const ENCODER_COUNTS: Self = Self {
        read_back_counts: 4,
        command_counts: 1,
    };

    /// A read-back position in command counts, rounded to the nearest; `None` beyond 32 bit.
    #[must_use]
    pub fn to_command_counts(self, read_back: i32) -> Option<i32> {
        let (numerator, denominator) = (
            i64::from(self.command_counts),
            i64::from(self.read_back_counts),
        );
        let scaled = i64::from(read_back).checked_mul(numerator)?;
        let half = if scaled < 0 {
            -denominator / 2
        } else {
            denominator / 2
        };
        i32::try_from(scaled.checked_add(half)?.checked_div(denominator)?).ok()
    }

    /// Whether a position can be read back at all: within the 28 bit of the protocol (D16, D17).
    fn reaches(self, command_counts: i32) -> bool {
        let read_back = i64::from(command_counts) * i64::from(self.read_back_counts);
        let range = |end: i32| i64::from(end) * i64::from(self.command_counts);
        (range(Counts28::MIN.get())..=range(Counts28::MAX.get())).contains(&read_back)
    }
}

/// Limits of one axis, in command counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Limits {
    /// Largest step of one cycle: the velocity limit.
    pub max_step: StepLimit,
    /// Largest change of the step from one cycle to the next while ramping down, at least 1: the deceleration limit.
    pub ramp_change: u16,
    /// Smallest target, at least -2^27.
    pub travel_min: i32,
    /// Largest target, at most 2^27 - 1.
    pub travel_max: i32,
    /// Backlog beyond which the axis faults: how far the axis may fall behind its target.
    pub backlog: u32,
    /// Distance between sent position and read position beyond which a moving axis faults.
    pub following_error: u32,
    /// The same at standstill: an error that stays is a lost or doubled step.
    pub drift_tolerance: u32,
}

impl Limits {
    /// The whole 28-bit travel, 16384 counts (one turn) a cycle, eight full steps of backlog, the 8192 counts of
    /// following error after which a drive alarms by itself (section 6, #9), and 16 counts (0.35 degrees) of drift.
    pub const WIDEST: Self = Self {
        max_step: StepLimit::MAX,
        ramp_change: 64,
        travel_min: Counts28::MIN.get(),
        travel_max: Counts28::MAX.get(),
        backlog: 8 * 16_384,
        following_error: 8_192,
        drift_tolerance: 16,
    };
}

/// Periods of the polls of one axis in microseconds; `None` turns a poll off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PollPeriods {
    /// Status byte.
    pub status_us: Option<u32>,
    /// Position.
    pub position_us: Option<u32>,
    /// Torque.
    pub torque_us: Option<u32>,
    /// Motor speed.
    pub speed_us: Option<u32>,
    /// Diagnostic counter: shows that the drive lives and that it did not restart.
    pub counter_us: Option<u32>,
}

impl PollPeriods {
    /// Status and position at 50 Hz.
    pub const DEFAULT: Self = Self {
        status_us: Some(20_000),
        position_us: Some(20_000),
        torque_us: None,
        speed_us: None,
        counter_us: None,
    };

    /// No polls.
    pub const OFF: Self = Self {
        status_us: None,
        position_us: None,
        torque_us: None,
        speed_us: None,
        counter_us: None,
    };

    /// The period of one kind.
    #[must_use]
    pub const fn of(&self, kind: PollKind) -> Option<u32> {
        match kind {
            PollKind::Status => self.status_us,
            PollKind::Position => self.position_us,
            PollKind::Torque => self.torque_us,
            PollKind::Speed => self.speed_us,
            PollKind::Counter => self.counter_us,
        }
    }
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

/// A configuration that cannot work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConfigError {
    /// No axis, or more than the master has room for.
    AxisCount {
        /// The most that this master holds: its const parameter, at most the 63 drives that a bus can carry.
        most: usize,
        /// The number of axes given.
        actual: usize,
    },
    /// The axes are not in ascending order of drive id, which is the order of their set-points on the wire, or a
    /// drive is given twice.
    Order {
        /// The drive that is not above the one before it.
        drive: DriveId,
    },
    /// The cycle is outside 250 ..= 1_000_000 us.
    Cycle {
        /// The cycle given.
        actual_us: u32,
    },
    /// No request may go out in a cycle, so no drive could ever be probed.
    NoRequests,
    /// A waiting time or the count of timeouts is 0.
    Timeout,
    /// The travel of an axis is empty or leaves the 28 bit of the protocol.
    Travel {
        /// The drive of the axis.
        drive: DriveId,
        /// The smallest target given.
        min: i32,
        /// The largest target given.
        max: i32,
    },
    /// `Limits::ramp_change` is 0: the axis could never stop.
    RampChange {
        /// The drive of the axis.
        drive: DriveId,
    },
    /// A part of the read-back scale is 0.
    ReadBack {
        /// The drive of the axis.
        drive: DriveId,
    },
    /// Positions within the travel leave the 28 bit of the read-back, where what the drive reports is not stated (D17).
    ReadBackRange {
        /// The drive of the axis.
        drive: DriveId,
        /// The most read-back counts that the protocol carries in either direction.
        most: i32,
        /// The end of the travel, in command counts, that reads back as more.
        actual: i32,
    },
    /// A poll is due more than once a cycle.
    PollPeriod {
        /// The drive of the axis.
        drive: DriveId,
        /// The poll.
        kind: PollKind,
        /// The period given.
        actual_us: u32,
    },
    /// The bus cannot carry these axes in time.
    Plan {
        /// The frame that is late, or what cannot be on one bus at all.
        refusal: Refusal,
        /// What would help.
        remedies: Remedies,
    },
}

impl fmt::Display for ConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::AxisCount { most, actual } => {
                write!(f, "this master holds 1 to {most} axes, got {actual}")
            }
            Self::Order { drive } => {
                write!(
                    f,
                    "list the axes in ascending order of drive id, each once: drive {drive} is not above the one before it"
                )
            }
            Self::Cycle { actual_us } => {
                write!(f, "the cycle must be 250..=1000000 us, got {actual_us}")
            }
            Self::NoRequests => f.write_str("requests_per_cycle must be at least 1"),
            Self::Timeout => f.write_str("every waiting time must be at least 1"),
            Self::Travel { drive, min, max } => write!(
                f,
                "travel of drive {drive} must be a range within -2^27..2^27-1, got {min}..={max}"
            ),
            Self::RampChange { drive } => {
                write!(f, "ramp_change of drive {drive} must be at least 1")
            }
            Self::ReadBack { drive } => {
                write!(
                    f,
                    "both parts of read_back of drive {drive} must be at least 1"
                )
            }
            Self::ReadBackRange {
                drive,
                most,
                actual,
            } => write!(
                f,
                "position {actual} of drive {drive} reads back as more than {most} counts: narrow its travel, or correct read_back"
            ),
            Self::PollPeriod {
                drive,
                kind,
                actual_us,
            } => write!(
                f,
                "the {kind} poll of drive {drive} must be at least one cycle apart, got {actual_us} us"
            ),
            Self::Plan { refusal, remedies } => {
                write!(f, "{refusal}")?;
                if refusal.is_about_time() {
                    write!(f, "; {remedies}")?;
                }
                Ok(())
            }
        }
    }
}

impl core::error::Error for ConfigError {}

impl MasterConfig {
    pub(crate) fn validate(&self, axes: &[AxisConfig], room: usize) -> Result<(), ConfigError> {
        let most = room.min(usize::from(DriveId::MAX.get()));
        if axes.is_empty() || axes.len() > most {
            return Err(ConfigError::AxisCount {
                most,
                actual: axes.len(),
            });
        }
        if !(250..=1_000_000).contains(&self.cycle_us) {
            return Err(ConfigError::Cycle {
                actual_us: self.cycle_us,
            });
        }
        if self.requests_per_cycle == 0 {
            return Err(ConfigError::NoRequests);
        }
        let Timeouts {
            reply_us,
            settle_us,
            standstill_limit_us,
            confirm_us,
            lost_after,
            ..
        } = self.timeouts;
        if [
            reply_us,
            settle_us,
            standstill_limit_us,
            confirm_us,
            u32::from(lost_after),
        ]
        .contains(&0)
        {
            return Err(ConfigError::Timeout);
        }
        for pair in axes.windows(2) {
            if let [lower, upper] = pair
                && upper.drive <= lower.drive
            {
                return Err(ConfigError::Order { drive: upper.drive });
            }
        }
        axes.iter().try_for_each(|axis| self.validate_axis(axis))
    }

    fn validate_axis(&self, axis: &AxisConfig) -> Result<(), ConfigError> {
        let drive = axis.drive;
        let Limits {
            travel_min: min,
            travel_max: max,
            ramp_change,
            ..
        } = axis.limits;
        let widest = Limits::WIDEST;
        if min > max || min < widest.travel_min || max > widest.travel_max {
            return Err(ConfigError::Travel { drive, min, max });
        }
        if ramp_change == 0 {
            return Err(ConfigError::RampChange { drive });
        }
        if axis.read_back.read_back_counts == 0 || axis.read_back.command_counts == 0 {
            return Err(ConfigError::ReadBack { drive });
        }
        for end in [min, max] {
            if !axis.read_back.reaches(end) {
                return Err(ConfigError::ReadBackRange {
                    drive,
                    most: Counts28::MAX.get(),
                    actual: end,
                });
            }
        }
        for kind in PollKind::ALL {
            if let Some(actual_us) = axis.polls.of(kind)
                && actual_us < self.cycle_us
            {
                return Err(ConfigError::PollPeriod {
                    drive,
                    kind,
                    actual_us,
                });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(drive: i32) -> AxisConfig {
        AxisConfig::new(DriveId::new(drive).unwrap())
    }

    #[test]
    fn what_cannot_work_is_refused() {
        let config = MasterConfig::DEFAULT;
        assert_eq!(config.validate(&[axis(1), axis(2)], 4), Ok(()));
        assert_eq!(
            config.validate(&[], 4),
            Err(ConfigError::AxisCount { most: 4, actual: 0 })
        );
        let drive = DriveId::MIN;
        assert_eq!(
            config.validate(&[axis(1), axis(1)], 4),
            Err(ConfigError::Order { drive })
        );
        assert_eq!(
            config.validate(&[axis(2), axis(1)], 4),
            Err(ConfigError::Order { drive })
        );
        let mut often = axis(1);
        often.polls.status_us = Some(999);
        assert_eq!(
            config.validate(&[often], 4),
            Err(ConfigError::PollPeriod {
                drive,
                kind: PollKind::Status,
                actual_us: 999
            })
        );
        let mut wide = axis(1);
        wide.limits.travel_max = 1 << 27;
        assert!(matches!(
            config.validate(&[wide], 4),
            Err(ConfigError::Travel { .. })
        ));
        let mut fine = axis(1);
        fine.read_back = ReadBackScale::ENCODER_COUNTS;
        assert_eq!(
            config.validate(&[fine], 4),
            Err(ConfigError::ReadBackRange {
                drive,
                most: (1 << 27) - 1,
                actual: -(1 << 27)
            })
        );
        (fine.limits.travel_min, fine.limits.travel_max) = (-(1 << 25), (1 << 25) - 1);
        assert_eq!(config.validate(&[fine], 4), Ok(()));
        fine.limits.travel_max += 1;
        assert!(config.validate(&[fine], 4).is_err());
        let fast = MasterConfig {
            cycle_us: 249,
            ..config
        };
        assert_eq!(
            fast.validate(&[axis(1)], 4),
            Err(ConfigError::Cycle { actual_us: 249 })
        );
    }

    #[test]
    fn read_back_scales_and_rounds() {
        let scale = ReadBackScale::ENCODER_COUNTS;
        assert_eq!(scale.to_command_counts(400), Some(100));
        assert_eq!(scale.to_command_counts(402), Some(101));
        assert_eq!(scale.to_command_counts(-402), Some(-101));
        let huge = ReadBackScale {
            read_back_counts: 1,
            command_counts: u32::MAX,
        };
        assert_eq!(huge.to_command_counts(i32::MAX), None);
    }
}
