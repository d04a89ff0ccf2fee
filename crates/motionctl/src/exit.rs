//! Exit codes of the tool.

use std::error::Error;

/// A promise was broken: a sum differs, a cycle was late, an axis faulted.
pub(crate) const BROKEN_PROMISE: u8 = 1;
/// The input cannot be used; nothing was run. clap uses the same number for a wrong command line.
pub(crate) const BAD_INPUT: u8 = 2;
/// Lines of a log could not be read; the others were.
pub(crate) const DAMAGED_LOG: u8 = 1;
/// The bus or its adapter cannot be used, or failed on the way.
pub(crate) const LINK_FAILED: u8 = 3;
/// Some of what was to be stored is stored, and some is not.
pub(crate) const PARTLY_DONE: u8 = 4;
/// The user asked to stop before the end; the number that shells use for Ctrl-C.
pub(crate) const INTERRUPTED: u8 = 130;

/// An error that knows the exit status that it ends the tool with.
pub(crate) trait Coded: Error + 'static {
    /// The exit status.
    fn exit_code(&self) -> u8;
}

/// An error, and the exit status that it ends the tool with.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) code: u8,
    pub(crate) error: Box<dyn Error>,
}

impl Failure {
    /// An error with a status of its own.
    pub(crate) fn coded(error: impl Coded) -> Self {
        Self {
            code: error.exit_code(),
            error: Box::new(error),
        }
    }
}

impl<E: Error + 'static> From<E> for Failure {
    /// An error that was found before anything ran.
    fn from(error: E) -> Self {
        Self {
            code: BAD_INPUT,
            error: Box::new(error),
        }
    }
}
