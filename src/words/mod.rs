//! The words of the log for what happens to the axes. An image that takes orders has `link/words.rs` in the place of these: its host has the
//! words.

mod dyn_servos;
mod hub_motors;

use can_motion::family::Family;
use can_motion::{CommandError, TargetError};

use crate::config::Drives;
use crate::drives::{Board, BoardEventKind, BoardFault};
use crate::machine;
use crate::supervisor::Action;

/// A family whose events have words.
trait Words: Board {
    /// Writes an event, of an axis by its place in the configuration or of the bus, as a line of the log. Users know drives by their ids,
    /// and what to do is part of a fault.
    fn write(axis: Option<u8>, kind: &Self::EventKind);
}

/// An event.
pub(crate) fn event(axis: Option<u8>, kind: &BoardEventKind) {
    Drives::write(axis, kind);
}

/// The master refuses what the supervisor wants.
pub(crate) fn refused(action: &Action, error: &CommandError<BoardFault>) {
    defmt::error!("{} is not possible: {}", action, error);
}

/// The master refuses the configuration.
pub(crate) fn unworkable(error: &<Drives as Family>::ConfigError) {
    defmt::error!("the configuration cannot work: {}", error);
}

/// The master refuses a set-point.
pub(crate) fn target_refused(axis: usize, error: &TargetError) {
    defmt::error!("axis {=usize}: target refused, stopping: {}", axis, error);
}

/// Who an event is about.
struct Who(Option<u8>);

impl defmt::Format for Who {
    fn format(&self, f: defmt::Formatter<'_>) {
        let axis = self.0.map(usize::from);
        match axis.and_then(|axis| machine::axes().get(axis)) {
            Some(axis) => defmt::write!(f, "drive {=u8}", Drives::address_of(axis)),
            None => defmt::write!(f, "bus"),
        }
    }
}
