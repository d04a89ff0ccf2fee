//! Waiting for bytes.

use std::io;
use std::time::Duration;

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::io::Errno;

use crate::system::Input;

/// Waits until one of these brings something, at most so long.
///
/// # Errors
/// Of the system.
pub(crate) fn wait_for_input(inputs: &[Input<'_>], most: Duration) -> io::Result<()> {
    let timeout = Timespec {
        tv_sec: most.as_secs().try_into().unwrap_or(i64::MAX),
        tv_nsec: most.subsec_nanos().into(),
    };
    let mut watched: Vec<PollFd<'_>> = inputs
        .iter()
        .map(|input| match input {
            Input::Terminal(terminal) => PollFd::new(*terminal, PollFlags::IN),
            Input::Stream(stream) => PollFd::new(*stream, PollFlags::IN),
            Input::Listener(listener) => PollFd::new(*listener, PollFlags::IN),
        })
        .collect();
    match poll(&mut watched, Some(&timeout)) {
        Ok(_) | Err(Errno::INTR) => Ok(()),
        Err(error) => Err(error.into()),
    }
}
