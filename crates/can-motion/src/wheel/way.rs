//! The way of a wheel in position mode.

use bus_user::Instant;

/// The way to the latest target.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Way {
    /// There is no new target.
    #[default]
    Over,
    /// The frame with the target has not left yet.
    Waiting,
    /// The target has left.
    Running { since: Instant },
    /// The time is over, which was said.
    Late,
}
