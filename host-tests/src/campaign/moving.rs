//! What the observer keeps of a motion that a drive makes by itself.

use super::moves::Asked;

/// A motion of one drive.
#[derive(Debug, Clone, Copy)]
pub(super) struct Moving {
    pub(super) asked: Asked,
    /// Where the commands until then led its drive, with what was still to go out.
    pub(super) led_counts: i64,
    /// The frame that begins it was taken.
    pub(super) is_sent: bool,
    pub(super) stops: u32,
    /// It was stopped before the trigger.
    pub(super) stays_loaded: bool,
}
