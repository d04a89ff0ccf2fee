//! What is no program.

use core::fmt;

/// What is wrong, and where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProgramError {
    /// Counted from 1.
    pub line: u32,
    /// Counted from 1, in bytes.
    pub column: u32,
    /// What it is.
    pub kind: ErrorKind,
}

/// What is wrong with a line.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ErrorKind {
    /// A line that is longer than [`crate::LONGEST_LINE`] bytes.
    Long {
        /// Its bytes.
        actual: usize,
    },
    /// More words than any line needs.
    ManyWords,
    /// A character that belongs to no word.
    Character {
        /// The character.
        actual: char,
    },
    /// A letter without a number, or with one that is none.
    Number {
        /// The letter.
        letter: char,
    },
    /// A number with more than 9 digits before the point, or more than 20 characters.
    LongNumber,
    /// A G or M word that is not part of the subset.
    UnknownCode {
        /// G or M.
        letter: char,
        /// Its number, times 10.
        actual_tenths: u32,
    },
    /// A word with another letter than those of the subset.
    UnknownLetter {
        /// The letter.
        actual: char,
    },
    /// A comment that does not end in its line.
    OpenComment,
    /// Two words with the same letter.
    Twice {
        /// The letter.
        letter: char,
    },
    /// Two codes of which only one can apply to a line.
    Conflict {
        /// G or M.
        letter: char,
        /// The two numbers.
        actual: (u32, u32),
    },
    /// A word that nothing in its line uses.
    Unused {
        /// The letter.
        letter: char,
    },
    /// Coordinates, and neither this line nor one before says how to move.
    NoMotion,
    /// A move that needs a feed, and none was given.
    NoFeed,
    /// A feed that is not positive.
    Feed,
    /// A coordinate that the machine does not have.
    NoAxis {
        /// X, Y or Z.
        letter: char,
    },
    /// A coordinate or a radius beyond ±268 m.
    Far,
    /// An arc without a centre or a radius, or with both.
    ArcForm,
    /// An arc with a radius between start and end that are the same.
    ArcClosed,
    /// A radius too small for the distance between start and end.
    ArcRadius {
        /// The smallest, in micrometres.
        least_um: f32,
        /// The radius.
        actual_um: f32,
    },
    /// A centre that is not as far from the end as from the start.
    ArcCentre {
        /// Distance of the start in micrometres.
        start_um: f32,
        /// Distance of the end.
        end_um: f32,
    },
    /// A dwell without P, or with one that is not 0 to 3600 seconds.
    Dwell,
    /// A tolerance that is not positive.
    Tolerance,
}

impl fmt::Display for ProgramError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "line {}, column {}: {}",
            self.line, self.column, self.kind
        )
    }
}

impl fmt::Display for ErrorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Long { actual } => write!(
                f,
                "a line has at most {} bytes, this one has {actual}",
                crate::LONGEST_LINE
            ),
            Self::ManyWords => write!(f, "a line has at most {} words", crate::MOST_WORDS),
            Self::Character { actual } => write!(f, "{actual:?} belongs to no word"),
            Self::Number { letter } => write!(f, "expected a number behind {letter}"),
            Self::LongNumber => f.write_str(
                "a number has at most 9 digits before its point and 20 characters in all",
            ),
            Self::UnknownCode {
                letter,
                actual_tenths,
            } => {
                write!(f, "{letter}{}", actual_tenths / 10)?;
                if actual_tenths % 10 != 0 {
                    write!(f, ".{}", actual_tenths % 10)?;
                }
                f.write_str(" is not known: expected G0 to G4, G17 to G21, G28, G61, G64, G90, G91, M0, M2 or M30")
            }
            Self::UnknownLetter { actual } => write!(
                f,
                "{actual} is not known: expected one of F G I J K M N P R X Y Z"
            ),
            Self::OpenComment => f.write_str("a comment ends in its line, with )"),
            Self::Twice { letter } => write!(f, "a line has one {letter}, this is the second"),
            Self::Conflict {
                letter,
                actual: (first, second),
            } => write!(
                f,
                "{letter}{first} and {letter}{second} cannot be in one line"
            ),
            Self::Unused { letter } => write!(f, "nothing in this line uses {letter}"),
            Self::NoMotion => {
                f.write_str("nothing says how to move: expected G0, G1, G2 or G3 here or before")
            }
            Self::NoFeed => f.write_str("no feed is given: expected an F word here or before"),
            Self::Feed => f.write_str("a feed must be above 0"),
            Self::NoAxis { letter } => write!(f, "the machine has no axis {letter}"),
            Self::Far => f.write_str("a coordinate or a radius must be -268 m to 268 m"),
            Self::ArcForm => f.write_str(
                "an arc needs its centre (I, J, K of its plane) or its radius (R), and not both",
            ),
            Self::ArcClosed => {
                f.write_str("a full circle needs its centre: with R it may be any of them")
            }
            Self::ArcRadius {
                least_um,
                actual_um,
            } => write!(
                f,
                "the radius must be at least half of the way, {:.4} mm, it is {:.4} mm",
                least_um * 1e-3,
                actual_um * 1e-3
            ),
            Self::ArcCentre { start_um, end_um } => write!(
                f,
                "the centre is {:.4} mm from the start and {:.4} mm from the end of the arc",
                start_um * 1e-3,
                end_um * 1e-3
            ),
            Self::Dwell => f.write_str("a dwell needs P with 0 to 3600 seconds"),
            Self::Tolerance => f.write_str("a tolerance (P of G64) must be above 0"),
        }
    }
}

impl core::error::Error for ProgramError {}
