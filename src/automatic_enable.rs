//! The one place that decides to enable the drives.

use can_motion::{AxisState, Instant, Master};

use crate::config::{AXES, GROUP};

/// The axes must be ready this soon after the start: a machine must not set itself in motion when somebody connects or
/// switches on its drives later.
const START_WINDOW_US: u64 = 10_000_000;

/// Enables the drives by itself, because this board reads no enable input yet.
///
/// So it is cautious: once, when every axis is ready soon after the start, and never again. A fault before or after, the bus
/// or the end of streaming for any other reason leave the machine at rest until the board is started again. The image
/// has nothing that resets the board, so every start is one that a person made.
pub(crate) enum AutomaticEnable {
    /// The axes are still being probed.
    Waiting,
    /// The drives were told to enable, or something went wrong before.
    Spent,
}

impl AutomaticEnable {
    /// To be called every cycle: enables the group when its moment has come.
    pub(crate) fn update(&mut self, master: &mut Master<AXES>, now: Instant) {
        if matches!(self, Self::Spent) {
            return;
        }
        if any_fault(master) {
            *self = Self::Spent;
            defmt::error!(
                "a fault before the axes were ready: nothing will be enabled until the board is started again"
            );
        } else if now.as_us() > START_WINDOW_US {
            *self = Self::Spent;
            defmt::error!(
                "the axes were not ready within {=u64} s: nothing will be enabled until the board is started again",
                START_WINDOW_US / 1_000_000
            );
        } else if master.all_are(GROUP, AxisState::Ready) {
            *self = Self::Spent;
            match master.enable(now, GROUP) {
                Ok(()) => defmt::info!("all axes are ready: enabling, once"),
                Err(error) => defmt::error!("not enabled: {}", error),
            }
        }
    }
}

fn any_fault(master: &Master<AXES>) -> bool {
    (0..AXES)
        .filter_map(|axis| master.snapshot(axis))
        .any(|snapshot| snapshot.fault.is_some())
}
