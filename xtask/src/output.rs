//! What a task prints.

use std::fmt::Display;
use std::io::{ErrorKind, Write, stdout};

use crate::error::Error;

/// Prints a text. A reader that has enough (`| head`) is no failure, and the task goes on.
///
/// # Errors
/// When it cannot be written.
pub(crate) fn print(text: impl Display) -> Result<(), Error> {
    let mut out = stdout().lock();
    match write!(out, "{text}").and_then(|()| out.flush()) {
        Err(reason) if reason.kind() != ErrorKind::BrokenPipe => Err(Error::Output { reason }),
        _ => Ok(()),
    }
}
