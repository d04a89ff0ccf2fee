//! Mistakes that can be put back, so that the tests on the emulated board can be seen to notice them. No image that moves a machine has
//! any: without the feature `misbehave` the answer is a constant, and what would follow is not in the image.

#[cfg(all(feature = "misbehave", target_os = "none"))]
mod on_command;

#[cfg(all(feature = "misbehave", target_os = "none"))]
pub(crate) use on_command::{act, has};

/// A mistake that was made once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    not(all(feature = "misbehave", target_os = "none")),
    allow(dead_code, reason = "its number matters only where it can be made")
)]
pub(crate) enum Fault {
    /// A recovery leaves in the controller what waits there.
    KeepOldFrames = 1,
    /// The start waits for the bus before anything else, and nobody feeds the watchdog.
    WaitForTheBus = 2,
    /// The start waits for the crystal without an end, before the watchdog and the LED.
    WaitForTheCrystal = 4,
    /// Drives that do not confirm their disable command are not shown.
    HideUnconfirmed = 8,
    /// A crystal that stops is not watched.
    NoClockSecurity = 16,
    /// The stop circuit is looked at in one of sixteen cycles.
    SeldomStop = 32,
}

/// Whether a mistake is made.
#[cfg(not(all(feature = "misbehave", target_os = "none")))]
pub(crate) const fn has(_fault: Fault) -> bool {
    false
}

/// Fails as told.
#[cfg(not(all(feature = "misbehave", target_os = "none")))]
#[cfg_attr(
    not(target_os = "none"),
    allow(dead_code, reason = "only the cycle fails on command")
)]
pub(crate) const fn act() {}
