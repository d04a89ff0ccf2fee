//! What can be wrong with a motion file; each message names the line and the column where there is one, and the option that
//! helps.

mod words;

use core::fmt;

use super::unit::{TimeUnit, Unit};
pub(super) use words::duration;

/// A place in a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Place {
    /// Line, from 1.
    pub(super) line: u64,
    pub(super) column: Option<ColumnLabel>,
}

impl Place {
    pub(super) const fn line(line: u64) -> Self {
        Self { line, column: None }
    }

    pub(super) fn cell(line: u64, column: &ColumnLabel) -> Self {
        Self {
            line,
            column: Some(column.clone()),
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "line {}", self.line)?;
        match &self.column {
            Some(column) => write!(f, ", {column}"),
            None => Ok(()),
        }
    }
}

/// A column as messages call it: `column 2 (elbow)`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ColumnLabel {
    /// From 1.
    pub(super) number: usize,
    /// Empty without a header line.
    pub(super) name: String,
}

impl fmt::Display for ColumnLabel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "column {}", self.number)?;
        if self.name.is_empty() {
            Ok(())
        } else {
            write!(f, " ({})", self.name)
        }
    }
}

/// A trajectory that cannot be run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum TrajectoryError {
    /// The file cannot be read any further.
    Unreadable { line: u64, reason: String },
    /// Not UTF-8 and not a code page of eight bits.
    Encoding { line: u64 },
    /// A line that no motion file has.
    LongLine { place: Place },
    /// More numbers than a motion may have.
    TooLarge { line: u64, most: usize },
    /// No line with numbers.
    Empty,
    /// Fewer than two lines with numbers: nothing moves.
    SinglePoint { line: u64 },
    /// A field that is not a number.
    NotANumber { place: Place, actual: String },
    /// A number that is infinite or not a number.
    NotFinite { place: Place, actual: String },
    /// An empty field.
    Missing { place: Place },
    /// A number with a decimal comma.
    DecimalComma { place: Place, actual: String },
    /// A first line that is neither a header nor numbers.
    MixedLine {
        line: u64,
        number: (usize, String),
        text: (usize, String),
    },
    /// A quoted field that does not end in its line.
    OpenQuote { line: u64 },
    /// A line with fewer or more fields than the first.
    FieldCount {
        line: u64,
        first_line: u64,
        expected: usize,
        actual: usize,
        /// First field that the line lacks.
        lacks: Option<ColumnLabel>,
    },
    /// Time does not go on.
    TimeOrder {
        place: Place,
        before: String,
        actual: String,
    },
    /// The motion lasts longer than it may.
    TooLong {
        place: Place,
        duration_s: f64,
        most_s: f64,
        unit: TimeUnit,
    },
    /// A column that the file does not have.
    NoSuchColumn { wanted: String, available: String },
    /// A name that several columns have.
    SameName {
        name: String,
        columns: Vec<ColumnLabel>,
    },
    /// A column range that is not `N` or `N-M`.
    BadRange { wanted: String },
    /// The time column was chosen as a position.
    TimeIsPosition { column: ColumnLabel },
    /// Fewer columns than axes.
    TooFewColumns {
        line: u64,
        expected: usize,
        actual: usize,
    },
    /// No name says which column is time.
    NoTime { line: u64, names: Vec<ColumnLabel> },
    /// Several names say that they are time.
    SeveralTimes {
        line: u64,
        columns: Vec<ColumnLabel>,
    },
    /// No name says which column moves an axis.
    NoAxes { line: u64, left_out: Vec<String> },
    /// The names do not say which columns move an axis.
    Doubtful {
        line: u64,
        columns: Vec<ColumnLabel>,
        reason: &'static str,
    },
    /// Without names several readings are possible.
    NoNames {
        line: u64,
        width: usize,
        /// Columns whose numbers increase from line to line, when they were compared.
        rising: Option<Vec<usize>>,
    },
    /// The unit in a name is not the unit of the option.
    UnitConflict {
        column: ColumnLabel,
        named: String,
        option: String,
    },
    /// A unit in a name in which nothing is read.
    ForeignUnit {
        column: ColumnLabel,
        unit: String,
        expected: &'static str,
    },
    /// Some names carry a unit and others do not.
    MixedUnits {
        with: ColumnLabel,
        unit: Unit,
        without: ColumnLabel,
    },
    /// Millimetres without the travel of a turn.
    NoMmPerTurn { column: ColumnLabel },
    /// The travel of a turn for an axis that is not in millimetres.
    MmPerTurnUnused { column: ColumnLabel, unit: Unit },
    /// A list that must have one entry, or one for each axis.
    ListLength {
        what: &'static str,
        expected: usize,
        actual: usize,
    },
    /// The motion leaves the 28 bit of the protocol.
    Travel { place: Place, actual_counts: f64 },
    /// The axis would have to move further in a cycle than it may.
    Step {
        place: Place,
        limit_counts: u16,
        actual_counts: i64,
        cycle_us: u32,
    },
}

impl std::error::Error for TrajectoryError {}
