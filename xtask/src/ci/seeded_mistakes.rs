//! Mistakes seeded into the lines of the core that the last change touched.
//!
//! In five minutes this is a sample: survivors are told, and only `cargo xtask mutants` over all of them is a verdict.

use std::path::Path;
use std::process::Command;
use std::time::Instant;

use super::place::Place;
use crate::error::Error;
use crate::mutants::{self, Arguments};
use crate::workspace::cargo;

const PACKAGE: &str = "can-motion";
const GLOB: &str = "src/core/**";
const FOLDER: &str = "crates/can-motion/src/core";
/// What the last change is compared with: everything that a merge brought is one change.
const BEFORE: &str = "HEAD^1";
/// The time for all of it, the installation of cargo-mutants included; what is left is said.
const MINUTES: u64 = 5;
const INSTALL: &str = "install cargo-mutants --locked --debug";

/// Seeds the mistakes and runs the tests of the package on each.
///
/// # Errors
/// When the tests fail without a mistake, or cargo-mutants does.
pub(super) fn run(place: &Place) -> Result<Vec<String>, Error> {
    let started = Instant::now();
    if !place.root().join(FOLDER).is_dir() {
        return Ok(vec![format!("there is no {FOLDER} yet")]);
    }
    match has_changed(place) {
        None => {
            return Ok(vec![format!(
                "git does not know {BEFORE}: clone with its history"
            )]);
        }
        Some(false) => {
            println!("nothing in {FOLDER} differs from {BEFORE}");
            return Ok(Vec::new());
        }
        Some(true) => {}
    }
    if !is_installed(place) {
        if !place.may_install() {
            return Ok(vec![format!("there is no cargo-mutants: cargo {INSTALL}")]);
        }
        place.cargo(INSTALL)?;
    }
    let minutes = MINUTES.saturating_sub(started.elapsed().as_secs() / 60);
    let summary = mutants::test(place.workspace(), &arguments(minutes))?;
    print!("{summary}");
    let mut unchecked = Vec::new();
    if summary.survivors() > 0 {
        unchecked.push(format!(
            "{} mistakes survived, see the step",
            summary.survivors()
        ));
    }
    if summary.untested() > 0 {
        unchecked.push(format!(
            "{} mistakes were not tested within {MINUTES} minutes: cargo xtask mutants --package {PACKAGE} --path '{GLOB}'",
            summary.untested()
        ));
    }
    Ok(unchecked)
}

fn arguments(minutes: u64) -> Arguments {
    Arguments {
        package: PACKAGE.into(),
        path: GLOB.into(),
        shard: None,
        in_diff: Some(BEFORE.into()),
        minutes: Some(minutes),
        at_least: 0,
        again: false,
        tests: Vec::new(),
    }
}

/// Whether the folder differs; `None` when there is nothing to compare with.
fn has_changed(place: &Place) -> Option<bool> {
    let mut git = place.command("git");
    git.args(["diff", "--quiet", BEFORE, "--"])
        .arg(Path::new(FOLDER));
    match git.status().ok()?.code()? {
        0 => Some(false),
        1 => Some(true),
        _ => None,
    }
}

fn is_installed(place: &Place) -> bool {
    let mut version: Command = place.command(cargo());
    let output = version.args(["mutants", "--version"]).output();
    output.is_ok_and(|output| output.status.success())
}
