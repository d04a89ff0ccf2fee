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

#[cfg(test)]
mod tests {
    use std::format;

    use super::*;

    #[test]
    fn one_count_is_no_counts() {
        let text = [-2, -1, 0, 1, 2].map(|counts| format!("{}", Counts(counts)));
        let expected = ["-2 counts", "-1 count", "0 counts", "1 count", "2 counts"];
        assert_eq!(text, expected);
    }
}
