//! Exit codes of the tool.

/// A promise was broken: a sum differs, a cycle was late, an axis faulted.
pub(crate) const BROKEN_PROMISE: u8 = 1;
/// The input cannot be used; nothing was run. clap uses the same number for a wrong command line.
pub(crate) const BAD_INPUT: u8 = 2;
/// Lines of a log could not be read; the others were.
pub(crate) const DAMAGED_LOG: u8 = 1;
