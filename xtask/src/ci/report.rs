//! What came of the steps, and how it is told at the end.

use std::fmt;
use std::time::Duration;

/// How a step ended.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Outcome {
    /// All of it was checked.
    Passed,
    /// What was checked is right; these parts could not be checked, with the reasons.
    PassedInPart(Vec<String>),
    /// It could not run, with what to do about it.
    NotRun(String),
    /// It was not reached.
    NotReached,
    /// Something is wrong; the reason.
    Failed(String),
}

/// A step that is over.
pub(super) struct Record {
    pub(super) step: &'static str,
    pub(super) outcome: Outcome,
    pub(super) took: Duration,
}

/// All steps that were asked for.
#[derive(Default)]
pub(super) struct Report {
    pub(super) records: Vec<Record>,
}

impl Report {
    /// The steps that failed.
    pub(super) fn failed(&self) -> Vec<&'static str> {
        let failed = self
            .records
            .iter()
            .filter(|record| matches!(record.outcome, Outcome::Failed(_)));
        failed.map(|record| record.step).collect()
    }

    fn count(&self, is: fn(&Outcome) -> bool) -> usize {
        self.records
            .iter()
            .filter(|record| is(&record.outcome))
            .count()
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for record in &self.records {
            let took = Seconds(record.took);
            writeln!(
                f,
                "{:<18} {:<12} {took:>9}",
                record.step,
                record.outcome.word()
            )?;
        }
        let unchecked: Vec<String> = self.records.iter().flat_map(Record::unchecked).collect();
        if !unchecked.is_empty() {
            writeln!(f, "\nSkipped or not run:")?;
            for line in unchecked {
                writeln!(f, "  {line}")?;
            }
        }
        let passed =
            self.count(|outcome| matches!(outcome, Outcome::Passed | Outcome::PassedInPart(_)));
        let failed = self.failed();
        let not_run =
            self.count(|outcome| matches!(outcome, Outcome::NotRun(_) | Outcome::NotReached));
        let took = Seconds(self.records.iter().map(|record| record.took).sum());
        write!(
            f,
            "\n=== {passed} passed, {} failed, {not_run} not run, in {took}",
            failed.len()
        )?;
        if !failed.is_empty() {
            write!(f, "; failed: {}", failed.join(", "))?;
        }
        Ok(())
    }
}

impl Record {
    /// One line for each thing that was not checked.
    fn unchecked(&self) -> Vec<String> {
        let line = |reason: &str| format!("{}: {reason}", self.step);
        match &self.outcome {
            Outcome::Passed | Outcome::Failed(_) => Vec::new(),
            Outcome::PassedInPart(parts) => parts.iter().map(|part| line(part)).collect(),
            Outcome::NotRun(reason) => vec![line(reason)],
            Outcome::NotReached => vec![line(
                "an earlier step failed; `--keep-going` runs it all the same",
            )],
        }
    }
}

impl Outcome {
    pub(super) fn word(&self) -> &'static str {
        match self {
            Self::Passed => "passed",
            Self::PassedInPart(_) => "in part",
            Self::NotRun(_) => "not run",
            Self::NotReached => "not reached",
            Self::Failed(_) => "FAILED",
        }
    }
}

/// A duration in seconds, and in minutes where it is long.
pub(super) struct Seconds(pub(super) Duration);

impl fmt::Display for Seconds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = self.0.as_secs();
        if seconds < 100 {
            return f.pad(&format!("{:.1} s", self.0.as_secs_f64()));
        }
        f.pad(&format!("{} min {:02} s", seconds / 60, seconds % 60))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(step: &'static str, outcome: Outcome, ms: u64) -> Record {
        Record {
            step,
            outcome,
            took: Duration::from_millis(ms),
        }
    }

    #[test]
    fn what_was_not_checked_is_in_one_list_with_its_reason() {
        let report = Report {
            records: vec![
                record("test", Outcome::Passed, 90_250),
                record("logs", Outcome::PassedInPart(vec!["no clock".into()]), 50),
                record("bus", Outcome::NotRun("there is no bus".into()), 0),
                record("docs", Outcome::Failed("broken".into()), 30_000),
                record("page", Outcome::NotReached, 0),
            ],
        };
        assert_eq!(
            report.to_string(),
            "\
test               passed          90.2 s
logs               in part          0.1 s
bus                not run          0.0 s
docs               FAILED          30.0 s
page               not reached      0.0 s

Skipped or not run:
  logs: no clock
  bus: there is no bus
  page: an earlier step failed; `--keep-going` runs it all the same

=== 2 passed, 1 failed, 2 not run, in 2 min 00 s; failed: docs"
        );
    }

    #[test]
    fn a_run_without_gaps_has_no_list() {
        let report = Report {
            records: vec![record("test", Outcome::Passed, 1_000)],
        };
        assert_eq!(
            report.to_string(),
            "test               passed           1.0 s\n\n=== 1 passed, 0 failed, 0 not run, in 1.0 s"
        );
    }
}
