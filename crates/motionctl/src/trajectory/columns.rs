//! Which column is time and which columns are axes.

use super::table::Row;
use super::{Table, TrajectoryError};

/// How far a column may be from the derivative of another, relative to its largest value, to count as its velocity.
const VELOCITY_TOLERANCE: f64 = 0.05;
/// One row in so many may be further off: planned velocities jump where segments meet.
const VELOCITY_MISSES_ONE_IN: usize = 50;
/// Fewer rows prove nothing: between two points almost any column passes for a velocity.
const VELOCITY_FEWEST_ROWS: usize = 3;

/// What the user asked for.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct ColumnChoice {
    /// Column of time; the first when not given.
    pub(crate) time: Option<String>,
    /// Columns of positions, by name, number or range; all but time when not given.
    pub(crate) positions: Vec<String>,
    /// Number of axes, taken from the left.
    pub(crate) axes: Option<usize>,
}

/// Columns by index from 0.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Columns {
    /// Column of time.
    pub(crate) time: usize,
    /// One column an axis.
    pub(crate) positions: Vec<usize>,
    /// Columns left out because they are the velocities of the others.
    pub(crate) velocities: Vec<usize>,
}

impl Columns {
    /// Finds the columns in a table.
    pub(crate) fn choose(choice: &ColumnChoice, table: &Table) -> Result<Self, TrajectoryError> {
        let time = match &choice.time {
            Some(wanted) => one(wanted, table)?,
            None => 0,
        };
        let mut positions = if choice.positions.is_empty() {
            (0..table.width())
                .filter(|&column| column != time)
                .collect()
        } else {
            let lists = choice.positions.iter().map(|wanted| range(wanted, table));
            lists.collect::<Result<Vec<_>, _>>()?.concat()
        };
        let mut velocities = Vec::new();
        match choice.axes {
            Some(expected) if expected > positions.len() => {
                return Err(TrajectoryError::TooFewColumns {
                    expected,
                    actual: positions.len(),
                });
            }
            Some(expected) => positions.truncate(expected),
            None if choice.positions.is_empty() => {
                velocities = split_velocities(table, time, &mut positions);
            }
            None => {}
        }
        if positions.is_empty() {
            return Err(TrajectoryError::TooFewColumns {
                expected: 1,
                actual: 0,
            });
        }
        Ok(Self {
            time,
            positions,
            velocities,
        })
    }
}

/// Planners write positions followed by velocities. When the right half of the columns is the derivative of the left
/// half throughout, it is not a second set of axes: it is taken off and returned.
fn split_velocities(table: &Table, time: usize, positions: &mut Vec<usize>) -> Vec<usize> {
    let is_telling = table.rows.len() >= VELOCITY_FEWEST_ROWS;
    if !is_telling || positions.len() < 2 || !positions.len().is_multiple_of(2) {
        return Vec::new();
    }
    let half = positions.len() / 2;
    let is_derivative =
        (0..half).all(|axis| is_velocity(table, time, positions[axis], positions[axis + half]));
    if is_derivative {
        positions.split_off(half)
    } else {
        Vec::new()
    }
}

fn is_velocity(table: &Table, time: usize, position: usize, velocity: usize) -> bool {
    let values = |row: &Row| (row.values[time], row.values[position], row.values[velocity]);
    let largest = table
        .rows
        .iter()
        .map(|row| values(row).2.abs())
        .fold(0.0, f64::max);
    let misses = table.rows.windows(2).filter(|pair| {
        let ((from_s, from, leaving), (to_s, to, arriving)) = (values(&pair[0]), values(&pair[1]));
        let mean = (to - from) / (to_s - from_s);
        // The mean over a step is the velocity at its end in some planners, at its start in others.
        let error = (mean - arriving).abs().min((mean - leaving).abs());
        // Where time stands still the mean is not a number.
        error.is_nan() || error > VELOCITY_TOLERANCE * largest
    });
    // A column of zeros is a standing axis, not somebody's velocity.
    largest > 0.0 && misses.count() * VELOCITY_MISSES_ONE_IN <= table.rows.len()
}

