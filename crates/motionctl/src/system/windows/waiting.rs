//! Waiting for bytes.

use std::io::{self, ErrorKind};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::system::Input;

/// How often is looked: the system waits for sockets only through unsafe calls, and its timeout of a read is too coarse.
const LOOK: Duration = Duration::from_millis(1);

/// Waits until one of these brings something, at most so long. Whoever connects is seen at the end of the wait:
/// nothing but letting them in tells that somebody has come.
///
/// # Errors
/// Never; other systems may refuse to wait.
pub(crate) fn wait_for_input(inputs: &[Input<'_>], most: Duration) -> io::Result<()> {
    let until = Instant::now() + most;
    loop {
        let left = until.saturating_duration_since(Instant::now());
        if left.is_zero() || inputs.iter().any(has_something) {
            return Ok(());
        }
        sleep(left.min(LOOK));
    }
}

fn has_something(input: &Input<'_>) -> bool {
    match input {
        Input::Terminal(terminal) => match **terminal {},
        // An end and an error are something as well.
        Input::Stream(stream) => !stream
            .peek(&mut [0])
            .is_err_and(|error| error.kind() == ErrorKind::WouldBlock),
        Input::Listener(listener) => listener.take_error().is_ok_and(|error| error.is_some()),
    }
}
