//! Lines of twists: `time,v,omega` in s, m/s and rad/s.

use core::fmt;
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use diff_drive::{Twist, ValueError};

/// Largest file of twists: an hour at 100 Hz is a tenth of it.
const MOST_BYTES: u64 = 64 << 20;
const COLUMNS: [&str; 3] = ["time in s", "v in m/s", "omega in rad/s"];

/// A twist and when it shall begin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TwistLine {
    pub(crate) time_s: f64,
    pub(crate) twist: Twist,
}

/// What is wrong with a line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum TwistError {
    /// The file cannot be read.
    Read(String),
    /// Another number of columns.
    Columns { line: usize, actual: usize },
    /// A cell is no number.
    Number {
        line: usize,
        column: usize,
        actual: String,
    },
    /// A number is out of range.
    Value { line: usize, error: ValueError },
    /// The time does not go on.
    Time {
        line: usize,
        before_s: f64,
        actual_s: f64,
    },
    /// There is no twist at all.
    Empty,
}

impl fmt::Display for TwistError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Read(reason) => f.write_str(reason),
            Self::Columns { line, actual } => write!(
                f,
                "line {line}: expected the 3 columns time,v,omega, got {actual}"
            ),
            Self::Number {
                line,
                column,
                actual,
            } => write!(
                f,
                "line {line}, column {column}: expected a number ({}), got \"{}\"",
                COLUMNS.get(column - 1).copied().unwrap_or_default(),
                actual.escape_debug()
            ),
            Self::Value { line, error } => write!(f, "line {line}: {error}"),
            Self::Time {
                line,
                before_s,
                actual_s,
            } => write!(
                f,
                "line {line}: the time must be above that of the line before, {before_s} s, got {actual_s} s"
            ),
            Self::Empty => f.write_str("there is no line time,v,omega in it"),
        }
    }
}

impl std::error::Error for TwistError {}

/// Reads lines one after the other.
#[derive(Debug, Default)]
pub(crate) struct TwistReader {
    line: usize,
    before_s: Option<f64>,
}

impl TwistReader {
    /// The twist of a line; none for an empty line, a comment behind `#`, and a first line of names.
    ///
    /// # Errors
    /// [`TwistError`] with the number of the line.
    pub(crate) fn line(&mut self, text: &str) -> Result<Option<TwistLine>, TwistError> {
        self.line += 1;
        let line = self.line;
        let text = text.split('#').next().unwrap_or_default().trim();
        if text.is_empty() || self.is_header(text) {
            return Ok(None);
        }
        let cells: Vec<&str> = text.split([',', ';', '\t']).map(str::trim).collect();
        let [time, v, omega] = cells.as_slice() else {
            let actual = cells.len();
            return Err(TwistError::Columns { line, actual });
        };
        let number = |(column, cell): (usize, &&str)| {
            cell.parse::<f64>().map_err(|_| TwistError::Number {
                line,
                column: column + 1,
                actual: cell.chars().take(40).collect(),
            })
        };
        let time_s = number((0, time))?;
        let (v, omega) = (number((1, v))?, number((2, omega))?);
        let twist = Twist::new(v, omega).map_err(|error| TwistError::Value { line, error })?;
        self.check_time(time_s)?;
        self.before_s = Some(time_s);
        Ok(Some(TwistLine { time_s, twist }))
    }

    fn is_header(&self, text: &str) -> bool {
        self.before_s.is_none()
            && text.split([',', ';', '\t']).all(|cell| {
                cell.trim()
                    .starts_with(|letter: char| letter.is_alphabetic())
            })
    }

    fn check_time(&self, actual_s: f64) -> Result<(), TwistError> {
        let line = self.line;
        // NaN is above nothing.
        let is_first = self.before_s.is_none() && actual_s.is_finite();
        if is_first || self.before_s.is_some_and(|before| actual_s > before) && actual_s < 1e9 {
            return Ok(());
        }
        Err(TwistError::Time {
            line,
            before_s: self.before_s.unwrap_or(0.0),
            actual_s,
        })
    }
}

/// Every twist of a file; the times count from the first.
///
/// # Errors
/// [`TwistError`].
pub(crate) fn read_file(path: &Path) -> Result<Vec<TwistLine>, TwistError> {
    let cannot = |error| TwistError::Read(format!("cannot read it: {error}"));
    let mut text = String::new();
    let file = File::open(path).map_err(cannot)?;
    file.take(MOST_BYTES + 1)
        .read_to_string(&mut text)
        .map_err(cannot)?;
    if text.len() as u64 > MOST_BYTES {
        let reason = format!("expected at most {MOST_BYTES} bytes, got a longer file");
        return Err(TwistError::Read(reason));
    }
    parse(&text)
}

fn parse(text: &str) -> Result<Vec<TwistLine>, TwistError> {
    let mut reader = TwistReader::default();
    let mut lines = Vec::new();
    for line in text.lines() {
        lines.extend(reader.line(line)?);
    }
    let start_s = lines.first().ok_or(TwistError::Empty)?.time_s;
    for line in &mut lines {
        line.time_s -= start_s;
    }
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_numbers_behind_a_line_of_names() {
        let lines =
            parse("time,v,omega\n# slowly\n10,0.1,0\n10.5; 0.2; -0.3  # a curve\n\n").unwrap();
        let values: Vec<(f64, f64, f64)> = lines
            .iter()
            .map(|line| (line.time_s, line.twist.v_m_s(), line.twist.omega_rad_s()))
            .collect();
        assert_eq!(values, [(0.0, 0.1, 0.0), (0.5, 0.2, -0.3)]);
    }

    #[test]
    fn wrong_lines_say_where_and_what() {
        for (text, message) in [
            ("", "there is no line"),
            ("0,1", "line 1: expected the 3 columns time,v,omega, got 2"),
            ("0,1,2,3", "got 4"),
            (
                "0,0,0\n1,a,0",
                "line 2, column 2: expected a number (v in m/s), got \"a\"",
            ),
            (
                "0,0,0\n\n1,0,nan",
                "line 3: omega in rad/s must be -1000..=1000, got NaN",
            ),
            ("0,101,0", "line 1: v in m/s must be -100..=100, got 101"),
            (
                "1,0,0\n1,0,0",
                "line 2: the time must be above that of the line before, 1 s, got 1 s",
            ),
            ("nan,0,0", "line 1: the time must be above"),
            ("0,0,0\ntime,v,omega", "line 2, column 1"),
        ] {
            let error = parse(text).expect_err(text).to_string();
            assert!(error.contains(message), "{text:?}: {error}");
        }
    }
}
