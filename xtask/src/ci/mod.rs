//! `cargo xtask ci`: every check of the project, by the names of the steps.

mod interop;
mod need;
mod oldest_rust;
mod packages;
mod place;
mod published;
mod python_package;
mod recipes;
mod report;
mod report_page;
mod runner;
mod seeded_mistakes;
mod step;
mod steps;
mod tests_of_host;

use std::env;

use clap::builder::{PossibleValue, PossibleValuesParser};

use self::packages::Packages;
use self::place::Place;
use self::runner::Runner;
use self::step::Step;
use self::steps::STEPS;
use crate::error::Error;

/// Runs every check of the project, or the steps that are named, in the order of the list.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask ci                             all steps, up to the first failure\n  \
    cargo xtask ci lint test                   two of them\n  \
    cargo xtask ci --list                      names and purposes of the steps\n  \
    cargo xtask ci --keep-going                all steps, whatever fails\n  \
    cargo xtask ci --install-packages firmware with the packages of Debian that the step needs, as root\n\n\
    A step whose programs are missing is not run; the last lines say so, with what to install. The exit code is 0 when no\n\
    step failed.")]
pub(crate) struct Arguments {
    /// The steps to run
    #[arg(value_name = "STEP", value_parser = step_parser())]
    steps: Vec<String>,

    /// Print the names and purposes of the steps and do nothing
    #[arg(long)]
    list: bool,

    /// Go on after a failure
    #[arg(long)]
    keep_going: bool,

    /// Install packages that a step needs, with apt-get as root; `CI=true` in the environment means the same
    #[arg(long)]
    install_packages: bool,
}

/// Runs the task.
///
/// # Errors
/// When a step failed, with the names of those that did.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    let steps = chosen(&arguments.steps);
    if arguments.list {
        for step in steps {
            println!("{:<18} {}", step.name, step.purpose);
        }
        return Ok(());
    }
    let install = arguments.install_packages || env::var("CI").is_ok_and(|value| value == "true");
    let mut runner = Runner::new(
        Place::find(install)?,
        Packages::new(install),
        arguments.keep_going,
    );
    let report = runner.run(&steps);
    println!("\n=== all steps\n{report}");
    match report.failed() {
        none if none.is_empty() => Ok(()),
        failed => Err(Error::Checks { failed }),
    }
}

/// The steps with these names in the order of the table; all of them when there is no name.
fn chosen(names: &[String]) -> Vec<&'static Step> {
    let is_chosen = |step: &&Step| names.is_empty() || names.iter().any(|name| name == step.name);
    STEPS.iter().filter(is_chosen).collect()
}

fn step_parser() -> PossibleValuesParser {
    PossibleValuesParser::new(
        STEPS
            .iter()
            .map(|step| PossibleValue::new(step.name).help(step.purpose)),
    )
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;

    #[derive(Parser)]
    struct CommandLine {
        #[command(flatten)]
        arguments: Arguments,
    }

    fn names(words: &[&str]) -> Vec<&'static str> {
        let parsed = CommandLine::try_parse_from(words).unwrap();
        let steps = chosen(&parsed.arguments.steps);
        steps.iter().map(|step| step.name).collect()
    }

    #[test]
    fn named_steps_run_in_the_order_of_the_table() {
        assert_eq!(names(&["ci", "test", "format"]), ["format", "test"]);
        assert_eq!(names(&["ci"]).len(), STEPS.len());
    }

    #[test]
    fn an_unknown_step_is_refused_with_the_names() {
        let refused = CommandLine::try_parse_from(["ci", "tests"]).map(|_| ());
        let message = refused.unwrap_err().to_string();
        assert!(
            message.contains("'tests'") && message.contains("socketcan"),
            "{message}"
        );
    }
}
