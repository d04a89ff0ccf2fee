//! What the image that takes orders decides while it is compiled; drives, limits and bit rate are settings, see `machine`.

use can_motion::{Dyn, GroupId, MasterConfig};

/// The family of the drives.
pub(crate) type Drives = Dyn;

/// Homing before the motion: none.
pub(crate) type Homing = crate::home::Nothing;

/// Most axes.
pub(crate) const AXES: usize = board_link::segment::MOST_AXES;
/// All axes move and stop together.
pub(crate) const GROUP: GroupId = GroupId(0);

/// Cycle and waiting times; the bit rate is a setting.
pub(crate) const MASTER: MasterConfig = MasterConfig::DEFAULT;

/// Time from one cycle to the next in microseconds.
pub(crate) const CYCLE_US: u32 = MASTER.cycle_us;
