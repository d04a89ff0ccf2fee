//! Why the board started.

/// The cause of a start, as the chip tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, defmt::Format)]
pub(crate) enum Cause {
    /// The supply came, or came back.
    PowerOn,
    /// The reset pin.
    Pin,
    /// Software asked for it: a debug probe, or the firmware after it failed.
    Software,
    /// A watchdog was not fed.
    Watchdog,
}
