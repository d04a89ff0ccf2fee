//! What the tool prints.
//!
//! A pipe that somebody closed, or a full disk, must not end the program where it stands: drives may be enabled. So nothing here
//! panics, and clippy keeps `println!` and `eprintln!` out of the tool.

use core::fmt;
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::sync::{Mutex, PoisonError};

use schemars::JsonSchema;
use serde::Serialize;

/// Messages that wait until a view gives the terminal back.
static HELD: Mutex<Option<Vec<String>>> = Mutex::new(None);

/// Whether somebody has read what was printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Printed {
    /// As far as anybody knows.
    Read,
    /// The reader has gone, as `head` does when it has enough.
    NobodyReads,
}

/// Tells the user something on standard error. Nothing depends on somebody reading it. While a view has the terminal, the view
/// shows it, and it is written when the view ends.
pub(crate) fn tell(text: impl fmt::Display) {
    let is_held = {
        let mut held = HELD.lock().unwrap_or_else(PoisonError::into_inner);
        match held.as_mut() {
            Some(held) => {
                held.push(text.to_string());
                io::stderr().is_terminal()
            }
            None => false,
        }
    };
    if !is_held {
        let _ = writeln!(io::stderr().lock(), "{text}");
    }
}

/// From now on a view has the terminal.
pub(crate) fn hold() {
    let mut held = HELD.lock().unwrap_or_else(PoisonError::into_inner);
    held.get_or_insert_default();
}

/// The view has ended: writes what the terminal did not show.
pub(crate) fn release() {
    let mut held = HELD.lock().unwrap_or_else(PoisonError::into_inner);
    let texts = held.take().unwrap_or_default();
    drop(held);
    if io::stderr().is_terminal() {
        for text in texts {
            let _ = writeln!(io::stderr().lock(), "{text}");
        }
    }
}

/// The newest messages since the view began.
pub(crate) fn held(most: usize) -> Vec<String> {
    let held = HELD.lock().unwrap_or_else(PoisonError::into_inner);
    let texts = held.as_deref().unwrap_or_default();
    texts[texts.len().saturating_sub(most)..].to_vec()
}

/// Prints a result on standard output.
///
/// # Errors
/// When it cannot be written, as on a full disk. A reader that has gone is no error.
pub(crate) fn print(text: impl fmt::Display) -> io::Result<Printed> {
    let mut out = io::stdout().lock();
    outcome(writeln!(out, "{text}").and_then(|()| out.flush()))
}

/// Prints a result as JSON on standard output, on several lines.
///
/// # Errors
/// As [`print()`].
pub(crate) fn print_json(value: &(impl Serialize + JsonSchema)) -> io::Result<Printed> {
    print(serde_json::to_string_pretty(value)?)
}

/// A reader that has gone is no error.
pub(crate) fn outcome(written: io::Result<()>) -> io::Result<Printed> {
    match written {
        Ok(()) => Ok(Printed::Read),
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(Printed::NobodyReads),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reader_that_has_gone_is_no_error_and_a_full_disk_is_one() {
        let gone = io::Error::from(ErrorKind::BrokenPipe);
        assert!(matches!(outcome(Err(gone)), Ok(Printed::NobodyReads)));
        let full = io::Error::from(ErrorKind::StorageFull);
        assert!(outcome(Err(full)).is_err());
        assert!(matches!(outcome(Ok(())), Ok(Printed::Read)));
    }
}
