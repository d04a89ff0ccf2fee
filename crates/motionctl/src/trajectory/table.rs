//! Numbers in rows, each with the line that it came from.

use csv::{ReaderBuilder, StringRecord, Trim};

use super::TrajectoryError;

/// One line of numbers.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    /// Line in the file, from 1.
    pub(crate) line: u64,
    /// One number a column.
    pub(crate) values: Vec<f64>,
}

/// A text table of numbers, with names when it has a header line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Table {
    /// One name a column; empty without a header line.
    pub(crate) names: Vec<String>,
    /// At least one row, all of the same length.
    pub(crate) rows: Vec<Row>,
}

impl Table {
    /// Reads comma, semicolon, tab or space separated numbers. `#` starts a comment line; a first line that is not all
    /// numbers is the header.
    pub(crate) fn parse(text: &str) -> Result<Self, TrajectoryError> {
        let mut reader = ReaderBuilder::new()
            .delimiter(delimiter_of(text))
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
            .trim(Trim::All)
            .from_reader(text.as_bytes());
        let mut table = Self {
            names: Vec::new(),
            rows: Vec::new(),
        };
        for record in reader.records() {
            let record = record.map_err(|error| TrajectoryError::Unreadable {
                line: error.position().map_or(0, csv::Position::line),
                reason: error.to_string(),
            })?;
            table.take(&record)?;
        }
        if table.rows.is_empty() {
            return Err(TrajectoryError::Empty);
        }
        Ok(table)
    }

    /// Number of columns.
    pub(crate) fn width(&self) -> usize {
        self.rows.first().map_or(0, |row| row.values.len())
    }

    fn take(&mut self, record: &StringRecord) -> Result<(), TrajectoryError> {
        let line = record.position().map_or(0, csv::Position::line);
        // Space separated files have runs of spaces, and some tools leave one at the end of each line.
        let fields: Vec<&str> = record.iter().filter(|field| !field.is_empty()).collect();
        if fields.is_empty() {
            return Ok(());
        }
        if self.rows.is_empty() && self.names.is_empty() && !fields.iter().all(|f| is_number(f)) {
            self.names = fields.iter().map(ToString::to_string).collect();
            return Ok(());
        }
        let values = fields
            .iter()
            .enumerate()
            .map(|(index, field)| parse_number(field, line, index + 1))
            .collect::<Result<Vec<f64>, _>>()?;
        let expected = if self.names.is_empty() {
            self.width()
        } else {
            self.names.len()
        };
        if expected != 0 && values.len() != expected {
            return Err(TrajectoryError::FieldCount {
                line,
                expected,
                actual: values.len(),
            });
        }
        self.rows.push(Row { line, values });
        Ok(())
    }
}

/// The separator of the first line that is not a comment.
fn delimiter_of(text: &str) -> u8 {
    let first = text
        .lines()
        .find(|line| !line.trim().is_empty() && !line.starts_with('#'));
    let first = first.unwrap_or_default();
    [b',', b';', b'\t']
        .into_iter()
        .find(|&byte| first.contains(char::from(byte)))
        .unwrap_or(b' ')
}

fn is_number(field: &str) -> bool {
    field.parse::<f64>().is_ok()
}

fn parse_number(field: &str, line: u64, column: usize) -> Result<f64, TrajectoryError> {
    let actual = || field.to_owned();
    let value: f64 = field.parse().map_err(|_| TrajectoryError::NotANumber {
        line,
        column,
        actual: actual(),
    })?;
    if !value.is_finite() {
        return Err(TrajectoryError::NotFinite {
            line,
            column,
            actual: actual(),
        });
    }
    Ok(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_what_people_write() {
        for text in [
            "t,a\n0,1\n1,2\n",
            "# note\nt;a\n0;1\n1;2\n",
            "0 1 \n1  2 \n",
            "\n0\t1\n\n1\t2",
        ] {
            let table = Table::parse(text).unwrap();
            let values: Vec<_> = table.rows.iter().map(|row| row.values.clone()).collect();
            assert_eq!(values, [[0.0, 1.0], [1.0, 2.0]], "{text:?}");
        }
        assert_eq!(Table::parse("t,a\n0,1\n").unwrap().names, ["t", "a"]);
    }

    #[test]
    fn errors_name_line_and_column() {
        assert_eq!(
            Table::parse("t,a\n0,1\n1,fast\n"),
            Err(TrajectoryError::NotANumber {
                line: 3,
                column: 2,
                actual: "fast".into()
            })
        );
        assert_eq!(
            Table::parse("0 1\n1 nan\n"),
            Err(TrajectoryError::NotFinite {
                line: 2,
                column: 2,
                actual: "nan".into()
            })
        );
        assert_eq!(
            Table::parse("# c\n0,1\n1\n"),
            Err(TrajectoryError::FieldCount {
                line: 3,
                expected: 2,
                actual: 1
            })
        );
        assert_eq!(Table::parse("# nothing\n"), Err(TrajectoryError::Empty));
        assert_eq!(Table::parse("t,a\n"), Err(TrajectoryError::Empty));
    }
}
