//! Why a configuration is refused.

use core::fmt;

use bus_plan::{Refusal, Remedies};
use can_frame::BitRate;
use dyn_can::DriveId;

use crate::servo::poll_kind::PollKind;

/// A configuration that cannot work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ConfigError {
    /// No axis, or more than the master has room for.
    #[error("this master holds 1 to {most} axes, got {actual}")]
    AxisCount {
        /// The most that this master holds: its const parameter, at most the 63 drives that a bus can carry.
        most: usize,
        /// The number of axes given.
        actual: usize,
    },
    /// The axes are not in ascending order of drive id, which is the order of their set-points on the wire, or a
    /// drive is given twice.
    #[error(
        "list the axes in ascending order of drive id, each once: drive {drive} is not above the one before it"
    )]
    Order {
        /// The drive that is not above the one before it.
        drive: DriveId,
    },
    /// The cycle is outside 250 ..= 1_000_000 us.
    #[error("the cycle must be 250..=1000000 us, got {actual_us}")]
    Cycle {
        /// The cycle given.
        actual_us: u32,
    },
    /// A bit rate that no DYN drive knows.
    #[error("DYN drives know 10, 20, 50, 125, 250, 500, 800 and 1000 kbit/s, not {}", .actual.kbit_per_s())]
    BitRate {
        /// The bit rate given.
        actual: BitRate,
    },
    /// No request may go out in a cycle, so no drive could ever be probed.
    #[error("requests_per_cycle must be at least 1")]
    NoRequests,
    /// A waiting time cannot work with the others or with the cycle.
    #[error("{name} must be at least {least}, got {actual}")]
    Timeout {
        /// The field of [`Timeouts`](crate::servo::Timeouts).
        name: &'static str,
        /// The least that works, in the unit of the field.
        least: u32,
        /// The value given.
        actual: u32,
    },
    /// A waiting time is longer than the master keeps points in time.
    #[error("{name} must be at most {most_us} us, about 18 minutes, got {actual_us} us")]
    LongWait {
        /// The field of [`Timeouts`](crate::servo::Timeouts).
        name: &'static str,
        /// The longest.
        most_us: u32,
        /// The value given.
        actual_us: u32,
    },
    /// The travel of an axis is empty or leaves the 28 bit of the protocol.
    #[error("travel of drive {drive} must be a range within -2^27..2^27-1, got {min}..={max}")]
    Travel {
        /// The drive of the axis.
        drive: DriveId,
        /// The smallest target given.
        min: i32,
        /// The largest target given.
        max: i32,
    },
    /// The backlog of an axis is smaller than one step, so that it would fault in normal motion.
    #[error(
        "backlog_counts of drive {drive} must be at least one step of {max_step} counts, got {actual}"
    )]
    Backlog {
        /// The drive of the axis.
        drive: DriveId,
        /// The largest step.
        max_step: u16,
        /// The backlog given.
        actual: u32,
    },
    /// The tolerance at standstill is wider than the one in motion.
    #[error(
        "drift_tolerance_counts of drive {drive} must be at most following_error_counts, {following_error}, got {actual}"
    )]
    Tolerance {
        /// The drive of the axis.
        drive: DriveId,
        /// The tolerance in motion.
        following_error: u32,
        /// The tolerance at standstill.
        actual: u32,
    },
    /// The status of a drive is not polled, and the axis is not declared as unwatched.
    #[error(
        "poll the status of drive {drive}, or set unwatched: without polls nobody notices that it left the bus or lost its power"
    )]
    Unwatched {
        /// The drive of the axis.
        drive: DriveId,
    },
    /// A part of the read-back scale is 0.
    #[error("both parts of read_back of drive {drive} must be at least 1")]
    ReadBack {
        /// The drive of the axis.
        drive: DriveId,
    },
    /// Positions within the travel leave the 28 bit of the read-back, where what the drive reports is not stated (D17).
    #[error(
        "position {actual} of drive {drive} reads back as more than {most} counts: narrow its travel, or correct read_back"
    )]
    ReadBackRange {
        /// The drive of the axis.
        drive: DriveId,
        /// The most read-back counts that the protocol carries in either direction.
        most: i32,
        /// The end of the travel, in command counts, that reads back as more.
        actual: i32,
    },
    /// A poll is due more than once a cycle, or less than once in 65535 cycles.
    #[error(
        "polls of the {kind} of drive {drive} must be 1 to 65535 cycles apart, got {actual_us} us"
    )]
    PollPeriod {
        /// The drive of the axis.
        drive: DriveId,
        /// The poll.
        kind: PollKind,
        /// The period given.
        actual_us: u32,
    },
    /// The bus cannot carry these axes in time.
    #[error(fmt = plan)]
    Plan {
        /// The frame that is late, or what cannot be on one bus at all.
        refusal: Refusal,
        /// What would help.
        remedies: Remedies,
    },
}

fn plan(refusal: &Refusal, remedies: &Remedies, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    write!(f, "{refusal}")?;
    if refusal.is_about_time() {
        write!(f, "; {remedies}")?;
    }
    Ok(())
}
