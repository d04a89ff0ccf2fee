//! Keys of the terminal of a motion on a real bus. Ctrl-C and Ctrl-Z stay what they are.

use std::io::{self, IsTerminal, Read};
use std::os::fd::AsFd;
use std::sync::mpsc::Sender;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::getpgrp;
use rustix::termios::{LocalModes, OptionalActions, Termios, tcgetattr, tcgetpgrp, tcsetattr};

use super::Wish;
use crate::set_points::Order;

/// What the keys are, in a line.
pub(crate) const HELP: &str =
    "keys: space pause, + - speed, 1 back to 100 %, s stop on the path, Ctrl-C slow down and end";
/// How often is looked whether this program is still in the foreground.
const LOOK: Duration = Duration::from_millis(200);

/// The terminal gives single keys as long as this is held.
#[derive(Debug)]
pub(crate) struct Keys {
    before: Termios,
}

impl Keys {
    /// Takes the keys; `None` where nobody sits in front of standard input.
    ///
    /// # Errors
    /// When the terminal cannot be set up.
    pub(crate) fn open(wishes: Sender<Wish>) -> io::Result<Option<Self>> {
        if !io::stdin().is_terminal() || !is_in_front() {
            return Ok(None);
        }
        let before = tcgetattr(io::stdin())?;
        let mut single = before.clone();
        single
            .local_modes
            .remove(LocalModes::ICANON | LocalModes::ECHO);
        tcsetattr(io::stdin(), OptionalActions::Now, &single)?;
        let keys = Self { before };
        std::thread::Builder::new().spawn(move || listen(&wishes))?;
        Ok(Some(keys))
    }
}

impl Drop for Keys {
    fn drop(&mut self) {
        // From the background the system would stop this program for it.
        if is_in_front() {
            let _ = tcsetattr(io::stdin(), OptionalActions::Now, &self.before);
        }
    }
}

/// Whether this program has the terminal: another one that read from it or set it up would be stopped, with its drives enabled.
fn is_in_front() -> bool {
    tcgetpgrp(io::stdin()).is_ok_and(|group| group == getpgrp())
}

fn listen(wishes: &Sender<Wish>) {
    let patience = Timespec::try_from(LOOK).ok();
    loop {
        let stdin = io::stdin();
        let mut waiting = [PollFd::from_borrowed_fd(stdin.as_fd(), PollFlags::IN)];
        let has_key = poll(&mut waiting, patience.as_ref()).is_ok_and(|ready| ready > 0);
        if !has_key || !is_in_front() {
            if has_key {
                std::thread::sleep(LOOK);
            }
            continue;
        }
        let mut key = [0];
        if !stdin.lock().read(&mut key).is_ok_and(|length| length == 1) {
            return;
        }
        if let Some(wish) = wish(key[0])
            && wishes.send(wish).is_err()
        {
            return;
        }
    }
}

/// The meaning of a key.
pub(crate) fn wish(key: u8) -> Option<Wish> {
    Some(match key {
        b' ' | b'p' => Wish::TogglePause,
        b'+' | b'=' => Wish::Faster,
        b'-' => Wish::Slower,
        b'1' => Wish::Order(Order::Override(100)),
        b's' | b'q' => Wish::Order(Order::Stop),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_named_in_their_help() {
        assert_eq!(wish(b' '), Some(Wish::TogglePause));
        assert_eq!(wish(b's'), Some(Wish::Order(Order::Stop)));
        assert_eq!(wish(b'1'), Some(Wish::Order(Order::Override(100))));
        assert_eq!(wish(b'x'), None);
        for word in ["space pause", "+ - speed", "1 back", "s stop"] {
            assert!(HELP.contains(word));
        }
    }
}
