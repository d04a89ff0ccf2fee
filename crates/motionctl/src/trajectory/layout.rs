//! The columns of set-points that come one by one: names once, then numbers.

use super::axes_about;
use super::cells::{Cell, Separator};
use super::columns::{Column, Columns};
use super::error::TrajectoryError;
use super::name::Name;
use super::unit::{AxisScale, TimeUnit};
use crate::recording::AxisNaming;

/// What each field of a line is.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Layout {
    columns: Columns,
    width: usize,
    time_unit: TimeUnit,
    scales: Vec<AxisScale>,
}

/// A line that is no set-point.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum FieldError {
    /// More or fewer fields than names.
    Count { expected: usize, actual: usize },
    /// A field that is no number.
    NotANumber { name: String, actual: String },
    /// A field that is infinite or no number.
    NotFinite { name: String, actual: String },
}

/// A set-point: seconds on the clock of the sender, and positions in command counts.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct TimedCounts {
    pub(crate) time_s: f64,
    pub(crate) counts: Vec<f64>,
}

impl core::fmt::Display for FieldError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Count { expected, actual } => {
                write!(f, "expected {expected} fields, one a name, got {actual}")
            }
            Self::NotANumber { name, actual } => {
                write!(f, "{name}: expected a number, got {actual}")
            }
            Self::NotFinite { name, actual } => {
                write!(f, "{name}: expected a finite number, got {actual}")
            }
        }
    }
}

/// What can be shown of a field.
fn shown(field: &str) -> String {
    let start: String = field.chars().take(40).collect();
    start.escape_debug().to_string()
}

impl Layout {
    pub(super) fn new(
        columns: Columns,
        width: usize,
        time_unit: TimeUnit,
        scales: Vec<AxisScale>,
    ) -> Self {
        Self {
            columns,
            width,
            time_unit,
            scales,
        }
    }

    /// The names in a line, in the way that files have them.
    pub(super) fn names(line: &str, decimal_comma: bool) -> Vec<Name> {
        let line = line.trim().trim_start_matches(['#', '%']);
        let fields = Separator::of(line, decimal_comma).split(line);
        fields.iter().map(|field| Name::parse(field)).collect()
    }

    /// Whether a line is one of numbers.
    pub(super) fn has_numbers(line: &str, decimal_comma: bool) -> bool {
        let fields = Separator::of(line, decimal_comma).split(line);
        !fields.is_empty()
            && fields
                .iter()
                .all(|field| Cell::of(field, decimal_comma).is_numeric())
    }

    /// What the axes are called, and their units.
    pub(crate) fn naming(&self) -> Vec<AxisNaming> {
        let columns = self.columns.positions.iter().zip(&self.scales);
        let naming = columns.map(|(column, scale)| axes_about::naming(column, scale));
        naming.collect()
    }

    /// The set-point in a line.
    ///
    /// # Errors
    /// [`FieldError`].
    pub(crate) fn set_point(
        &self,
        line: &str,
        decimal_comma: bool,
    ) -> Result<TimedCounts, FieldError> {
        let fields = Separator::of(line, decimal_comma).split(line);
        if fields.len() != self.width {
            return Err(FieldError::Count {
                expected: self.width,
                actual: fields.len(),
            });
        }
        let number = |column: &Column| {
            let field = &fields[column.index];
            let (name, actual) = (column.label.name.clone(), shown(field));
            match Cell::of(field, decimal_comma) {
                Cell::Number(number) => Ok(number),
                Cell::NotFinite => Err(FieldError::NotFinite { name, actual }),
                _ => Err(FieldError::NotANumber { name, actual }),
            }
        };
        let values: Result<Vec<f64>, FieldError> =
            self.columns.positions.iter().map(number).collect();
        self.scaled(number(&self.columns.time)?, &values?)
    }

    /// The set-point of values that have their names with them, in any order.
    ///
    /// # Errors
    /// [`FieldError`].
    pub(crate) fn named_set_point(
        &self,
        values: &[(String, f64)],
    ) -> Result<TimedCounts, FieldError> {
        if values.len() != self.width {
            return Err(FieldError::Count {
                expected: self.width,
                actual: values.len(),
            });
        }
        let value = |column: &Column| {
            let name = &column.label.name;
            let found = values.iter().find(|(other, _)| other == name);
            found
                .map(|(_, value)| *value)
                .ok_or_else(|| FieldError::NotANumber {
                    name: name.clone(),
                    actual: "none of this name".to_owned(),
                })
        };
        let positions: Result<Vec<f64>, FieldError> =
            self.columns.positions.iter().map(value).collect();
        self.scaled(value(&self.columns.time)?, &positions?)
    }

    fn scaled(&self, time: f64, positions: &[f64]) -> Result<TimedCounts, FieldError> {
        let counts: Vec<f64> = positions
            .iter()
            .zip(&self.scales)
            .map(|(position, scale)| position * scale.counts_per_unit())
            .collect();
        let time_s = time / f64::from(self.time_unit.per_second());
        // Numbers that are finite can be infinite in another unit.
        if let Some(axis) = counts.iter().position(|counts| !counts.is_finite()) {
            return Err(FieldError::NotFinite {
                name: self.name(axis).to_owned(),
                actual: format!("{:e}", positions[axis]),
            });
        }
        Ok(TimedCounts { time_s, counts })
    }

    /// Number of axes.
    pub(crate) fn axes(&self) -> usize {
        self.scales.len()
    }

    /// The name of the column of an axis.
    pub(crate) fn name(&self, axis: usize) -> &str {
        self.columns
            .positions
            .get(axis)
            .map_or("", |column| &column.label.name)
    }

    /// A position, or one of its derivatives, in the unit of an axis, with that unit.
    pub(crate) fn in_unit(&self, axis: usize, counts: f64) -> (f64, String) {
        let Some(scale) = self.scales.get(axis) else {
            return (counts, "counts".to_owned());
        };
        (counts / scale.counts_per_unit(), scale.unit.to_string())
    }

    /// Seconds in the unit of the time column, with that unit.
    pub(crate) fn in_time_unit(&self, seconds: f64) -> (f64, String) {
        (
            seconds * f64::from(self.time_unit.per_second()),
            self.time_unit.to_string(),
        )
    }

    /// The columns in the order of the axes, and those that are left out.
    pub(crate) fn describe(&self) -> String {
        let axes: Vec<String> = (0..self.axes())
            .map(|axis| format!("{} in {}", self.name(axis), self.in_unit(axis, 0.0).1))
            .collect();
        let left: Vec<String> = self
            .columns
            .left_out
            .iter()
            .map(|(label, reason)| format!("; not driven: {label} ({reason})"))
            .collect();
        format!("{}{}", axes.join(", "), left.concat())
    }
}

/// Why a line of names cannot be used: another number of axes than there are drives.
pub(super) fn check_axes(line: u64, expected: usize, actual: usize) -> Result<(), TrajectoryError> {
    if actual == expected {
        return Ok(());
    }
    Err(TrajectoryError::TooFewColumns {
        line,
        expected,
        actual,
    })
}
