//! Settings of a bus with wheels.

mod error;
mod validate;

use can_frame::BitRate;
use zlac8030l::{Firmware, NodeId, SdoQuirks, SdoTimeouts};

pub use error::WheelConfigError;

use crate::core::family::{CycleConfig, GroupId, STUCK_CYCLES};
use crate::core::targets::ValueLimits;
use crate::wheel::fault::WheelReactions;

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

impl CycleConfig for WheelMasterConfig {
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
    /// For so long no frame of a wheel may get out before its group stops: then the bus is blocked or nobody is on it. At least five
    /// cycles are allowed in any case.
    pub stuck_us: u32,
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
        stuck_us: 20_000,
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
    /// A torque as a current in mA (mode 4 (Z4), 6071h). A wheel with little load speeds up until friction holds it: the master stops it
    /// beyond [`WheelLimits::following_speed`]. No torque is no stop, so every stop is a quick stop.
    Torque {
        /// Fastest change of the current in the drive, mA/s, 1 ..= 1,000,000 (6087h, Z26).
        slope_ma_s: u32,
    },
}

/// Limits of one wheel, in the unit of its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelLimits {
    /// Range of the targets, and how fast they may change: the acceleration limit of a speed, the velocity limit of a position and, while
    /// ramping down, its acceleration limit.
    pub values: ValueLimits,
    /// Distance in counts between the position sent and the position read beyond which a wheel in position mode faults.
    pub following_error: u32,
    /// Difference between the speed sent and the speed read, in 0.1 r/min, beyond which a wheel in velocity mode faults; in torque mode the
    /// speed itself. A wheel in velocity mode that turns half as fast again as its fastest target, and by this more, faults at once; ...
    pub following_speed: u16,
    /// ... when it lasts so long, in microseconds: a wheel may need a moment to get there.
    pub following_speed_us: u32,
    /// Speed below which a wheel stands, in 0.1 r/min.
    pub standstill: u16,
}

impl WheelLimits {
    /// Speeds up to this one either way, changing by so much in a cycle, both in 1/n r/min by [`WheelConfig::speed_resolution`]; at most
    /// 30 r/min off for half a second.
    #[must_use]
    pub const fn speed(max: u16, change: u32) -> Self {
        Self {
            values: ValueLimits::new(-(max as i32), max as i32, change, 1),
            following_error: u32::MAX,
            following_speed: 300,
            following_speed_us: 500_000,
            standstill: 10,
        }
    }

    /// Torques up to this one either way, changing by so much in a cycle, both in mA; at most so many r/min for 20 ms.
    #[must_use]
    pub const fn torque(max_ma: u16, change_ma: u32, most_rpm: u16) -> Self {
        Self {
            values: ValueLimits::new(-(max_ma as i32), max_ma as i32, change_ma, 1),
            following_error: u32::MAX,
            following_speed: most_rpm.saturating_mul(10),
            following_speed_us: 20_000,
            standstill: 10,
        }
    }

    /// Absolute positions in a range, at most so many counts in a cycle, changing by so many counts from cycle to cycle while ramping
    /// down; half a turn of following error.
    #[must_use]
    pub const fn position(min: i32, max: i32, max_step: u32, max_step_change: u32) -> Self {
        Self {
            values: ValueLimits::new(min, max, max_step, max_step_change),
            following_error: 2_048,
            following_speed: u16::MAX,
            following_speed_us: u32::MAX,
            standstill: 10,
        }
    }
}

/// When a wheel in position mode has arrived.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelArrival {
    /// How far from its target it may stand, in counts.
    pub within_counts: u32,
    /// How long it may take after the frame with its target, in microseconds; then
    /// [`WheelEventKind::NotArrived`](crate::wheel::WheelEventKind::NotArrived) says how far it is. `None`: as long as it takes.
    pub limit_us: Option<u32>,
}

impl WheelArrival {
    /// A hundredth of a turn with 1024 encoder lines, and no limit.
    pub const DEFAULT: Self = Self {
        within_counts: 41,
        limit_us: None,
    };
}

impl Default for WheelArrival {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// How often values are read that no PDO brings, in microseconds; `None` for never. They go out when nothing else waits for its transfer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelPolls {
    /// Temperatures of motor and driver (2026h) and bus voltage (2029h), one after the other: all of them in this time.
    pub health_us: Option<u32>,
}

impl WheelPolls {
    /// Nothing.
    pub const OFF: Self = Self { health_us: None };
}

/// What the stops of a wheel rely on in its drive: read before it is enabled, and written where it differs (2010h = 1: no wear).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct WheelStops {
    /// Quick stop option 605Ah: 5 normal, 6 fast, 7 emergency; energised in all three.
    pub quick_stop: i16,
    /// Shutdown option 605Bh, 0 or 1.
    pub shutdown: i16,
    /// Disable option 605Ch, 0 or 1.
    pub disable: i16,
    /// Halt option 605Dh, 0 ..= 3.
    pub halt: i16,
    /// Deceleration time of an emergency stop 6085h, ms.
    pub emergency_ms: u16,
}

impl WheelStops {
    /// What the guide prints as defaults (Z44).
    pub const DEFAULT: Self = Self {
        quick_stop: 5,
        shutdown: 1,
        disable: 1,
        halt: 1,
        emergency_ms: 10,
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
    /// The wheel counts counter-clockwise as forward, seen from its shaft (2001h).
    pub counter_clockwise: bool,
    /// What its stops rely on.
    pub stops: WheelStops,
    /// A load hangs on the wheel that falls without power: its holding brake (2030h:0E) is closed before power goes off, and opened
    /// after it came back.
    pub load_can_fall: bool,
    /// Readings besides the feedback.
    pub polls: WheelPolls,
    /// Position mode: when it has arrived.
    pub arrival: WheelArrival,
    /// The software version that was tried with these settings.
    pub firmware: Firmware,
    /// Wrong replies that are tolerated.
    pub quirks: SdoQuirks,
    /// What each fault does.
    pub reactions: WheelReactions,
}

impl WheelConfig {
    /// A wheel in group 0 with the limits of its axis.
    #[must_use]
    pub const fn new(node: NodeId, mode: WheelMode, limits: WheelLimits) -> Self {
        Self {
            node,
            group: GroupId(0),
            mode,
            limits,
            speed_resolution: 1,
            ramp_ms: 0,
            counter_clockwise: false,
            stops: WheelStops::DEFAULT,
            load_can_fall: false,
            polls: WheelPolls::OFF,
            arrival: WheelArrival::DEFAULT,
            firmware: Firmware::Any,
            quirks: SdoQuirks {
                profile_speed_confirmed_as_sub_1: false,
            },
            reactions: WheelReactions::DEFAULT,
        }
    }
}
