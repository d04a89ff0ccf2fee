//! Columns of comma separated logs, found by the names in their first line.

use super::error::LineError;

/// The places of the columns that a format reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Places<const N: usize>([Option<usize>; N]);

impl<const N: usize> Default for Places<N> {
    fn default() -> Self {
        Self([None; N])
    }
}

impl<const N: usize> Places<N> {
    /// Finds the columns in a first line, whatever the case of their names.
    pub(super) fn find(header: &str, names: [&str; N]) -> Self {
        Self(names.map(|name| {
            let mut columns = header.split(',').map(str::trim_ascii);
            columns.position(|column| column.eq_ignore_ascii_case(name))
        }))
    }

    /// Whether the first columns of the list are there.
    pub(super) fn has_first(&self, count: usize) -> bool {
        self.0.iter().take(count).all(Option::is_some)
    }

    /// The field of a column; `None` when the header lacks the column.
    pub(super) fn optional<'a>(&self, line: &'a str, column: usize) -> Option<&'a str> {
        line.split(',')
            .nth((*self.0.get(column)?)?)
            .map(str::trim_ascii)
    }

    /// The field of a column that every line must have.
    pub(super) fn field<'a>(
        &self,
        line: &'a str,
        column: usize,
        expected: &'static str,
    ) -> Result<&'a str, LineError> {
        self.optional(line, column)
            .ok_or(LineError::Missing { expected })
    }
}
