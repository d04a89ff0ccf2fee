//! Settings of a bus with wheels.

use core::fmt;

use zlac8030l::{Firmware, NodeId, SdoQuirks, SdoTimeouts};

use super::fault::WheelReactions;
use crate::config::GroupId;
use crate::plan::{BitRate, wire};

/// Data bytes of the frames of one wheel in a cycle: command, status, position, and at times a heartbeat.
const CYCLE_BYTES: [u8; 4] = [6, 8, 6, 1];
/// Data bytes of an SDO frame.
const SDO_BYTES: u8 = 8;

/// Settings of the whole bus.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelMasterConfig {
    /// Period of the cycle in microseconds, 1_000 ..= 1_000_000.
    pub cycle_us: u32,
    /// SDO and NMT frames that may go out in one cycle, at least 1.
    pub requests_per_cycle: u8,
    /// Bit rate of the bus: the frames of a cycle must fit.
    pub bit_rate: BitRate,
    /// When the drives send their feedback.
    pub feedback: FeedbackTiming,
    /// Waiting times.
    pub timeouts: WheelTimeouts,
}

impl WheelMasterConfig {
    /// 100 Hz at 500 kbit/s, one SDO request a cycle, feedback every 10 ms by the drives' timers.
    pub const DEFAULT: Self = Self {
        cycle_us: 10_000,
        requests_per_cycle: 1,
        bit_rate: BitRate::Kbit500,
        feedback: FeedbackTiming::Timer { ticks: 20 },
        timeouts: WheelTimeouts::DEFAULT,
    };
}

impl Default for WheelMasterConfig {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// When the drives send their feedback.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum FeedbackTiming {
    /// By their event timer (transmission type 255).
    Timer {
        /// Ticks of the timer. The guide counts 0.5 ms, CiA 301 counts 1 ms (Z11): measure one drive.
        ticks: u16,
    },
    /// After each SYNC (transmission type 1), which the master sends behind the targets of a cycle.
    Sync,
}

/// Waiting times. No document has figures; these are wide for a bus of 500 kbit/s.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelTimeouts {
    /// From the start to the first request, unless the drive announces itself before.
    pub power_on_us: u32,
    /// SDO transfers.
    pub sdo: SdoTimeouts,
    /// Heartbeat period that is set in the drives (1017h), in milliseconds.
    pub heartbeat_ms: u16,
    /// Time without heartbeat after which a drive is lost.
    pub heartbeat_lost_us: u32,
    /// Time without feedback after which a drive is lost.
    pub feedback_lost_us: u32,
    /// Time without the master after which a drive stops by itself (2000h, Z41), in milliseconds.
    pub offline_ms: u16,
    /// The wheel must have stood still this long before enabling.
    pub standstill_us: u32,
    /// How long to wait for that standstill.
    pub standstill_limit_us: u32,
    /// From a command to its confirmation in the feedback.
    pub confirm_us: u32,
    /// SDO timeouts in a row after which a drive is lost.
    pub lost_after: u8,
}

impl WheelTimeouts {
    /// The defaults.
    pub const DEFAULT: Self = Self {
        power_on_us: 1_000_000,
        sdo: SdoTimeouts::DEFAULT,
        heartbeat_ms: 100,
        heartbeat_lost_us: 350_000,
        feedback_lost_us: 100_000,
        offline_ms: 300,
        standstill_us: 100_000,
        standstill_limit_us: 5_000_000,
        confirm_us: 500_000,
        lost_after: 3,
    };
}

impl Default for WheelTimeouts {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// What a target is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum WheelMode {
    /// A speed, in 1/n r/min by [`WheelConfig::speed_resolution`] (mode 3, 60FFh).
    Velocity,
    /// An absolute position in counts (mode 1, 607Ah). The drive takes a target by an edge, so every second cycle.
    Position {
        /// Speed of the moves, r/min, 1 ..= 1000 (6081h).
        profile_speed_rpm: u16,
    },
}

