//! Why a configuration is refused.

use core::fmt;

use bus_plan::analysis::Response;
use can_frame::BitRate;
use zlac8030l::NodeId;

/// A configuration that cannot work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum WheelConfigError {
    /// No wheel, or more than the master has room for.
    #[error("this master holds 1 to {most} wheels, got {actual}")]
    AxisCount {
        /// The most that this master holds.
        most: usize,
        /// The number of wheels given.
        actual: usize,
    },
    /// The wheels are not in ascending order of node, or a node is given twice.
    #[error(
        "list the wheels in ascending order of node, each once: node {node} is not above the one before it"
    )]
    Order {
        /// The node that is not above the one before it.
        node: NodeId,
    },
    /// The cycle is outside 1_000 ..= 1_000_000 us.
    #[error("the cycle must be 1000..=1000000 us, got {actual_us}")]
    Cycle {
        /// The cycle given.
        actual_us: u32,
    },
    /// A bit rate that the drives do not know.
    #[error("ZLAC8030L drives know 100, 125, 250, 500 and 1000 kbit/s, not {}", .actual.kbit_per_s())]
    BitRate {
        /// The bit rate given.
        actual: BitRate,
    },
    /// No request may go out in a cycle, so no drive could ever be set up.
    #[error("requests_per_cycle must be at least 1")]
    NoRequests,
    /// A waiting time cannot work with the others or with the cycle.
    #[error("{name} must be at least {least}, got {actual}")]
    Timeout {
        /// The field of [`WheelTimeouts`](super::WheelTimeouts).
        name: &'static str,
        /// The least that works, in the unit of the field.
        least: u32,
        /// The value given.
        actual: u32,
    },
    /// A waiting time is longer than the master keeps points in time.
    #[error("{name} must be at most {most_us} us, about 18 minutes, got {actual_us} us")]
    LongWait {
        /// The field of [`WheelTimeouts`](super::WheelTimeouts).
        name: &'static str,
        /// The longest.
        most_us: u32,
        /// The value given.
        actual_us: u32,
    },
    /// The targets of a wheel are an empty range, or leave the range of the object: 1000 r/min, or 3FFFFFFFh counts (Z39).
    #[error("targets of node {node} must be a range within -{most}..={most}, got {min}..={max}")]
    Range {
        /// The node.
        node: NodeId,
        /// The largest target either way that the object holds.
        most: i32,
        /// The smallest target given.
        min: i32,
        /// The largest target given.
        max: i32,
    },
    /// The bus cannot carry these wheels: a frame may come too late.
    #[error(fmt = late)]
    Late {
        /// Which kind of frame.
        frame: &'static str,
        /// Its worst case.
        response: Response,
    },
    /// A setting is outside its range: `speed_resolution` 1 ..= 10, `profile_speed_rpm` 1 ..= 1000, `max_step` and `max_step_change`
    /// 1 ..= 1,000,000 (beyond, the wheel could never move, never stop, or not be stopped in time), the stop options 605Ah 5 ..= 7,
    /// 605Bh and 605Ch 0 ..= 1, 605Dh 0 ..= 3, the times `ramp_ms`, `emergency_ms` and `offline_ms` up to 32,767 as in the drive, and
    /// `health_us` from 3 us on, or nothing else would have its turn.
    #[error("{name} of node {node} must be {least}..={most}, got {actual}")]
    Setting {
        /// The node.
        node: NodeId,
        /// The field, or the object.
        name: &'static str,
        /// The smallest value.
        least: i64,
        /// The largest value.
        most: i64,
        /// The value given.
        actual: i64,
    },
}

fn late(frame: &str, response: &Response, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    write!(f, "a {frame} frame may be late: ")?;
    match response.bits {
        Some(bits) => write!(f, "it takes up to {bits} bit times")?,
        None => f.write_str("the bus carries more than it can")?,
    }
    write!(
        f,
        ", its deadline is {}: use a longer cycle, a higher bit rate, slower feedback or fewer requests",
        response.deadline_bits
    )
}
