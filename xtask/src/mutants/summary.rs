//! How many mistakes were found.

use std::fmt;

use super::ledger::{Ledger, Outcome};

/// What is known of the mistakes that were asked for.
pub(crate) struct Summary {
    all: usize,
    caught: usize,
    timeouts: usize,
    unviable: usize,
    survivors: Vec<String>,
}

impl Summary {
    pub(super) fn of(ledger: &Ledger, all: &[String]) -> Self {
        let count = |outcome| {
            let of_this = all
                .iter()
                .filter(|name| ledger.outcome(name) == Some(outcome));
            of_this.count()
        };
        let survivors = all
            .iter()
            .filter(|name| ledger.outcome(name) == Some(Outcome::Missed));
        Self {
            all: all.len(),
            caught: count(Outcome::Caught),
            timeouts: count(Outcome::Timeout),
            unviable: count(Outcome::Unviable),
            survivors: survivors.cloned().collect(),
        }
    }

    /// Mistakes that compile and were tested.
    fn tested(&self) -> usize {
        self.caught + self.timeouts + self.survivors.len()
    }

    /// The share of the tested mistakes that were found, rounded down; tests that no longer end have found one.
    pub(crate) fn found_percent(&self) -> usize {
        let found = self.caught + self.timeouts;
        (found * 100).checked_div(self.tested()).unwrap_or(100)
    }

    /// Whether so many were found.
    pub(crate) fn is_enough(&self, percent: u8) -> bool {
        (self.caught + self.timeouts) * 100 >= self.tested() * usize::from(percent)
    }

    /// Mistakes that no test found.
    pub(crate) fn survivors(&self) -> usize {
        self.survivors.len()
    }

    /// What is left to test.
    pub(crate) fn untested(&self) -> usize {
        self.all - self.tested() - self.unviable
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for survivor in &self.survivors {
            writeln!(f, "SURVIVED {survivor}")?;
        }
        write!(
            f,
            "{} mistakes: {} found by a failed test, {} by tests that did not end, {} survived, {} do not compile, {} not tested yet",
            self.all,
            self.caught,
            self.timeouts,
            self.survivors.len(),
            self.unviable,
            self.untested(),
        )?;
        if self.tested() > 0 {
            write!(f, "; {} % of those tested were found", self.found_percent())?;
        }
        writeln!(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(caught: usize, survivors: usize) -> Summary {
        Summary {
            all: 100,
            caught,
            timeouts: 1,
            unviable: 2,
            survivors: vec!["src/a.rs:1:1: replace + with -".into(); survivors],
        }
    }

    #[test]
    fn the_share_is_that_of_the_tested_and_is_not_rounded_up() {
        // 19 of 20, and 37 of 39 are less than 95 %.
        assert!(summary(18, 1).is_enough(95));
        assert_eq!(summary(18, 1).found_percent(), 95);
        assert!(!summary(36, 2).is_enough(95));
        assert_eq!(summary(36, 2).found_percent(), 94);
        assert_eq!(summary(18, 1).untested(), 78);
    }

    #[test]
    fn nothing_to_test_is_enough() {
        let none = Summary {
            all: 0,
            caught: 0,
            timeouts: 0,
            unviable: 0,
            survivors: Vec::new(),
        };
        assert!(none.is_enough(95));
        assert_eq!(none.found_percent(), 100);
    }

    #[test]
    fn a_run_without_a_result_claims_no_share() {
        let untested = Summary {
            all: 3,
            ..summary(0, 0)
        };
        let nothing = Summary {
            timeouts: 0,
            unviable: 0,
            ..untested
        };
        assert!(nothing.to_string().ends_with("3 not tested yet\n"));
    }

    #[test]
    fn survivors_are_named() {
        let text = summary(18, 1).to_string();
        assert!(text.starts_with("SURVIVED src/a.rs:1:1: replace + with -\n"));
        assert!(text.contains("1 survived, 2 do not compile, 78 not tested yet; 95 %"));
    }
}
