//! What is simulated.

use can_motion::PollPeriods;
use drive_sim::{BitRate, TxOrder};
use dyn_can::{DriveId, StepLimit};

use super::faults::Script;
use crate::virtual_drives::VirtualDriveOptions;

/// Axes that a simulation can hold: the widest choice of a bus at any bit rate and cycle.
pub(crate) const MOST_AXES: usize = 63;

/// What to simulate.
#[derive(Debug)]
pub(crate) struct Setup {
    /// Name of the bus, where there are several.
    pub(crate) bus: String,
    /// Drive of each axis, in the order of the columns.
    pub(crate) drives: Vec<DriveId>,
    pub(crate) cycle_us: u32,
    pub(crate) bit_rate: BitRate,
    pub(crate) max_step: StepLimit,
    pub(crate) polls: PollPeriods,
    pub(crate) drive_options: VirtualDriveOptions,
    pub(crate) tx_order: TxOrder,
    pub(crate) faults: Script,
}
