//! Runs cargo-mutants.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use super::arguments::Arguments;
use super::ledger::{Ledger, failed, source_of, write};
use crate::error::Error;
use crate::workspace::{Workspace, cargo};

const PROGRAM: &str = "cargo mutants";
/// The folder in which cargo-mutants leaves its results.
const RESULTS: &str = "mutants.out";
/// Its exit codes for a run that tested what it should: all caught, some missed, some timed out.
const TESTED: [i32; 3] = [0, 2, 3];
const POLL: Duration = Duration::from_millis(200);

/// What is to be seeded where.
pub(super) struct Seeding<'a> {
    root: PathBuf,
    /// For results and differences.
    folder: PathBuf,
    arguments: &'a Arguments,
    /// The files, from the root.
    glob: String,
    /// The file with the differences to which it is limited.
    diff: Option<PathBuf>,
}

impl<'a> Seeding<'a> {
    /// Looks up the package, and the differences where only those are asked for.
    ///
    /// # Errors
    /// When the package is unknown or git does not know the revision.
    pub(super) fn new(
        workspace: &Workspace,
        arguments: &'a Arguments,
        folder: PathBuf,
    ) -> Result<Self, Error> {
        let package = folder_of(workspace, &arguments.package)?;
        fs::create_dir_all(&folder).map_err(|reason| failed(&folder, &reason))?;
        let diff = match &arguments.in_diff {
            Some(revision) => Some(difference(&workspace.root, &folder, &package, revision)?),
            None => None,
        };
        Ok(Self {
            root: workspace.root.clone(),
            glob: format!("{}/{}", package.display(), arguments.path),
            folder,
            arguments,
            diff,
        })
    }

    /// The names of all mistakes.
    ///
    /// # Errors
    /// When cargo-mutants is missing or fails.
    pub(super) fn list(&self) -> Result<Vec<String>, Error> {
        if self.is_without_difference()? {
            return Ok(Vec::new());
        }
        let output = self.command().arg("--list").output().map_err(not_started)?;
        if !output.status.success() {
            eprint!("{}", String::from_utf8_lossy(&output.stderr));
            return Err(Error::MutantsMissing {
                status: output.status,
            });
        }
        let text = String::from_utf8_lossy(&output.stdout);
        Ok(text.lines().map(str::to_owned).collect())
    }

    /// Tests what the ledger does not know, at most so long.
    ///
    /// # Errors
    /// When the tests fail without a mistake, or cargo-mutants fails.
    pub(super) fn test(&self, ledger: &mut Ledger, limit: Option<Duration>) -> Result<(), Error> {
        let results = self.folder.join(RESULTS);
        // It skips what the last run in this folder caught: everything that the ledger knows, whatever came of it.
        let _ = fs::remove_dir_all(&results);
        fs::create_dir_all(&results).map_err(|reason| failed(&results, &reason))?;
        let tested: String = ledger.tested().map(|name| format!("{name}\n")).collect();
        write(&results.join("caught.txt"), &tested)?;
        let mut command = self.command();
        command.args(["--iterate", "--shuffle", "--colors=never"]);
        command.arg("--output").arg(&self.folder);
        if !self.arguments.tests.is_empty() {
            command.arg("--").args(&self.arguments.tests);
        }
        let child = command.stdin(Stdio::null()).spawn().map_err(not_started)?;
        let is_stopped = wait(child, limit)?;
        ledger.take_in(&results)?;
        if is_stopped {
            println!("stopped after the time it was given; the next run goes on from here");
        }
        Ok(())
    }

    fn command(&self) -> Command {
        let mut command = Command::new(cargo());
        command
            .current_dir(&self.root)
            .env_remove("CARGO_MANIFEST_DIR")
            // It would print one for each interruption.
            .env_remove("RUST_BACKTRACE")
            .args(["mutants", "--package", &self.arguments.package])
            .args(["--file", &self.glob]);
        if let Some(shard) = &self.arguments.shard {
            command.args(["--shard", shard]);
        }
        if let Some(diff) = &self.diff {
            command.arg("--in-diff").arg(diff);
        }
        command
    }

    fn is_without_difference(&self) -> Result<bool, Error> {
        let Some(diff) = &self.diff else {
            return Ok(false);
        };
        let length = fs::metadata(diff).map_err(|reason| failed(diff, &reason))?;
        Ok(length.len() == 0)
    }
}

/// The text of each source in which there are mistakes.
pub(super) fn sources(root: &Path, mutants: &[String]) -> BTreeMap<String, Vec<u8>> {
    mutants
        .iter()
        .map(|name| source_of(name))
        .filter_map(|source| Some((source.to_owned(), fs::read(root.join(source)).ok()?)))
        .collect()
}

/// Writes what differs in a package from a revision to a file.
fn difference(
    root: &Path,
    folder: &Path,
    package: &Path,
    revision: &str,
) -> Result<PathBuf, Error> {
    let program = format!("git diff {revision}");
    let output = Command::new("git")
        .current_dir(root)
        .args(["diff", "--no-color", "--no-ext-diff", revision, "--"])
        .arg(package)
        .output()
        .map_err(|reason| Error::Start {
            program: program.clone(),
            reason,
        })?;
    if !output.status.success() {
        eprint!("{}", String::from_utf8_lossy(&output.stderr));
        return Err(Error::Failed {
            program,
            status: output.status,
        });
    }
    let file = folder.join("difference.diff");
    write(&file, &String::from_utf8_lossy(&output.stdout))?;
    Ok(file)
}

/// The folder of a package, relative to the root.
fn folder_of(workspace: &Workspace, package: &str) -> Result<PathBuf, Error> {
    let folder = &workspace.package(package)?.folder;
    let relative = folder.strip_prefix(&workspace.root);
    Ok(relative.unwrap_or(folder).to_path_buf())
}

/// Waits for the end, or asks for it when the time is over; the result is whether it was asked.
fn wait(mut child: Child, limit: Option<Duration>) -> Result<bool, Error> {
    let started = Instant::now();
    let mut is_stopped = false;
    loop {
        if let Some(status) = child.try_wait().map_err(not_started)? {
            let is_tested = status.code().is_some_and(|code| TESTED.contains(&code));
            return if is_tested || is_stopped {
                Ok(is_stopped)
            } else {
                Err(Error::Failed {
                    program: PROGRAM.into(),
                    status,
                })
            };
        }
        if !is_stopped && limit.is_some_and(|limit| started.elapsed() >= limit) {
            is_stopped = true;
            interrupt(&child)?;
        }
        sleep(POLL);
    }
}

/// As Ctrl-C: it ends the tests that run and removes its copy of the sources.
fn interrupt(child: &Child) -> Result<(), Error> {
    let id = child.id().to_string();
    let status = Command::new("kill").args(["-INT", &id]).status();
    status.map(|_| ()).map_err(|reason| Error::Start {
        program: "kill".into(),
        reason,
    })
}

fn not_started(reason: std::io::Error) -> Error {
    Error::Start {
        program: PROGRAM.into(),
        reason,
    }
}
