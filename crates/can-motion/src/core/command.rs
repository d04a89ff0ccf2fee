//! What the application may ask for, and why it may be refused.

use core::fmt;

use crate::core::family::GroupId;
use crate::core::state::AxisState;

/// A command that was refused; nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CommandError<F> {
    /// No axis is in this group.
    NoSuchGroup(GroupId),
    /// An axis of the group has a latched fault: read it, remove its cause, then `clear`.
    Faulted {
        /// The axis.
        axis: u8,
        /// Its fault.
        fault: F,
    },
    /// An axis of the group is in the wrong state.
    State {
        /// The axis.
        axis: u8,
        /// The state that the command needs.
        expected: AxisState,
        /// The state of the axis.
        actual: AxisState,
    },
    /// A procedure of an axis of the group is under way: wait for its end.
    Busy {
        /// The axis.
        axis: u8,
    },
    /// Whether a drive that holds still has power is not known: wait for its report, or `disable` the group.
    Unclear {
        /// The axis.
        axis: u8,
    },
    /// The axis must be switched off and on again before it can move, and a load hangs on it: `disable` it, then `enable` it.
    LoadCanFall {
        /// The axis.
        axis: u8,
    },
    /// The controller is bus-off: recover it first.
    BusOff,
}

impl<F: fmt::Display> fmt::Display for CommandError<F> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchGroup(GroupId(group)) => write!(f, "no axis is in group {group}"),
            Self::Faulted { axis, fault } => {
                write!(
                    f,
                    "axis {axis} has a fault ({fault}): remove the cause, then clear it"
                )
            }
            Self::State {
                axis,
                expected,
                actual,
            } => {
                write!(f, "axis {axis} must be {expected}, it is {actual}")
            }
            Self::Busy { axis } => {
                write!(
                    f,
                    "a procedure of axis {axis} is under way: wait for its end"
                )
            }
            Self::Unclear { axis } => write!(
                f,
                "whether the drive of axis {axis} still has power is not known: wait for its report, or disable the group"
            ),
            Self::LoadCanFall { axis } => write!(
                f,
                "axis {axis} must be switched off and on again and its load can fall: disable it, then enable it"
            ),
            Self::BusOff => f.write_str("the bus is off: recover the controller first"),
        }
    }
}

impl<F: fmt::Debug + fmt::Display> core::error::Error for CommandError<F> {}

/// A target that was refused; the one before it stays.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TargetError {
    /// There is no such axis.
    NoSuchAxis {
        /// The number of axes.
        axes: usize,
        /// The axis asked for.
        actual: usize,
    },
    /// The axis takes no targets in its state.
    NotStreaming {
        /// The state of the axis.
        state: AxisState,
    },
    /// The target leaves the travel of the axis.
    Travel {
        /// The smallest target.
        min: i32,
        /// The largest target.
        max: i32,
        /// The target asked for.
        actual: i32,
    },
}

impl fmt::Display for TargetError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSuchAxis { axes, actual } => {
                write!(
                    f,
                    "there are {axes} axes, counted from 0; axis {actual} is not one of them"
                )
            }
            Self::NotStreaming { state } => {
                write!(
                    f,
                    "the axis takes targets while streaming only, it is {state}"
                )
            }
            Self::Travel { min, max, actual } => {
                write!(f, "the target must be {min}..={max}, got {actual}")
            }
        }
    }
}

impl core::error::Error for TargetError {}
