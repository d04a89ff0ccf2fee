//! Single keys of the terminal. Ctrl-C and Ctrl-Z stay what they are.

use std::io::{self, Read};
use std::os::fd::AsFd;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::getpgrp;
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcgetpgrp, tcsetattr};

/// The terminal gives single keys as long as this is held.
#[derive(Debug)]
pub(crate) struct Keyboard {
    before: Termios,
}

impl Keyboard {
    /// Takes the keys; `None` where this program is not in front of its terminal.
    ///
    /// # Errors
    /// When the terminal cannot be set up.
    pub(crate) fn take() -> io::Result<Option<Self>> {
        if !is_in_front() {
            return Ok(None);
        }
        let before = tcgetattr(io::stdin())?;
        let mut single = before.clone();
        single
            .local_modes
            .remove(LocalModes::ICANON | LocalModes::ECHO);
        tcsetattr(io::stdin(), OptionalActions::Now, &single)?;
        Ok(Some(Self { before }))
    }

    /// Waits for a key, at most so long.
    ///
    /// # Errors
    /// When there are no keys any more.
    pub(crate) fn key(most: Duration) -> io::Result<Option<u8>> {
        let patience = Timespec::try_from(most).ok();
        let stdin = io::stdin();
        let mut waiting = [PollFd::from_borrowed_fd(stdin.as_fd(), PollFlags::IN)];
        let has_key = poll(&mut waiting, patience.as_ref()).is_ok_and(|ready| ready > 0);
        if !has_key || !is_in_front() {
            if has_key {
                std::thread::sleep(most);
            }
            return Ok(None);
        }
        let mut key = [0];
        match stdin.lock().read(&mut key)? {
            0 => Err(io::ErrorKind::UnexpectedEof.into()),
            _ => Ok(Some(key[0])),
        }
    }
}

impl Drop for Keyboard {
    fn drop(&mut self) {
        // From the background the system would stop this program for it.
        if is_in_front() {
            let _ = tcsetattr(io::stdin(), OptionalActions::Now, &self.before);
        }
    }
}

/// Lets Ctrl-C and its relatives stay signals in a terminal that gives single keys.
///
/// # Errors
/// When the terminal cannot be set.
pub(crate) fn keep_signals() -> io::Result<()> {
    let input = io::stdin();
    let mut settings = tcgetattr(&input)?;
    settings.local_modes.insert(LocalModes::ISIG);
    Ok(tcsetattr(&input, OptionalActions::Now, &settings)?)
}

/// Whether this program has the terminal: another one that read from it or set it up would be stopped, with its drives enabled.
fn is_in_front() -> bool {
    tcgetpgrp(io::stdin()).is_ok_and(|group| group == getpgrp())
}
