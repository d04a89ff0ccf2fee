//! The words of each error.

use core::fmt;

use super::{ColumnLabel, TrajectoryError};
use crate::counted::counted;
use crate::trajectory::unit::TimeUnit;

/// Columns one after the other.
struct List<'a>(&'a [ColumnLabel]);

impl fmt::Display for List<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, column) in self.0.iter().enumerate() {
            let between = if index == 0 { "" } else { ", " };
            write!(f, "{between}{column}")?;
        }
        Ok(())
    }
}

impl fmt::Display for TrajectoryError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unreadable { line, reason } => write!(f, "line {line}: {reason}"),
            Self::Encoding { line } => write!(
                f,
                "line {line}: expected UTF-8 text, got UTF-16 or a file that is no text; save it as UTF-8"
            ),
            Self::LongLine { place } => write!(
                f,
                "{place}: expected a line of at most {} bytes, got a longer one: this is no motion file",
                super::super::lines::LONGEST_LINE
            ),
            Self::TooLarge { line, most } => write!(
                f,
                "line {line}: expected at most {most} times and positions, got more; split the motion, or thin its points out"
            ),
            Self::Empty => {
                f.write_str("no line with numbers; expected time and positions, one point a line")
            }
            Self::SinglePoint { line } => {
                write!(
                    f,
                    "line {line}: only one point; a motion needs at least two"
                )
            }
            Self::NotANumber { place, actual } => {
                write!(
                    f,
                    "{place}: expected a number, got \"{actual}\"; --columns leaves out columns that are not wanted"
                )
            }
            Self::NotFinite { place, actual } => {
                write!(f, "{place}: expected a finite number, got {actual}")
            }
            Self::Missing { place } => write!(
                f,
                "{place}: expected a number, got an empty field; fill it, or leave its column out with --columns"
            ),
            Self::DecimalComma { place, actual } => write!(
                f,
                "{place}: expected a number with a decimal point, got \"{actual}\"; if its comma is the decimal one, use --decimal-comma"
            ),
            Self::MixedLine { line, number, text } => write!(
                f,
                "line {line} mixes numbers and text: column {} is the number {}, column {} is \"{}\"; expected a header line of names alone, or a line of numbers alone",
                number.0, number.1, text.0, text.1
            ),
            other => other.fmt_choice(f),
        }
    }
}

