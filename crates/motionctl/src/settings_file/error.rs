//! What is wrong with a file of settings, and where.

use core::fmt;

/// A place in a file, both numbers from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) line: usize,
    pub(crate) column: usize,
}

impl Place {
    /// The place of a byte; one inside a character is the place of the character.
    pub(crate) fn of(text: &str, byte: usize) -> Self {
        let before = text.char_indices().take_while(|(at, _)| *at < byte);
        let mut place = Self { line: 1, column: 1 };
        for (_, character) in before {
            if character == '\n' {
                place.line += 1;
                place.column = 1;
            } else {
                place.column += 1;
            }
        }
        place
    }
}

/// What is wrong: a line without its file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FileError {
    pub(crate) place: Place,
    pub(crate) expected: String,
    pub(crate) actual: String,
    /// What to do.
    pub(crate) advice: String,
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            place: Place { line, column },
            expected,
            actual,
            advice,
        } = self;
        write!(
            f,
            "line {line}, column {column}: expected {expected}, got {actual}; {advice}"
        )
    }
}

impl std::error::Error for FileError {}
