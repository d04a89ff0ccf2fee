//! What a board is told of one axis.

use serde::{Deserialize, Serialize};

use crate::homing::HomingSettings;

/// One axis. Nothing that limits its motion has a default.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct AxisSettings {
    /// The id of its drive, 1 to 63.
    pub drive: u8,
    /// The gear number that the drive must have, 500 to 16384. One with another number is not enabled.
    pub gear: u16,
    /// Fastest speed of the motor, r/min. No frame carries more.
    pub speed_rpm: u32,
    /// Fastest change of the speed, r/min per second.
    pub acceleration_rpm_per_s: u32,
    /// Fastest change of the acceleration, r/min per second²; `None`: no limit.
    pub jerk_rpm_per_s2: Option<u32>,
    /// Where it may go: from the zero of its drive, or from the origin that its homing finds.
    pub travel: Travel,
    /// Unit of the position that the drive reports.
    pub read_back: ReadBack,
    /// Axes with the same number stop together.
    pub group: u8,
    /// What is read and how often.
    pub polls: Polls,
    /// Nobody watches the drive while it moves: its status need not be polled.
    pub unwatched: bool,
    /// A load hangs on the axis that falls without power: its drive must operate a brake, or the axis is not enabled.
    pub load_can_fall: bool,
    /// The revision of the drive.
    pub dialect: Dialect,
    /// Distance in command counts between sent and read position beyond which a moving axis has a fault; `None`: the 8192 counts after
    /// which a drive alarms by itself.
    pub following_error_counts: Option<u32>,
    /// The same at standstill; `None`: 16 counts.
    pub drift_tolerance_counts: Option<u32>,
    /// How it finds its origin; `None`: its positions are those of its drive.
    #[serde(with = "crate::homing")]
    pub homing: Option<HomingSettings>,
}

impl AxisSettings {
    /// A drive with what must be said; group 0, status and position read 50 times a second in command counts, revision detected.
    #[must_use]
    pub const fn new(drive: u8, gear: u16, limits: MotorLimits, travel: Travel) -> Self {
        Self {
            drive,
            gear,
            speed_rpm: limits.speed_rpm,
            acceleration_rpm_per_s: limits.acceleration_rpm_per_s,
            jerk_rpm_per_s2: None,
            travel,
            read_back: ReadBack::CommandCounts,
            group: 0,
            polls: Polls::DEFAULT,
            unwatched: false,
            load_can_fall: false,
            dialect: Dialect::Detect,
            following_error_counts: None,
            drift_tolerance_counts: None,
            homing: None,
        }
    }
}

pub use can_motion::MotorLimits;

/// Where an axis may go.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Travel {
    /// In thousandths of a degree of the motor. Rounded towards 0 to counts.
    Millidegrees {
        /// The lowest position.
        min: i64,
        /// The highest position.
        max: i64,
    },
    /// In command counts: a turn is four times the gear number.
    Counts {
        /// The lowest position.
        min: i32,
        /// The highest position.
        max: i32,
    },
}

/// The unit of the position that a drive reports. The documents do not state it (D44): turn the shaft once and compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ReadBack {
    /// Command counts, four times the gear number a turn.
    CommandCounts,
    /// Movement positions, 65536 a turn.
    MovementPositions,
    /// Motor steps, 16384 a turn.
    MotorSteps,
    /// Any other.
    Ratio {
        /// So many read-back counts ...
        read_back_counts: u32,
        /// ... for this many command counts.
        command_counts: u32,
    },
}

/// Time from one reading to the next in microseconds; 0: it is not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Polls {
    /// Status byte.
    pub status_us: u32,
    /// Position.
    pub position_us: u32,
    /// Torque.
    pub torque_us: u32,
    /// Motor speed.
    pub speed_us: u32,
    /// Diagnostic counter.
    pub counter_us: u32,
}

impl Polls {
    /// Status and position 50 times a second.
    pub const DEFAULT: Self = Self {
        status_us: 20_000,
        position_us: 20_000,
        torque_us: 0,
        speed_us: 0,
        counter_us: 0,
    };
}

/// The revision of the drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Dialect {
    /// What the length of a reply tells (D62).
    Detect,
    /// 1.2A.
    V1_2A,
    /// 1.6A.
    V1_6A,
}
