//! `cargo xtask mutants`: seeds small mistakes into a part of a crate and counts those that its tests find.
//!
//! cargo-mutants makes the mistakes and runs the tests. This task remembers over runs what was tested, as long as the file in which the
//! mistake was made is the same, stops in time, and sums up. A mistake that changes nothing is left out by `exclude_re` in
//! `.cargo/mutants.toml`, with the reason.

mod arguments;
mod ledger;
mod seeding;
mod summary;

use std::time::Duration;

pub(crate) use self::arguments::Arguments;
use self::ledger::Ledger;
use self::seeding::{Seeding, sources};
use self::summary::Summary;
use crate::error::Error;
use crate::workspace::Workspace;

const SECONDS_A_MINUTE: u64 = 60;

/// Runs the task.
///
/// # Errors
/// When cargo-mutants is missing or fails, the tests fail without a mistake, or too few mistakes are found.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    let summary = test(&Workspace::find()?, arguments)?;
    print!("{summary}");
    if summary.is_enough(arguments.at_least) {
        return Ok(());
    }
    Err(Error::Survivors {
        found_percent: summary.found_percent(),
        at_least_percent: arguments.at_least,
    })
}

/// Tests what is left to test; the result is what is known afterwards of the mistakes that were asked for.
pub(crate) fn test(workspace: &Workspace, arguments: &Arguments) -> Result<Summary, Error> {
    let folder = workspace.target.join("mutants").join(&arguments.package);
    let seeding = Seeding::new(workspace, arguments, folder.clone())?;
    let all = seeding.list()?;
    let mut ledger = Ledger::open(folder, &sources(&workspace.root, &all))?;
    if arguments.again {
        ledger.forget_survivors();
    }
    let left = all.iter().filter(|mutant| !ledger.knows(mutant)).count();
    println!("{} mistakes, {left} of them not tested yet", all.len());
    if left > 0 {
        let limit = arguments
            .minutes
            .map(|minutes| Duration::from_secs(minutes * SECONDS_A_MINUTE));
        seeding.test(&mut ledger, limit)?;
    }
    Ok(Summary::of(&ledger, &all))
}
