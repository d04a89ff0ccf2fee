//! Numbers of counts in messages.

use core::fmt;

/// A number of counts with the noun that fits.
pub(crate) struct Counts(pub(crate) i32);

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let noun = match self.0 {
            1 | -1 => "count",
            _ => "counts",
        };
        write!(f, "{} {noun}", self.0)
    }
}
