//! What the application may ask for, and why it may be refused.

use crate::core::drive_move::MoveRefusal;
use crate::core::family::GroupId;
use crate::core::state::AxisState;

/// A command that was refused; nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CommandError<F> {
    /// No axis is in this group.
    #[error("no axis is in group {}", _0.0)]
    NoSuchGroup(GroupId),
    /// An axis of the group has a latched fault: read it, remove its cause, then `clear`.
    #[error("axis {axis} has a fault ({fault}): remove the cause, then clear it")]
    Faulted {
        /// The axis.
        axis: u8,
        /// Its fault.
        fault: F,
    },
    /// An axis of the group is in the wrong state.
    #[error("axis {axis} must be {expected}, it is {actual}")]
    State {
        /// The axis.
        axis: u8,
        /// The state that the command needs.
        expected: AxisState,
        /// The state of the axis.
        actual: AxisState,
    },
    /// A procedure of an axis of the group is under way: wait for its end.
    #[error("a procedure of axis {axis} is under way: wait for its end")]
    Busy {
        /// The axis.
        axis: u8,
    },
    /// Whether a drive that holds still has power is not known: wait for its report, or `disable` the group.
    #[error(
        "whether the drive of axis {axis} still has power is not known: wait for its report, or disable the group"
    )]
    Unclear {
        /// The axis.
        axis: u8,
    },
    /// The axis must be switched off and on again before it can move, and a load hangs on it: `disable` it, then `enable` it.
    #[error(
        "axis {axis} must be switched off and on again and its load can fall: disable it, then enable it"
    )]
    LoadCanFall {
        /// The axis.
        axis: u8,
    },
    /// The controller is bus-off: recover it first.
    #[error("the bus is off: recover the controller first")]
    BusOff,
}

/// A target that was refused; the one before it stays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TargetError {
    /// There is no such axis.
    #[error("there are {axes} axes, counted from 0; axis {actual} is not one of them")]
    NoSuchAxis {
        /// The number of axes.
        axes: usize,
        /// The axis asked for.
        actual: usize,
    },
    /// The axis takes no targets in its state.
    #[error("the axis takes targets while streaming only, it is {state}")]
    NotStreaming {
        /// The state of the axis.
        state: AxisState,
    },
    /// The target leaves the travel of the axis.
    #[error("the target must be {min}..={max}, got {actual}")]
    Travel {
        /// The smallest target.
        min: i32,
        /// The largest target.
        max: i32,
        /// The target asked for.
        actual: i32,
    },
}

/// A motion by a drive itself that was refused; nothing has changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum MoveError<F> {
    /// There is no such axis.
    #[error("there are {axes} axes, counted from 0; axis {actual} is not one of them")]
    NoSuchAxis {
        /// The number of axes.
        axes: usize,
        /// The axis asked for.
        actual: usize,
    },
    /// The axis takes no command now.
    #[error(transparent)]
    Command(#[from] CommandError<F>),
    /// The drive cannot make it, or must not.
    #[error("axis {axis}: {refusal}")]
    Refused {
        /// The axis.
        axis: u8,
        /// Why.
        refusal: MoveRefusal,
    },
    /// Moves that start together are all absolute or all relative, of different axes of one group, at least one.
    #[error(
        "moves that start together must be all absolute or all relative, each of another axis of one group"
    )]
    NotTogether,
    /// A trigger reaches every drive on the bus, and this one may hold a move that was loaded before and has power: disable it first.
    #[error(
        "the trigger would reach the drive of axis {axis}, which may hold an old loaded move: disable its group, or load it as well"
    )]
    OldLoad {
        /// The axis.
        axis: u8,
    },
}
