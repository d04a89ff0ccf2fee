//! Ctrl-C, and whatever else asks a program to end: noted, never acted upon by itself.

use std::io;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::system;

static REQUESTS: AtomicU32 = AtomicU32::new(0);

/// From now on what asks the program to end is noted instead of ending it: Ctrl-C, signals, a terminal or console that is closed.
///
/// # Errors
/// When the system lets no handler be set.
pub(crate) fn listen() -> io::Result<()> {
    system::note_endings(request)
}

/// The same for commands that enable drives, and for whatever else would end or pause the program: its drives would stay enabled. Call
/// it before anything is enabled.
///
/// # Errors
/// As [`listen`].
pub(crate) fn listen_in_motion() -> io::Result<()> {
    system::note_endings_in_motion(request)
}

/// The user asks to stop.
pub(crate) fn request() {
    REQUESTS.fetch_add(1, Ordering::Relaxed);
}

/// How often the user has asked to stop.
pub(crate) fn requests() -> u32 {
    REQUESTS.load(Ordering::Relaxed)
}
