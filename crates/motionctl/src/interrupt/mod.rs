//! Ctrl-C, and the signals that ask a program to end: noted, never acted upon by themselves.

use std::sync::atomic::{AtomicU32, Ordering};

static REQUESTS: AtomicU32 = AtomicU32::new(0);

/// From now on Ctrl-C is noted instead of ending the program. Call it before anything moves.
///
/// # Errors
/// When the system lets no handler be set.
pub(crate) fn listen() -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(|| {
        REQUESTS.fetch_add(1, Ordering::Relaxed);
    })
}

/// How often the user has asked to stop.
pub(crate) fn requests() -> u32 {
    REQUESTS.load(Ordering::Relaxed)
}