fn range(wanted: &str, table: &Table) -> Result<Vec<usize>, TrajectoryError> {
    let bad = || TrajectoryError::BadRange {
        wanted: wanted.to_owned(),
    };
    match wanted.split_once('-') {
        Some((first, last)) if !table.names.iter().any(|name| name == wanted) => {
            let first: usize = first.trim().parse().map_err(|_| bad())?;
            let last: usize = last.trim().parse().map_err(|_| bad())?;
            if first > last {
                return Err(bad());
            }
            (first..=last)
                .map(|number| numbered(number, table))
                .collect()
        }
        _ => Ok(vec![one(wanted, table)?]),
    }
}

fn one(wanted: &str, table: &Table) -> Result<usize, TrajectoryError> {
    if let Some(index) = table.names.iter().position(|name| name == wanted) {
        return Ok(index);
    }
    match wanted.parse() {
        Ok(number) => numbered(number, table),
        Err(_) => Err(missing(wanted.to_owned(), table)),
    }
}

fn numbered(number: usize, table: &Table) -> Result<usize, TrajectoryError> {
    if number == 0 || number > table.width() {
        return Err(missing(number.to_string(), table));
    }
    Ok(number - 1)
}

fn missing(wanted: String, table: &Table) -> TrajectoryError {
    let available = if table.names.is_empty() {
        format!("columns 1 to {}", table.width())
    } else {
        table.names.join(", ")
    };
    TrajectoryError::NoSuchColumn { wanted, available }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn choose(
        text: &str,
        positions: &[&str],
        axes: Option<usize>,
    ) -> Result<Columns, TrajectoryError> {
        let choice = ColumnChoice {
            positions: positions.iter().map(ToString::to_string).collect(),
            axes,
            ..ColumnChoice::default()
        };
        Columns::choose(&choice, &Table::parse(text).unwrap())
    }

    #[test]
    fn columns_by_name_number_and_range() {
        let text = "t,a,b,c\n0,1,2,3\n";
        assert_eq!(choose(text, &["c", "2"], None).unwrap().positions, [3, 1]);
        assert_eq!(choose(text, &["2-4"], None).unwrap().positions, [1, 2, 3]);
        assert_eq!(choose(text, &[], Some(2)).unwrap().positions, [1, 2]);
        assert_eq!(choose(text, &[], None).unwrap().positions, [1, 2, 3]);
    }

    #[test]
    fn a_missing_column_tells_what_there_is() {
        let error = choose("t,a\n0,1\n", &["elbow"], None).unwrap_err();
        assert_eq!(
            error.to_string(),
            "there is no column \"elbow\"; the file has t, a"
        );
        assert!(matches!(
            choose("0,1\n", &["0"], None),
            Err(TrajectoryError::NoSuchColumn { .. })
        ));
        assert!(matches!(
            choose("0,1\n", &["5-2"], None),
            Err(TrajectoryError::BadRange { .. })
        ));
        assert_eq!(
            choose("0,1\n", &[], Some(2)),
            Err(TrajectoryError::TooFewColumns {
                expected: 2,
                actual: 1
            })
        );
    }

    #[test]
    fn velocities_are_recognised_and_positions_are_not_taken_for_them() {
        let velocities = "0 0 0 0 0\n1 10 5 10 5\n2 30 5 20 0\n";
        let columns = choose(velocities, &[], None).unwrap();
        assert_eq!(
            (columns.positions, columns.velocities),
            (vec![1, 2], vec![3, 4])
        );
        let two_axes = "0 0 0\n1 10 3\n2 30 9\n";
        assert_eq!(choose(two_axes, &[], None).unwrap().positions, [1, 2]);
        let second_stands = "0 0 0\n1 10 0\n2 30 0\n";
        assert_eq!(choose(second_stands, &[], None).unwrap().positions, [1, 2]);
    }

    #[test]
    fn two_points_are_two_axes() {
        let table = Table::parse("0,0,0\n60,36000,-36000\n").unwrap();
        let columns = Columns::choose(&ColumnChoice::default(), &table).unwrap();
        assert_eq!(
            (columns.positions, columns.velocities),
            (vec![1, 2], vec![])
        );
    }
}