/// Limits of one wheel, in the unit of its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelLimits {
    /// Smallest target.
    pub min: i32,
    /// Largest target.
    pub max: i32,
    /// Largest change of the value sent from one cycle to the next, at least 1: the acceleration limit of a speed, the
    /// velocity limit of a position.
    pub max_step: u32,
    /// Largest change of that change while ramping a position down, at least 1. Not used for speeds.
    pub ramp_change: u32,
    /// Distance in counts between the position sent and the position read beyond which a wheel in position mode faults.
    pub following_error: u32,
    /// Difference between the speed sent and the speed read, in 0.1 r/min, beyond which a wheel in velocity mode faults ...
    pub following_speed: u16,
    /// ... when it lasts so long, in microseconds: a wheel may need a moment to get there.
    pub following_speed_us: u32,
    /// Speed below which a wheel stands, in 0.1 r/min.
    pub standstill: u16,
}

impl WheelLimits {
    /// Speeds of the whole range of 60FFh at n = 1, changing by 10 r/min a cycle, at most 30 r/min off for half a second.
    pub const SPEED: Self = Self {
        min: -1_000,
        max: 1_000,
        max_step: 10,
        ramp_change: 1,
        following_error: u32::MAX,
        following_speed: 300,
        following_speed_us: 500_000,
        standstill: 10,
    };

    /// Absolute positions of the whole range of 607Ah (Z39), 400 counts a cycle, half a turn of following error.
    pub const POSITION: Self = Self {
        min: -0x3FFF_FFFF,
        max: 0x3FFF_FFFF,
        max_step: 400,
        ramp_change: 20,
        following_error: 2_048,
        following_speed: u16::MAX,
        following_speed_us: u32::MAX,
        standstill: 10,
    };
}

/// Settings of one wheel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelConfig {
    /// The drive.
    pub node: NodeId,
    /// Wheels that stop together.
    pub group: GroupId,
    /// What a target is.
    pub mode: WheelMode,
    /// Limits.
    pub limits: WheelLimits,
    /// n of 202Fh:05, 1 ..= 10: speeds count 1/n r/min. Compared and never written, because it needs saving and a restart.
    pub speed_resolution: u16,
    /// Time from standstill to full speed and back that the drive itself applies (6083h, 6084h), in milliseconds.
    pub ramp_ms: u16,
    /// The software version that was tried with these settings.
    pub firmware: Firmware,
    /// Wrong replies that are tolerated.
    pub quirks: SdoQuirks,
    /// What each fault does.
    pub reactions: WheelReactions,
}

impl WheelConfig {
    /// A wheel that follows speeds, in group 0.
    #[must_use]
    pub const fn new(node: NodeId) -> Self {
        Self {
            node,
            group: GroupId(0),
            mode: WheelMode::Velocity,
            limits: WheelLimits::SPEED,
            speed_resolution: 1,
            ramp_ms: 0,
            firmware: Firmware::Any,
            quirks: SdoQuirks {
                profile_speed_confirmed_as_sub_1: false,
            },
            reactions: WheelReactions::DEFAULT,
        }
    }
}

/// A configuration that cannot work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum WheelConfigError {
    /// No wheel, or more than the master has room for.
    AxisCount {
        /// The most that this master holds.
        most: usize,
        /// The number of wheels given.
        actual: usize,
    },
    /// The wheels are not in ascending order of node, or a node is given twice.
    Order {
        /// The node that is not above the one before it.
        node: NodeId,
    },
    /// The cycle is outside 1_000 ..= 1_000_000 us.
    Cycle {
        /// The cycle given.
        actual_us: u32,
    },
    /// No request may go out in a cycle, so no drive could ever be set up.
    NoRequests,
    /// A waiting time or the count of timeouts is 0.
    Timeout,
    /// The targets of a wheel are an empty range, or leave the range of the object: 1000 r/min, or 3FFFFFFFh counts (Z39).
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
    /// `max_step` or `ramp_change` is 0: the wheel could never move or never stop.
    Step {
        /// The node.
        node: NodeId,
    },
    /// The frames of a cycle do not fit into it at this bit rate, each taken at its longest.
    BusLoad {
        /// Bits of a cycle.
        cycle_bits: u32,
        /// Bits of its frames.
        needed_bits: u32,
    },
    /// `speed_resolution` is outside 1 ..= 10, or `profile_speed_rpm` outside 1 ..= 1000.
    Speed {
        /// The node.
        node: NodeId,
        /// The largest value.
        most: u16,
        /// The value given.
        actual: u16,
    },
}