impl TrajectoryError {
    /// What concerns the shape of the file and the choice of columns.
    fn fmt_choice(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FieldCount {
                line,
                first_line,
                expected,
                actual,
                lacks,
            } => {
                write!(
                    f,
                    "line {line}: expected {expected} columns as in line {first_line}, got {actual}"
                )?;
                match lacks {
                    Some(column) => write!(f, "; {column} is missing"),
                    None => f.write_str("; is there a separator too many, or a decimal comma?"),
                }
            }
            Self::NoSuchColumn { wanted, available } => write!(
                f,
                "there is no column \"{wanted}\"; the file has {available}"
            ),
            Self::SameName { name, columns } => write!(
                f,
                "several columns are called \"{name}\": {}; choose by number with --columns and --time-column",
                List(columns)
            ),
            Self::BadRange { wanted } => write!(
                f,
                "\"{wanted}\" is not a column: give a name, a number from 1, or a range as in 2-7"
            ),
            Self::TimeIsPosition { column } => write!(
                f,
                "{column} is the time and cannot move an axis: take it out of --columns, or give another --time-column"
            ),
            Self::TooFewColumns {
                line,
                expected,
                actual,
            } => write!(
                f,
                "line {line}: expected time and {}, got {} beside time",
                counted(*expected, "axis", "axes"),
                counted(*actual, "column", "columns")
            ),
            Self::OpenQuote { line } => write!(
                f,
                "line {line}: a quotation mark is open at the end of the line; expected every field to end in the line in which it begins"
            ),
            Self::NoTime { line, names } => write!(
                f,
                "line {line}: expected a column named time, got {}; name it, or give --time-column",
                List(names)
            ),
            Self::SeveralTimes { line, columns } => write!(
                f,
                "line {line}: expected one column of time, got {}; choose with --time-column",
                List(columns)
            ),
            Self::NoAxes { line, left_out } => write!(
                f,
                "line {line}: expected at least one column of positions, got {}; choose with --columns",
                if left_out.is_empty() {
                    "time alone".to_owned()
                } else {
                    left_out.join(", ")
                }
            ),
            Self::Doubtful {
                line,
                columns,
                reason,
            } => write!(
                f,
                "line {line}: the names do not say which columns move an axis: {} {reason}; choose with --columns",
                List(columns)
            ),
            Self::NoNames {
                line,
                width,
                rising,
            } => {
                write!(
                    f,
                    "line {line}: {width} columns without names, and it is not clear which is time and which move an axis"
                )?;
                if let Some(rising) = rising {
                    write!(f, " ({} of them increase from line to line)", rising.len())?;
                }
                f.write_str(
                    "; write a header line of names, or give --time-column N and --columns N,M or N-M, with numbers from 1",
                )
            }
            other => other.fmt_units(f),
        }
    }

    /// What concerns units, time and limits.
    fn fmt_units(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnitConflict {
                column,
                named,
                option,
            } => write!(
                f,
                "{column}: its name says {named}, the option says {option}; leave the option out, or correct the name"
            ),
            Self::ForeignUnit {
                column,
                unit,
                expected,
            } => write!(
                f,
                "{column}: expected {expected}, its name says \"{unit}\"; convert the column and rename it, or choose others with --columns"
            ),
            Self::MixedUnits {
                with,
                unit,
                without,
            } => write!(
                f,
                "{with} is in {unit} by its name, and the name of {without} has no unit; give --unit for all, or one for each axis"
            ),
            Self::NoMmPerTurn { column } => write!(
                f,
                "{column} is in millimetres: give --mm-per-turn (or --pitch-mm), the travel for one turn of the output"
            ),
            Self::MmPerTurnUnused { column, unit } => write!(
                f,
                "--mm-per-turn is for axes in millimetres, and {column} is in {unit}; give --unit mm, or a - in its place"
            ),
            Self::ListLength {
                what,
                expected,
                actual,
            } => match expected {
                1 => write!(f, "{what}: expected one value for 1 axis, got {actual}"),
                _ => write!(
                    f,
                    "{what}: expected one value, or {expected} for {expected} axes, got {actual}"
                ),
            },
            Self::TimeOrder {
                place,
                before,
                actual,
            } => write!(
                f,
                "{place}: time must increase, got {actual} after {before}"
            ),
            Self::TooLong {
                place,
                duration_s,
                most_s,
                unit,
            } => {
                write!(
                    f,
                    "{place}: read in {unit} the motion lasts {}, expected at most {}",
                    duration(*duration_s),
                    duration(*most_s)
                )?;
                let in_unit = duration_s * f64::from(unit.per_second());
                let in_s = |other: TimeUnit| in_unit / f64::from(other.per_second());
                let others = TimeUnit::ALL.into_iter();
                let others: Vec<String> = others
                    .filter(|other| in_s(*other) <= *most_s)
                    .map(|other| format!("{} in {other}", duration(in_s(other))))
                    .collect();
                if !others.is_empty() {
                    write!(f, "; with --time-unit it would be {}", others.join(", "))?;
                }
                f.write_str("; --max-duration raises the limit")
            }
            Self::Travel {
                place,
                actual_counts,
            } => write!(
                f,
                "{place}: the axis would leave the 28-bit travel of its drive, {} counts from the start; lower the gear ratio or the counts per turn",
                readable(*actual_counts)
            ),
            Self::Step {
                place,
                limit_counts,
                actual_counts,
                cycle_us,
            } => write!(
                f,
                "{place}: the axis would have to move {actual_counts} counts in one cycle of {cycle_us} us, its limit is {limit_counts}; slow the motion down or raise --max-step (at most 16384)"
            ),
            // The others are written by the functions that end here.
            _ => Ok(()),
        }
    }
}

/// Counts that may be beyond everything.
fn readable(counts: f64) -> String {
    if counts.abs() < 1e15 {
        format!("{counts:.0}")
    } else {
        format!("{counts:.1e}")
    }
}

/// A time that may be very long, in the unit that people read.
pub(crate) fn duration(seconds: f64) -> String {
    const HOUR: f64 = 3_600.0;
    const YEAR: f64 = 365.25 * 24.0 * HOUR;
    if seconds < 1e-3 {
        format!("{seconds:.1e} s")
    } else if seconds >= YEAR {
        format!("{:.1} years", seconds / YEAR)
    } else if seconds > 2.0 * HOUR {
        format!("{:.1} h", seconds / HOUR)
    } else {
        format!("{} s", (seconds * 1e3).round() / 1e3)
    }
}
