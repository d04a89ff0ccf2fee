//! Ctrl-C, Ctrl-Break, a console that is closed, and a user who logs off.

use std::future::poll_fn;
use std::io;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::task::{Context, Poll};

use tokio::signal::windows::{
    CtrlBreak, CtrlC, CtrlClose, CtrlLogoff, CtrlShutdown, ctrl_break, ctrl_c, ctrl_close,
    ctrl_logoff, ctrl_shutdown,
};

/// What the console tells its programs.
struct Console {
    c: CtrlC,
    brk: CtrlBreak,
    close: CtrlClose,
    logoff: CtrlLogoff,
    shutdown: CtrlShutdown,
}

/// From now on Ctrl-C, Ctrl-Break, a closed console, logging off and shutting down call `note` instead of ending the program. After the last
/// three Windows ends it all the same: 5 s later in the case of a closed console.
///
/// # Errors
/// When the system lets no handler be set.
pub(crate) fn note_endings(note: fn()) -> io::Result<()> {
    let mut console = Console {
        c: ctrl_c()?,
        brk: ctrl_break()?,
        close: ctrl_close()?,
        logoff: ctrl_logoff()?,
        shutdown: ctrl_shutdown()?,
    };
    let waiting = tokio::runtime::Builder::new_current_thread().build()?;
    std::thread::Builder::new().spawn(move || {
        loop {
            waiting.block_on(poll_fn(|context| console.poll(context)));
            note();
        }
    })?;
    Ok(())
}

/// The same: Windows has no further way to end or pause a program that could be noted.
///
/// # Errors
/// As [`note_endings`].
pub(crate) fn note_endings_in_motion(note: fn()) -> io::Result<()> {
    note_endings(note)
}

/// Windows has no signal for it: the flag stays as it is.
///
/// # Errors
/// Never; other systems may let no handler be set.
pub(crate) fn note_power_cycles(_: &Arc<AtomicBool>) -> io::Result<()> {
    Ok(())
}

impl Console {
    fn poll(&mut self, context: &mut Context<'_>) -> Poll<()> {
        let is_told = self.c.poll_recv(context).is_ready()
            || self.brk.poll_recv(context).is_ready()
            || self.close.poll_recv(context).is_ready()
            || self.logoff.poll_recv(context).is_ready()
            || self.shutdown.poll_recv(context).is_ready();
        if is_told {
            Poll::Ready(())
        } else {
            Poll::Pending
        }
    }
}
