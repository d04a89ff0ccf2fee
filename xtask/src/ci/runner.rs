//! Runs steps one after another.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use super::need::Need;
use super::packages::Packages;
use super::place::Place;
use super::report::{Outcome, Record, Report, Seconds};
use super::step::{Action, Step};
use crate::error::Error;
use crate::thumb::TARGET;
use crate::toolchain::{Preference, Toolchain};

/// What the steps share.
pub(super) struct Runner {
    place: Place,
    packages: Packages,
    keep_going: bool,
    /// What was found lacking, by the name of the need: looking for it may take a minute.
    lacks: BTreeMap<&'static str, Option<String>>,
}

impl Runner {
    pub(super) fn new(place: Place, packages: Packages, keep_going: bool) -> Self {
        Self {
            place,
            packages,
            keep_going,
            lacks: BTreeMap::new(),
        }
    }

    /// Runs the steps up to the first failure, or all of them.
    pub(super) fn run(&mut self, steps: &[&'static Step]) -> Report {
        let mut report = Report::default();
        let mut stopped = false;
        for step in steps {
            let record = if stopped {
                not_reached(step)
            } else {
                self.step(step)
            };
            stopped |= !self.keep_going && matches!(record.outcome, Outcome::Failed(_));
            report.records.push(record);
        }
        report
    }

    fn step(&mut self, step: &'static Step) -> Record {
        println!("\n=== {}: {}", step.name, step.purpose);
        let started = Instant::now();
        let outcome = match self.first_lack(step.needs) {
            Some(lack) => Outcome::NotRun(lack),
            None => outcome_of(self.act(&step.action)),
        };
        let took = started.elapsed();
        if let Outcome::NotRun(reason) | Outcome::Failed(reason) = &outcome {
            println!("{reason}");
        }
        println!("--- {}: {} in {}", step.name, outcome.word(), Seconds(took));
        Record {
            step: step.name,
            outcome,
            took,
        }
    }

    /// The first thing that the machine lacks, and what to do about it.
    fn first_lack(&mut self, needs: &[&'static Need]) -> Option<String> {
        needs.iter().find_map(|need| self.lack(need))
    }

    fn lack(&mut self, need: &'static Need) -> Option<String> {
        if let Some(known) = self.lacks.get(need.name) {
            return known.clone();
        }
        let lack = self.still_lacking(need);
        self.lacks.insert(need.name, lack.clone());
        lack
    }

    /// Looks for it, installs it if that is allowed, and looks again.
    fn still_lacking(&mut self, need: &Need) -> Option<String> {
        (need.lacking)()?;
        let result = self.packages.install(need.packages);
        let lacking = (need.lacking)()?;
        let installed = match result {
            Ok(()) => "its packages are installed".into(),
            Err(reason) => reason,
        };
        Some(format!("{lacking} ({installed}); {}", need.remedy()))
    }

    fn act(&self, action: &Action) -> Result<Vec<String>, Error> {
        match action {
            Action::Cargo(lines) => {
                lines.iter().try_for_each(|line| self.place.cargo(line))?;
                Ok(Vec::new())
            }
            Action::ForBoards(lines) => {
                let toolchain = board_toolchain()?;
                for line in *lines {
                    self.place
                        .cargo(&format!("xtask {line} --toolchain {toolchain}"))?;
                }
                Ok(Vec::new())
            }
            Action::Call(function) => function(&self.place),
        }
    }
}

/// The toolchain for the boards as an option of this program names it, so that not every line looks for it again.
fn board_toolchain() -> Result<&'static str, Error> {
    Toolchain::find(&TARGET, Preference::Auto).map(|toolchain| toolchain.option())
}

fn outcome_of(result: Result<Vec<String>, Error>) -> Outcome {
    match result {
        Ok(skipped) if skipped.is_empty() => Outcome::Passed,
        Ok(skipped) => Outcome::PassedInPart(skipped),
        Err(error) => Outcome::Failed(error.to_string()),
    }
}

fn not_reached(step: &Step) -> Record {
    Record {
        step: step.name,
        outcome: Outcome::NotReached,
        took: Duration::ZERO,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAILS: Step = Step::call("fails", "it fails", |_| {
        Err(Error::Answer {
            program: "a program".into(),
            expected: "an answer",
        })
    });
    const PASSES: Step = Step::call("passes", "it passes", |_| Ok(Vec::new()));
    const IN_PART: Step = Step::call("in-part", "it skips", |_| Ok(vec!["no bus".into()]));
    const NOTHING_LIKE_IT: Need = Need {
        name: "nothing like it",
        lacking: || Some("there is nothing like it".into()),
        packages: &["no-such-package"],
        otherwise: None,
    };
    const NEEDY: Step =
        Step::call("needy", "it cannot run", |_| Ok(Vec::new())).needs(&[&NOTHING_LIKE_IT]);
    const FAILS_ON_THE_WAY: Step = Step::cargo(
        "cargo",
        "cargo fails",
        &["--version", "no-such-subcommand", "--version"],
    );

    fn outcomes(keep_going: bool, steps: &[&'static Step]) -> Vec<Outcome> {
        let place = Place::find(false).unwrap();
        let mut runner = Runner::new(place, Packages::new(false), keep_going);
        let report = runner.run(steps);
        report
            .records
            .into_iter()
            .map(|record| record.outcome)
            .collect()
    }

    #[test]
    fn the_first_failure_ends_it() {
        let failed = Outcome::Failed("a program did not print an answer".into());
        let steps: [&'static Step; 3] = [&PASSES, &FAILS, &PASSES];
        assert_eq!(
            outcomes(false, &steps),
            [Outcome::Passed, failed, Outcome::NotReached]
        );
    }

    #[test]
    fn a_failure_does_not_end_it_when_told_to_keep_going() {
        let failed = Outcome::Failed("a program did not print an answer".into());
        let steps: [&'static Step; 2] = [&FAILS, &PASSES];
        assert_eq!(outcomes(true, &steps), [failed, Outcome::Passed]);
    }

    #[test]
    fn what_a_machine_lacks_and_what_a_step_skips_is_told() {
        let lacking = Outcome::NotRun(
            "there is nothing like it (nothing was installed); \
             apt-get install no-such-package (Debian, as root; `--install-packages` does it)"
                .into(),
        );
        let steps: [&'static Step; 2] = [&NEEDY, &IN_PART];
        assert_eq!(
            outcomes(false, &steps),
            [lacking, Outcome::PassedInPart(vec!["no bus".into()])]
        );
    }

    #[test]
    fn a_line_that_fails_fails_the_step() {
        let steps: [&'static Step; 1] = [&FAILS_ON_THE_WAY];
        let outcomes = outcomes(false, &steps);
        assert!(
            matches!(&outcomes[..], [Outcome::Failed(reason)] if reason.contains("no-such-subcommand")),
            "{outcomes:?}"
        );
    }
}
