//! The machine that this image moves: the configuration that was compiled in. With `link` it is `link/machine.rs`, where the settings say
//! it.

use can_motion::family::Family;
use can_motion::plan::BitRate;

use crate::config::{self, Drives};
use crate::drives::BoardMaster;

/// The axes.
#[inline(always)]
pub(crate) const fn axes() -> &'static [<Drives as Family>::AxisConfig] {
    &config::AXIS_CONFIGS
}

/// Bit rate of the bus.
#[inline(always)]
pub(crate) const fn bit_rate() -> BitRate {
    config::BIT_RATE
}

/// Makes a master the one of this machine.
///
/// # Errors
/// When the configuration cannot work.
#[inline(always)]
pub(crate) fn take_on(master: &mut BoardMaster) -> Result<(), <Drives as Family>::ConfigError> {
    master.take_on(&config::PLAN)
}
