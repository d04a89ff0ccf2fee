//! Ctrl-C, and the signals that ask a program to end: noted, never acted upon by themselves.

use std::io;
use std::sync::atomic::{AtomicU32, Ordering};

use signal_hook::consts::{
    SIGALRM, SIGHUP, SIGINT, SIGIO, SIGPROF, SIGQUIT, SIGTERM, SIGTSTP, SIGUSR1, SIGUSR2,
    SIGVTALRM, SIGXCPU, SIGXFSZ,
};
use signal_hook::iterator::Signals;

static REQUESTS: AtomicU32 = AtomicU32::new(0);

/// From now on Ctrl-C, Ctrl-\ and the signals of `kill` and of a closed terminal are noted instead of ending the program.
///
/// # Errors
/// When the system lets no handler be set.
pub(crate) fn listen() -> io::Result<()> {
    note(&[SIGINT, SIGTERM, SIGHUP, SIGQUIT])
}

/// The same for commands that enable drives, and for Ctrl-Z and every other signal that would end or pause the program: its drives
/// would stay enabled. Call it before anything is enabled.
///
/// # Errors
/// As [`listen`].
pub(crate) fn listen_in_motion() -> io::Result<()> {
    note(&[
        SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF,
        SIGIO, SIGXCPU, SIGXFSZ,
    ])?;
    #[cfg(target_os = "linux")]
    note(&[rustix::process::Signal::POWER.as_raw()])?;
    Ok(())
}

fn note(signals: &[i32]) -> io::Result<()> {
    let mut signals = Signals::new(signals)?;
    std::thread::Builder::new().spawn(move || {
        for signal in signals.forever() {
            // A file that must not grow any more: the error of the write that was refused says so.
            if signal != SIGXFSZ {
                REQUESTS.fetch_add(1, Ordering::Relaxed);
            }
        }
    })?;
    Ok(())
}

/// The user asks to stop by other means than a signal: a key of a view.
pub(crate) fn request() {
    REQUESTS.fetch_add(1, Ordering::Relaxed);
}

/// How often the user has asked to stop.
pub(crate) fn requests() -> u32 {
    REQUESTS.load(Ordering::Relaxed)
}
