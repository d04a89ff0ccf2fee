//! What the tool prints.
//!
//! A pipe that somebody closed, or a full disk, must not end the program where it stands: drives may be enabled. So nothing here
//! panics, and clippy keeps `println!` and `eprintln!` out of the tool.

use core::fmt;
use std::io::{self, ErrorKind, Write};

use serde::Serialize;

/// Whether somebody has read what was printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Printed {
    /// As far as anybody knows.
    Read,
    /// The reader has gone, as `head` does when it has enough.
    NobodyReads,
}

/// Tells the user something on standard error. Nothing depends on somebody reading it.
pub(crate) fn tell(text: impl fmt::Display) {
    let _ = writeln!(io::stderr().lock(), "{text}");
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
pub(crate) fn print_json(value: &impl Serialize) -> io::Result<Printed> {
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
