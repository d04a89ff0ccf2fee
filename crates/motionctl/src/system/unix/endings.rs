//! The signals that ask a program to end, and the one that switches the power of simulated drives.

use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use signal_hook::consts::{
    SIGALRM, SIGHUP, SIGINT, SIGIO, SIGPROF, SIGQUIT, SIGTERM, SIGTSTP, SIGUSR1, SIGUSR2,
    SIGVTALRM, SIGXCPU, SIGXFSZ,
};
use signal_hook::iterator::Signals;

/// From now on Ctrl-C, Ctrl-\ and the signals of `kill` and of a closed terminal call `note` instead of ending the program.
///
/// # Errors
/// When the system lets no handler be set.
pub(crate) fn note_endings(note: fn()) -> io::Result<()> {
    note_signals(&[SIGINT, SIGTERM, SIGHUP, SIGQUIT], note)
}

/// The same with Ctrl-Z and every other signal that would end or pause the program.
///
/// # Errors
/// As [`note_endings`].
pub(crate) fn note_endings_in_motion(note: fn()) -> io::Result<()> {
    let signals = [
        SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP, SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF,
        SIGIO, SIGXCPU, SIGXFSZ,
    ];
    note_signals(&signals, note)?;
    #[cfg(target_os = "linux")]
    note_signals(&[rustix::process::Signal::POWER.as_raw()], note)?;
    Ok(())
}

/// From now on SIGUSR1 sets the flag.
///
/// # Errors
/// As [`note_endings`].
pub(crate) fn note_power_cycles(is_asked: &Arc<AtomicBool>) -> io::Result<()> {
    signal_hook::flag::register(SIGUSR1, Arc::clone(is_asked)).map(drop)
}

fn note_signals(signals: &[i32], note: fn()) -> io::Result<()> {
    let mut signals = Signals::new(signals)?;
    std::thread::Builder::new().spawn(move || {
        for signal in signals.forever() {
            // A file that must not grow any more: the error of the write that was refused says so.
            if signal != SIGXFSZ {
                note();
            }
        }
    })?;
    Ok(())
}
