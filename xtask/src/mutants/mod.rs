//! `cargo xtask mutants`: seeds small mistakes into a part of a crate and counts those that its tests find.
//!
//! cargo-mutants makes the mistakes and runs the tests. This task remembers over runs what was tested, as long as the file in which the
//! mistake was made is the same, stops in time, and sums up.

mod ledger;
mod seeding;
mod summary;

use std::path::PathBuf;
use std::time::Duration;

use self::ledger::Ledger;
use self::seeding::{Seeding, sources};
use self::summary::Summary;
use crate::error::Error;
use crate::workspace::Workspace;

const SECONDS_A_MINUTE: u64 = 60;

/// Seeds small mistakes into a part of a crate and counts those that its tests find; goes on where the last run stopped.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask mutants --package can-motion --path 'src/core/**'                      all that is left\n  \
    cargo xtask mutants --package can-motion --path 'src/core/**' --minutes 60         one hour of it\n  \
    cargo xtask mutants --package can-motion --path 'src/core/**' --shard 0/4          a quarter of it\n  \
    cargo xtask mutants --package can-motion --path 'src/core/**' --in-diff main       only what changed since main\n  \
    cargo xtask mutants --package can-motion --path 'src/core/**' -- --lib core        with these tests\n\n\
    Results are kept in target/mutants; those of a source file are dropped when the file changes. --again tests survivors\n\
    anew, after a test was added. Needs `cargo install cargo-mutants --locked`.")]
pub(crate) struct Arguments {
    /// The package
    #[arg(long, value_name = "PACKAGE")]
    pub(crate) package: String,

    /// The files to change, a glob below the folder of the package
    #[arg(long, value_name = "GLOB", default_value = "src/**")]
    pub(crate) path: String,

    /// Only part k of n, counted from 0
    #[arg(long, value_name = "K/N")]
    pub(crate) shard: Option<String>,

    /// Only lines that differ from this revision
    #[arg(long, value_name = "REVISION")]
    pub(crate) in_diff: Option<String>,

    /// Stop after so many minutes; the next run goes on
    #[arg(long, value_name = "MINUTES")]
    pub(crate) minutes: Option<u64>,

    /// Percentage that must be found
    #[arg(long, value_name = "PERCENT", default_value_t = 95, value_parser = clap::value_parser!(u8).range(0..=100))]
    pub(crate) at_least: u8,

    /// Test survivors of earlier runs anew
    #[arg(long)]
    pub(crate) again: bool,

    /// Further arguments for `cargo test`
    #[arg(last = true, value_name = "TEST ARGUMENTS")]
    pub(crate) tests: Vec<String>,
}

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

/// The folder of a package, relative to the root.
fn folder_of(workspace: &Workspace, package: &str) -> Result<PathBuf, Error> {
    let folder = &workspace.package(package)?.folder;
    let relative = folder.strip_prefix(&workspace.root);
    Ok(relative.unwrap_or(folder).to_path_buf())
}
