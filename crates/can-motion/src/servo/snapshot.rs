//! A servo axis at one moment, for the application to look at.

use bus_plan::ResponseWindow;
use dyn_can::DriveId;

use crate::core::facts::Facts;
use crate::core::family::GroupId;
use crate::core::snapshot::Counters;
use crate::core::state::AxisState;
use crate::servo::fault::Fault;
use crate::servo::feedback::Feedback;

/// One axis at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct AxisSnapshot {
    /// The drive.
    pub drive: DriveId,
    /// The group that it stops with.
    pub group: GroupId,
    /// Where the axis is in its life: a view of the facts.
    pub state: AxisState,
    /// The facts.
    pub facts: Facts,
    /// The latched fault.
    pub fault: Option<Fault>,
    /// What the application wants, in command counts.
    pub target_counts: i32,
    /// Where the set-points that the controller accepted take the drive, in command counts.
    pub sent_counts: i32,
    /// Target minus sent: what is still owed.
    pub backlog_counts: i32,
    /// The latest readings.
    pub feedback: Feedback,
    /// How long the drive took to answer lately, as far as the master can know; `None` before its first reply. Put it, with a margin,
    /// into the plan of the bus.
    pub response: Option<ResponseWindow>,
    /// What happened so far.
    pub counters: Counters,
}
