//! What can be wrong with a trajectory file; each message names the line where there is one.

use core::fmt;

/// A trajectory that cannot be run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum TrajectoryError {
    /// The file cannot be read as text.
    Unreadable { line: u64, reason: String },
    /// No line with numbers.
    Empty,
    /// Fewer than two lines with numbers: nothing moves.
    SinglePoint { line: u64 },
    /// A field that is not a number.
    NotANumber {
        line: u64,
        column: usize,
        actual: String,
    },
    /// A number that is infinite or not a number.
    NotFinite {
        line: u64,
        column: usize,
        actual: String,
    },
    /// A line with fewer or more fields than the first.
    FieldCount {
        line: u64,
        expected: usize,
        actual: usize,
    },
    /// Time does not go on.
    TimeOrder {
        line: u64,
        before_s: f64,
        actual_s: f64,
    },
    /// A column that the file does not have.
    NoSuchColumn { wanted: String, available: String },
    /// A column range that is not `N` or `N-M`.
    BadRange { wanted: String },
    /// Fewer columns than axes.
    TooFewColumns { expected: usize, actual: usize },
    /// A list that must have one entry, or one for each axis.
    ListLength {
        what: &'static str,
        expected: usize,
        actual: usize,
    },
    /// The motion leaves the 28 bit of the protocol.
    Travel {
        line: u64,
        axis: usize,
        actual_counts: f64,
    },
    /// The axis would have to move further in a cycle than it may.
    Step {
        line: u64,
        axis: usize,
        limit_counts: u16,
        actual_counts: i64,
        cycle_us: u32,
    },
}

impl fmt::Display for TrajectoryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable { line, reason } => write!(f, "line {line}: {reason}"),
            Self::Empty => {
                f.write_str("no line with numbers; expected time and positions, one point a line")
            }
            Self::SinglePoint { line } => {
                write!(
                    f,
                    "line {line}: only one point; a motion needs at least two"
                )
            }
            Self::NotANumber {
                line,
                column,
                actual,
            } => {
                write!(
                    f,
                    "line {line}, column {column}: expected a number, got \"{actual}\""
                )
            }
            Self::NotFinite {
                line,
                column,
                actual,
            } => {
                write!(
                    f,
                    "line {line}, column {column}: expected a finite number, got {actual}"
                )
            }
            Self::FieldCount {
                line,
                expected,
                actual,
            } => {
                write!(
                    f,
                    "line {line}: expected {expected} columns as in the first line, got {actual}"
                )
            }
            Self::TimeOrder {
                line,
                before_s,
                actual_s,
            } => write!(
                f,
                "line {line}: time must increase, got {actual_s} s after {before_s} s"
            ),
            Self::NoSuchColumn { wanted, available } => {
                write!(
                    f,
                    "there is no column \"{wanted}\"; the file has {available}"
                )
            }
            Self::BadRange { wanted } => {
                write!(
                    f,
                    "\"{wanted}\" is not a column: give a name, a number from 1, or a range as in 2-7"
                )
            }
            Self::TooFewColumns { expected, actual } => {
                write!(
                    f,
                    "expected {expected} axes, the file has {actual} columns beside time"
                )
            }
            Self::ListLength {
                what,
                expected,
                actual,
            } => {
                write!(
                    f,
                    "{what}: expected one value, or {expected} for {expected} axes, got {actual}"
                )
            }
            Self::Travel {
                line,
                axis,
                actual_counts,
            } => write!(
                f,
                "line {line}: axis {axis} would leave the 28-bit travel of its drive, {actual_counts:.0} counts from the start; lower the gear ratio or the counts per turn"
            ),
            Self::Step {
                line,
                axis,
                limit_counts,
                actual_counts,
                cycle_us,
            } => write!(
                f,
                "line {line}: axis {axis} would have to move {actual_counts} counts in one cycle of {cycle_us} us, its limit is {limit_counts}; slow the motion down or raise --max-step (at most 16384)"
            ),
        }
    }
}

impl std::error::Error for TrajectoryError {}
