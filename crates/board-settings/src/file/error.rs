//! What is wrong with a file, and where.

use core::fmt;
use std::borrow::ToOwned;
use std::string::String;

/// A place in a file, both numbers from 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// The line.
    pub line: usize,
    /// The character in it.
    pub column: usize,
}

impl Place {
    /// The place of a byte; one inside a character is the place of the character.
    #[must_use]
    pub fn of(text: &str, byte: usize) -> Self {
        let mut place = Self { line: 1, column: 1 };
        for (_, character) in text.char_indices().take_while(|(at, _)| *at < byte) {
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

/// What is wrong with a file. The text has no name of a file: put it in front, as in `board.toml: {error}`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileError {
    /// Where.
    pub place: Place,
    /// What was expected.
    pub expected: String,
    /// What stands there.
    pub actual: String,
    /// What to do.
    pub advice: String,
}

impl FileError {
    pub(super) fn new(place: Place, expected: &str, actual: &str, advice: &str) -> Self {
        Self {
            place,
            expected: expected.to_owned(),
            actual: actual.to_owned(),
            advice: advice.to_owned(),
        }
    }
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

impl core::error::Error for FileError {}