impl fmt::Display for WheelConfigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::AxisCount { most, actual } => {
                write!(f, "this master holds 1 to {most} wheels, got {actual}")
            }
            Self::Order { node } => write!(
                f,
                "list the wheels in ascending order of node, each once: node {node} is not above the one before it"
            ),
            Self::Cycle { actual_us } => {
                write!(f, "the cycle must be 1000..=1000000 us, got {actual_us}")
            }
            Self::NoRequests => f.write_str("requests_per_cycle must be at least 1"),
            Self::Timeout => f.write_str("every waiting time must be at least 1"),
            Self::Range {
                node,
                most,
                min,
                max,
            } => write!(
                f,
                "targets of node {node} must be a range within -{most}..={most}, got {min}..={max}"
            ),
            Self::Step { node } => {
                write!(
                    f,
                    "max_step and ramp_change of node {node} must be at least 1"
                )
            }
            Self::BusLoad {
                cycle_bits,
                needed_bits,
            } => write!(
                f,
                "the frames of a cycle need {needed_bits} bits, a cycle has {cycle_bits}: use a longer cycle, a higher bit rate, or fewer requests"
            ),
            Self::Speed { node, most, actual } => {
                write!(
                    f,
                    "a speed setting of node {node} must be 1..={most}, got {actual}"
                )
            }
        }
    }
}

impl core::error::Error for WheelConfigError {}

impl WheelMasterConfig {
    pub(super) fn validate(
        &self,
        wheels: &[WheelConfig],
        room: usize,
    ) -> Result<(), WheelConfigError> {
        let actual = wheels.len();
        let most = room.min(usize::from(NodeId::MAX.get()));
        if actual == 0 || actual > most {
            return Err(WheelConfigError::AxisCount { most, actual });
        }
        if !(1_000..=1_000_000).contains(&self.cycle_us) {
            return Err(WheelConfigError::Cycle {
                actual_us: self.cycle_us,
            });
        }
        if self.requests_per_cycle == 0 {
            return Err(WheelConfigError::NoRequests);
        }
        self.timeouts.validate()?;
        for pair in wheels.windows(2) {
            if let [lower, upper] = pair
                && upper.node <= lower.node
            {
                return Err(WheelConfigError::Order { node: upper.node });
            }
        }
        wheels.iter().try_for_each(WheelConfig::validate)?;
        self.check_load(actual)
    }

    /// Every frame of a cycle at its longest, with a reply to each request, must fit.
    fn check_load(&self, wheels: usize) -> Result<(), WheelConfigError> {
        let bits = |bytes: u8| u32::from(wire::bound_bits(bytes));
        let wheel_bits: u32 = CYCLE_BYTES.iter().map(|bytes| bits(*bytes)).sum();
        // At most 127 wheels and 255 requests.
        let needed_bits = wheels as u32 * wheel_bits
            + 2 * u32::from(self.requests_per_cycle) * bits(SDO_BYTES)
            + bits(0);
        // kbit/s are bits in a millisecond; the cycle was checked to be at most a second.
        let cycle_bits = self.bit_rate.kbit_per_s() * (self.cycle_us / 1_000);
        if needed_bits > cycle_bits {
            return Err(WheelConfigError::BusLoad {
                cycle_bits,
                needed_bits,
            });
        }
        Ok(())
    }
}

impl WheelTimeouts {
    fn validate(&self) -> Result<(), WheelConfigError> {
        let waits = [
            self.sdo.reply_us,
            u32::from(self.heartbeat_ms),
            self.heartbeat_lost_us,
            self.feedback_lost_us,
            u32::from(self.offline_ms),
            self.standstill_limit_us,
            self.confirm_us,
            u32::from(self.lost_after),
        ];
        if waits.contains(&0) {
            return Err(WheelConfigError::Timeout);
        }
        Ok(())
    }
}

