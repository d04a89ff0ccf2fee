//! What a servo asks next.

use dyn_can::ReplyKind;

use crate::core::exit::Class;

/// What a servo asks next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ask {
    /// A reading that the axis waits for.
    Reading(ReplyKind),
    /// The command of the procedure.
    Command,
    /// A frame about a motion of the drive itself.
    Own(Class),
    /// A reading that is wanted now and then.
    Poll(ReplyKind),
}
