//! What the firmware must know of a family of drives beside what its master knows. The configuration names the family, `config::Drives`;
//! nothing of the other one is in the image.

mod dyn_servos;
mod hub_motors;

use can_motion::family::Family;
use can_motion::{Instant, Master};
use dyn_can::DataFrame;

use crate::config::{AXES, Drives};

/// The master of this board.
pub(crate) type BoardMaster = Master<AXES, Drives>;
/// What happens on this board.
pub(crate) type BoardEventKind = <Drives as Family>::EventKind;
/// What can go wrong with an axis of this board.
pub(crate) type BoardFault = <Drives as Family>::Fault;

/// A family that this firmware can run.
pub(crate) trait Board: Family<Frame = DataFrame> {
    /// The command that takes the power from a drive, in one frame that needs nothing to be set up; `None` when there is none.
    fn disable(axis: &Self::AxisConfig) -> Option<DataFrame>;

    /// What the application wants from the axis: the unit is that of the targets.
    fn target(snapshot: &Self::Snapshot) -> i32;

    /// When the latest status and the latest position were read.
    fn read_at(snapshot: &Self::Snapshot) -> [Option<Instant>; 2];

    /// What a homing needs to know of an axis, without its switch; a family that does not home tells no reading.
    fn readings(axis: &Self::AxisConfig, snapshot: &Self::Snapshot) -> homing::Inputs {
        let _ = axis;
        homing::Inputs {
            sent_counts: Self::target(snapshot),
            position: None,
            torque_permille: None,
            switch: None,
        }
    }

    /// An error on the bus: without a drive that acknowledges, every frame is one.
    fn is_bus_error(kind: &Self::EventKind) -> bool;
}
