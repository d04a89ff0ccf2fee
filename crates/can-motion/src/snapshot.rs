//! The state of an axis and of the master at one moment, for the application to look at.

use dyn_can::DriveId;

use crate::config::GroupId;
use crate::fault::Fault;
use crate::feedback::Feedback;
use crate::life::AxisState;
use crate::plan::ResponseWindow;

/// What happened to one axis since the start; each number wraps after 2^32.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Counters {
    /// Set-points that the controller accepted.
    pub set_points: u32,
    /// Set-points that missed their cycle; their step went into the next frame.
    pub merged: u32,
    /// Frames that the controller gave back unsent.
    pub displaced: u32,
    /// Requests that the controller accepted.
    pub requests: u32,
    /// Replies that were believed.
    pub replies: u32,
    /// Requests without a reply in time.
    pub timeouts: u32,
    /// Replies dropped because they came too late or twice.
    pub late_replies: u32,
    /// Replies dropped because nobody asked.
    pub stray_replies: u32,
    /// Replies that did not decode.
    pub bad_replies: u32,
    /// Parameters written to the drive's EEPROM.
    pub eeprom_writes: u16,
}

/// One axis at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisSnapshot {
    /// The drive.
    pub drive: DriveId,
    /// The group that it stops with.
    pub group: GroupId,
    /// Where the axis is in its life.
    pub state: AxisState,
    /// The latched fault.
    pub fault: Option<Fault>,
    /// The position is known.
    pub referenced: bool,
    /// What the application wants, in command counts.
    pub target_counts: i32,
    /// Where the set-points that the controller accepted take the drive, in command counts.
    pub sent_counts: i32,
    /// Target minus sent: what is still owed.
    pub backlog_counts: i32,
    /// The latest readings.
    pub feedback: Feedback,
    /// How long the drive took to answer lately, as far as the master can know; `None` before its first reply. Put it,
    /// with a margin, into the plan of the bus.
    pub response: Option<ResponseWindow>,
    /// What happened so far.
    pub counters: Counters,
}

/// What happened to the cycle since the start; each number wraps after 2^32.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CycleCounters {
    /// Cycles begun.
    pub cycles: u32,
    /// Cycles that ended with a set-point not accepted by the controller.
    pub late: u32,
    /// Cycles that were never begun.
    pub missed: u32,
    /// Events dropped because nobody read them.
    pub events_dropped: u32,
}
