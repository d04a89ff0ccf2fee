//! The machine that the settings in the flash make.

use board_settings::Configs;

use crate::machine::Machine;
use crate::store;

/// Reads the settings; to be called at the start.
pub(crate) fn read() -> Option<Machine> {
    let Configs {
        master,
        axes,
        limits,
        enable_fitted,
        #[cfg(feature = "link-homing")]
        homings,
    } = store::read_settings()?;
    Some(Machine {
        master,
        axes,
        limits,
        has_enable_input: enable_fitted,
        #[cfg(feature = "link-homing")]
        homings,
    })
}
