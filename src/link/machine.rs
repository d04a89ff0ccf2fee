//! The machine of the image that takes orders: what its settings say, read once at the start.

use board_link::AxisLimits;
use can_motion::AxisConfig;
use can_motion::plan::{BitRate, BusPlan};
use can_motion::{ConfigError, MasterConfig};
use embassy_sync::once_lock::OnceLock;
use heapless::Vec;

use crate::board;
use crate::config::{AXES, MASTER};
use crate::drives::BoardMaster;

/// What the settings say.
pub(crate) struct Machine {
    /// Of the master, with the bit rate.
    pub(crate) master: MasterConfig,
    /// The axes, in ascending order of their drives.
    pub(crate) axes: Vec<AxisConfig, AXES>,
    /// What the segments of each may need.
    pub(crate) limits: Vec<AxisLimits, AXES>,
    /// An enable input is fitted.
    pub(crate) has_enable_input: bool,
    /// How each finds its origin.
    #[cfg(feature = "link-homing")]
    pub(crate) homings: Vec<Option<board_settings::AxisHoming>, AXES>,
}

static MACHINE: OnceLock<Machine> = OnceLock::new();

/// Reads the settings; to be called once, at the start. Without valid ones there is no machine.
// Inlined, what it needs at the start would stay on the stack for ever.
#[inline(never)]
pub(crate) fn load() {
    if let Some(machine) = crate::link::stored::read()
        && board::prescaler(machine.master.bus.bit_rate).is_some()
    {
        // It is the first one.
        let _ = MACHINE.init(machine);
    }
}

/// The machine; `None` without settings.
pub(crate) fn get() -> Option<&'static Machine> {
    MACHINE.try_get()
}

/// The axes.
pub(crate) fn axes() -> &'static [AxisConfig] {
    get().map_or(&[], |machine| &machine.axes)
}

/// Bit rate of the bus.
pub(crate) fn bit_rate() -> BitRate {
    get().map_or(MASTER.bus.bit_rate, |machine| machine.master.bus.bit_rate)
}

/// Whether an enable input is fitted.
pub(crate) fn has_enable_input() -> bool {
    get().is_none_or(|machine| machine.has_enable_input)
}

/// Makes a master the one of this machine; the plan of its bus is made here.
///
/// # Errors
/// When the settings cannot work, or the bus cannot carry the axes in time.
pub(crate) fn take_on(master: &mut BoardMaster) -> Result<(), ConfigError> {
    let config = get().map_or(MASTER, |machine| machine.master);
    master.take_on(&BusPlan::new(&config, axes()))
}