impl WheelConfig {
    /// The largest target either way.
    fn most(&self) -> i32 {
        match self.mode {
            WheelMode::Velocity => 1_000 * i32::from(self.speed_resolution),
            WheelMode::Position { .. } => zlac8030l::MoveKind::Absolute.limit(),
        }
    }

    fn validate(&self) -> Result<(), WheelConfigError> {
        let node = self.node;
        let WheelLimits { min, max, .. } = self.limits;
        let mut speeds = [(10, self.speed_resolution); 2];
        if let ([_, profile], WheelMode::Position { profile_speed_rpm }) = (&mut speeds, self.mode)
        {
            *profile = (1_000, profile_speed_rpm);
        }
        for (most, actual) in speeds {
            if actual == 0 || actual > most {
                return Err(WheelConfigError::Speed { node, most, actual });
            }
        }
        let most = self.most();
        if min > max || min < -most || max > most {
            return Err(WheelConfigError::Range {
                node,
                most,
                min,
                max,
            });
        }
        if self.limits.max_step == 0 || self.limits.ramp_change == 0 {
            return Err(WheelConfigError::Step { node });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wheel(node: i32) -> WheelConfig {
        WheelConfig::new(NodeId::new(node).unwrap())
    }

    fn refused(wheel: WheelConfig) -> WheelConfigError {
        WheelMasterConfig::DEFAULT
            .validate(&[wheel], 1)
            .unwrap_err()
    }

    #[test]
    fn what_cannot_work_is_refused() {
        let config = WheelMasterConfig::DEFAULT;
        assert_eq!(config.validate(&[wheel(1), wheel(2)], 2), Ok(()));
        let node = NodeId::new(1).unwrap();
        assert_eq!(
            config.validate(&[wheel(1), wheel(1)], 2),
            Err(WheelConfigError::Order { node })
        );
        assert_eq!(
            config.validate(&[], 2),
            Err(WheelConfigError::AxisCount { most: 2, actual: 0 })
        );
        let silent = WheelMasterConfig {
            timeouts: WheelTimeouts {
                offline_ms: 0,
                ..WheelTimeouts::DEFAULT
            },
            ..config
        };
        assert_eq!(
            silent.validate(&[wheel(1)], 1),
            Err(WheelConfigError::Timeout)
        );
    }

    #[test]
    fn a_cycle_that_is_too_short_for_its_frames_is_refused() {
        let config = WheelMasterConfig {
            cycle_us: 1_000,
            ..WheelMasterConfig::DEFAULT
        };
        // 55 + 10 n bits: 6, 8, 6 and 1 bytes of the wheel, two SDO frames, SYNC.
        let (cycle_bits, needed_bits) = (500, 755);
        assert_eq!(
            config.validate(&[wheel(1)], 1),
            Err(WheelConfigError::BusLoad {
                cycle_bits,
                needed_bits
            })
        );
        let fast = WheelMasterConfig {
            bit_rate: BitRate::Kbit1000,
            ..config
        };
        assert_eq!(fast.validate(&[wheel(1)], 1), Ok(()));
    }

    #[test]
    fn targets_stay_within_their_object() {
        let node = NodeId::new(1).unwrap();
        let mut fast = wheel(1);
        fast.limits.max = 1_001;
        assert_eq!(
            refused(fast),
            WheelConfigError::Range {
                node,
                most: 1_000,
                min: -1_000,
                max: 1_001
            }
        );
        fast.speed_resolution = 10;
        assert_eq!(WheelMasterConfig::DEFAULT.validate(&[fast], 1), Ok(()));
        fast.speed_resolution = 11;
        assert!(matches!(
            refused(fast),
            WheelConfigError::Speed { actual: 11, .. }
        ));
        let far = WheelConfig {
            mode: WheelMode::Position {
                profile_speed_rpm: 100,
            },
            limits: WheelLimits {
                max: 0x4000_0000,
                ..WheelLimits::POSITION
            },
            ..wheel(1)
        };
        assert!(matches!(refused(far), WheelConfigError::Range { .. }));
    }
}
