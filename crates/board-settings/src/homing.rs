//! How an axis finds its origin.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// How an axis finds its origin, from which its travel counts then. Ways are those of the motor, in thousandths of a degree.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct HomingSettings {
    /// What its reference is.
    pub method: HomingMethod,
    /// Axes with a lower number are homed before; those with the same one in the order of the list.
    pub order: u8,
    /// Where the reference is on the axis.
    pub reference_millidegrees: i32,
}

/// What the reference of an axis is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum HomingMethod {
    /// The place where it stands: nothing moves.
    Here,
    /// A hard stop.
    Stop {
        /// The way there.
        search: HomingSearch,
        /// Torque of a contact, in thousandths of the peak: more than the axis needs to move, less than its mechanics bear.
        torque_permille: u16,
        /// Following error of a contact: more than the lag of the axis while it moves.
        contact_millidegrees: u32,
    },
    /// The edge of a switch.
    Switch {
        /// The way there.
        search: HomingSearch,
        /// The pin of port C that it hangs on, 3 to 12, pulled down; on an STM32F405 to 11.
        pin: u8,
        /// Its level while it is operated.
        active: SwitchLevel,
    },
}

/// A way to a stop or a switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct HomingSearch {
    /// Where it is.
    pub direction: HomingDirection,
    /// Speed of the search, r/min.
    pub speed_rpm: u16,
    /// Speed of the second approach.
    pub slow_speed_rpm: u16,
    /// Fastest change of the speed, r/min per second; also of the ramp with which it stops.
    pub acceleration_rpm_per_s: u32,
    /// Torque that ends the search, in thousandths of the peak; on the way to a switch only where the torque is read.
    pub most_torque_permille: u16,
    /// Following error that ends the search.
    pub most_millidegrees: u32,
    /// The farthest way from where the axis stands.
    pub way_millidegrees: u32,
    /// How far the axis backs off from its reference, and where it rests in the end.
    pub back_off_millidegrees: u32,
}

/// A way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum HomingDirection {
    /// Towards larger counts.
    Positive,
    /// Towards smaller counts.
    Negative,
}

/// The level of a switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum SwitchLevel {
    /// Low while it is operated, as a normally closed one: a broken wire is an operated switch.
    Low,
    /// High while it is operated.
    High,
}

impl HomingSettings {
    /// 15 % of the peak torque.
    pub const TORQUE_PERMILLE: u16 = 150;
    /// 3 degrees.
    pub const CONTACT_MILLIDEGREES: u32 = 3_000;

    /// First in order, with its reference at 0.
    #[must_use]
    pub const fn new(method: HomingMethod) -> Self {
        Self {
            method,
            order: 0,
            reference_millidegrees: 0,
        }
    }

    /// At a hard stop, with the torque and the following error of a contact that `motionctl home` has.
    #[must_use]
    pub const fn stop(search: HomingSearch) -> Self {
        Self::new(HomingMethod::Stop {
            search,
            torque_permille: Self::TORQUE_PERMILLE,
            contact_millidegrees: Self::CONTACT_MILLIDEGREES,
        })
    }
}

impl HomingSearch {
    /// Slow and safe, as of `motionctl home`: 15 r/min, 3 r/min the second time, 300 r/min per second, 80 % of the peak torque, 45 degrees of
    /// following error, a back-off of 18 degrees. How far it may go has no default.
    #[must_use]
    pub const fn new(direction: HomingDirection, way_millidegrees: u32) -> Self {
        Self {
            direction,
            speed_rpm: 15,
            slow_speed_rpm: 3,
            acceleration_rpm_per_s: 300,
            most_torque_permille: 800,
            most_millidegrees: 45_000,
            way_millidegrees,
            back_off_millidegrees: 18_000,
        }
    }
}

impl HomingMethod {
    /// The way; `None` where nothing moves.
    #[must_use]
    pub const fn search(&self) -> Option<&HomingSearch> {
        match self {
            Self::Here => None,
            Self::Stop { search, .. } | Self::Switch { search, .. } => Some(search),
        }
    }
}

/// The bytes of an axis are those of the first version, without its homing: it stands behind all axes. Everything else has it in its place.
pub(crate) fn serialize<S: Serializer>(
    homing: &Option<HomingSettings>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    if serializer.is_human_readable() {
        homing.serialize(serializer)
    } else {
        serializer.serialize_unit()
    }
}

/// The other way.
pub(crate) fn deserialize<'de, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Option<HomingSettings>, D::Error> {
    if deserializer.is_human_readable() {
        Option::deserialize(deserializer)
    } else {
        <()>::deserialize(deserializer).map(|()| None)
    }
}
