//! The figures of the table in a file, and what has risen since.

use std::collections::BTreeMap;
use std::fmt;
use std::fs;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::figure::Figure;
use crate::error::Error;

/// A figure may rise by this share, in percent.
const TOLERANCE_PERCENT: f64 = 3.0;

/// The figures by their names, and the compiler that they belong to.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Baseline {
    /// Version of the compiler, and where the target's core library came from.
    pub(crate) compiler: String,
    /// Each figure.
    pub(crate) figures: BTreeMap<String, f64>,
}

impl Baseline {
    /// The baseline of these figures.
    pub(crate) fn new<'a>(compiler: String, figures: impl IntoIterator<Item = &'a Figure>) -> Self {
        let figures = figures.into_iter();
        Self {
            compiler,
            figures: figures
                .map(|figure| (figure.name.clone(), figure.value))
                .collect(),
        }
    }

    /// Reads the file.
    ///
    /// # Errors
    /// When it is missing or damaged, with what to do.
    pub(crate) fn read(path: &Path) -> Result<Self, Error> {
        let wrong = |reason: String| Error::Image {
            path: path.into(),
            reason: format!("{reason}; `cargo xtask cost` writes it"),
        };
        let text = fs::read_to_string(path).map_err(|reason| wrong(reason.to_string()))?;
        serde_json::from_str(&text).map_err(|reason| wrong(reason.to_string()))
    }

    /// Writes the file, one figure a line.
    ///
    /// # Errors
    /// When it cannot be written.
    pub(crate) fn write(&self, path: &Path) -> Result<(), Error> {
        let text = serde_json::to_string_pretty(self).map_err(|reason| reason.to_string());
        let written =
            text.and_then(|text| fs::write(path, text + "\n").map_err(|reason| reason.to_string()));
        written.map_err(|reason| Error::Image {
            path: path.into(),
            reason,
        })
    }

    /// What is different in figures of the same compiler.
    pub(crate) fn compare<'a>(&self, figures: impl IntoIterator<Item = &'a Figure>) -> Changes {
        let mut changes = Changes::default();
        for figure in figures {
            changes.compared += 1;
            let change = |before| Change {
                name: figure.name.clone(),
                before,
                now: figure.value,
                command: figure.command.clone(),
            };
            let tolerated = 1.0 + TOLERANCE_PERCENT / 100.0;
            match self.figures.get(&figure.name) {
                None => changes.risen.push(change(None)),
                Some(&before) if figure.value > before * tolerated => {
                    changes.risen.push(change(Some(before)));
                }
                Some(&before) if figure.value * tolerated < before => {
                    changes.fallen.push(change(Some(before)));
                }
                Some(_) => {}
            }
        }
        changes
    }
}

/// Figures that differ by more than is tolerated.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Changes {
    /// How many were compared.
    pub(crate) compared: usize,
    /// Those that are larger, or new.
    pub(crate) risen: Vec<Change>,
    /// Those that are smaller.
    pub(crate) fallen: Vec<Change>,
}

/// A figure that differs.
#[derive(Debug, PartialEq)]
pub(crate) struct Change {
    name: String,
    before: Option<f64>,
    now: f64,
    command: String,
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            name, now, command, ..
        } = self;
        match self.before {
            None => write!(f, "{name}: {now}, and the baseline does not know it")?,
            Some(before) if before > 0.0 => {
                let percent = 100.0 * (now / before - 1.0);
                write!(f, "{name}: {before} before, now {now} ({percent:+.1} %)")?;
            }
            Some(before) => write!(f, "{name}: {before} before, now {now}")?,
        }
        write!(f, "    {command}")
    }
}

impl fmt::Display for Changes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (what, changes) in [("risen", &self.risen), ("fallen", &self.fallen)] {
            for change in changes {
                writeln!(f, "{what}  {change}")?;
            }
        }
        writeln!(
            f,
            "{} figures compared, tolerance {TOLERANCE_PERCENT} %: {} risen, {} fallen",
            self.compared,
            self.risen.len(),
            self.fallen.len()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(name: &str, value: f64) -> Figure {
        Figure::new(name, value, "cargo xtask cost")
    }

    #[test]
    fn more_than_three_percent_is_a_rise_and_less_is_none() {
        let before = [
            figure("a", 1_000.0),
            figure("b", 1_000.0),
            figure("c", 1_000.0),
        ];
        let baseline = Baseline::new("1.95".into(), &before);
        let now = [
            figure("a", 1_030.0),
            figure("b", 1_031.0),
            figure("c", 900.0),
            figure("d", 1.0),
        ];
        let changes = baseline.compare(&now);
        let names = |changes: &[Change]| -> Vec<String> {
            changes.iter().map(|change| change.name.clone()).collect()
        };
        assert_eq!(names(&changes.risen), ["b", "d"]);
        assert_eq!(names(&changes.fallen), ["c"]);
        let text = changes.to_string();
        assert!(
            text.contains("risen  b: 1000 before, now 1031 (+3.1 %)"),
            "{text}"
        );
        assert!(text.contains("4 figures compared"), "{text}");
    }

    #[test]
    fn something_that_was_nothing_is_a_rise() {
        let baseline = Baseline::new("1.95".into(), &[figure("a", 0.0)]);
        assert_eq!(baseline.compare(&[figure("a", 0.0)]).risen, []);
        assert_eq!(baseline.compare(&[figure("a", 0.1)]).risen.len(), 1);
    }

    #[test]
    fn what_was_written_is_read_back_and_a_missing_file_says_what_writes_it() {
        let path = std::env::temp_dir().join(format!("baseline-{}.json", std::process::id()));
        let baseline = Baseline::new("1.95".into(), &[figure("a", 16.0), figure("b", 0.5)]);
        baseline.write(&path).unwrap();
        let read = Baseline::read(&path);
        fs::remove_file(&path).unwrap();
        assert_eq!(read.unwrap(), baseline);
        let error = Baseline::read(&path).unwrap_err().to_string();
        assert!(error.contains("`cargo xtask cost` writes it"), "{error}");
    }
}
