//! The log of an image that takes orders: faults by the numbers that the host is told. It has the words, of these and of everything else that
//! happens, and they would be four KiB here.

use board_settings::FaultNumber;
use can_motion::family::Family;
use can_motion::{CommandError, TargetError};

use crate::config::Drives;
use crate::drives::{BoardEventKind, BoardFault};
use crate::supervisor::Action;

/// An event, where it is a fault.
pub(crate) fn event(axis: Option<u8>, kind: &BoardEventKind) {
    let Some(FaultNumber { code, detail }) = FaultNumber::of_event(kind) else {
        return;
    };
    match axis {
        Some(axis) => defmt::error!("axis {=u8}: fault {=u16} ({=i32})", axis, code, detail),
        None => defmt::error!("bus: fault {=u16}", code),
    }
}

/// The master refuses what the supervisor wants.
pub(crate) fn refused(action: &Action, _: &CommandError<BoardFault>) {
    defmt::error!("{} is not possible", action);
}

/// The master refuses the configuration: the settings were checked before, and what they cannot do was told by its number.
pub(crate) fn unworkable(_: &<Drives as Family>::ConfigError) {
    defmt::error!("the settings cannot work");
}

/// The master refuses a set-point.
pub(crate) fn target_refused(axis: usize, _: &TargetError) {
    defmt::error!("axis {=usize}: target refused, stopping", axis);
}
