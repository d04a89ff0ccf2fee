//! Where the steps run, and how they start programs.

use std::env;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use crate::error::Error;
use crate::output::print;
use crate::workspace::{Workspace, cargo};

/// A line of a script that begins with this is something that it could not check.
const SKIPPED: &str = "SKIPPED: ";
/// What `cargo run` tells this program about its package; a cargo started by a step must find it as the user's shell has it.
const OF_THIS_PACKAGE: [&str; 2] = ["CARGO_MANIFEST_", "CARGO_PKG_"];

/// The workspace as the steps see it.
pub(super) struct Place {
    workspace: Workspace,
    may_install: bool,
}

impl Place {
    /// The workspace around the current folder, and whether its steps may install what is missing.
    ///
    /// # Errors
    /// When cargo does not know.
    pub(super) fn find(may_install: bool) -> Result<Self, Error> {
        Ok(Self {
            workspace: Workspace::find()?,
            may_install,
        })
    }

    /// The workspace.
    pub(super) fn workspace(&self) -> &Workspace {
        &self.workspace
    }

    /// Its folder.
    pub(super) fn root(&self) -> &Path {
        &self.workspace.root
    }

    /// Whether the user asked to install what is missing.
    pub(super) fn may_install(&self) -> bool {
        self.may_install
    }

    /// The folder of build products.
    pub(super) fn target(&self) -> &Path {
        &self.workspace.target
    }

    /// A program in the root folder, with nothing to read.
    pub(super) fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new(program);
        command
            .current_dir(&self.workspace.root)
            .stdin(Stdio::null());
        for (name, _) in env::vars_os() {
            let text = name.to_string_lossy();
            if OF_THIS_PACKAGE.iter().any(|start| text.starts_with(start)) {
                command.env_remove(&name);
            }
        }
        command
    }

    /// Runs cargo with the words of a line, its output to the terminal.
    ///
    /// # Errors
    /// When it fails.
    pub(super) fn cargo(&self, line: &str) -> Result<(), Error> {
        self.cargo_with(line, &[])
    }

    /// The same with variables in its environment.
    ///
    /// # Errors
    /// When it fails.
    pub(super) fn cargo_with(&self, line: &str, environment: &[(&str, &str)]) -> Result<(), Error> {
        let program = format!("cargo {line}");
        print(format_args!("$ {program}\n"))?;
        let mut command = self.command(cargo());
        command.args(line.split(' '));
        command.envs(environment.iter().copied());
        ended(program, command.status())
    }

    /// Builds a program of the workspace fast enough for a bench in real time; the result is where it is.
    ///
    /// # Errors
    /// When it does not build.
    pub(super) fn tool(&self, package: &str, program: &str) -> Result<PathBuf, Error> {
        self.cargo(&format!(
            "build -q --profile tools -p {package} --bin {program}"
        ))?;
        Ok(self.target().join("tools").join(program))
    }

    /// Runs a script and shows what it prints; the result is what it says that it could not check.
    ///
    /// # Errors
    /// When it fails.
    pub(super) fn script(&self, command: &mut Command) -> Result<Vec<String>, Error> {
        let program = format!("{command:?}");
        let start = |reason| Error::Start {
            program: program.clone(),
            reason,
        };
        let mut child = command.stdout(Stdio::piped()).spawn().map_err(start)?;
        let mut skipped = Vec::new();
        if let Some(output) = child.stdout.take() {
            for line in BufReader::new(output).split(b'\n') {
                let line = line.map_err(start)?;
                let line = String::from_utf8_lossy(&line);
                println!("{line}");
                skipped.extend(line.strip_prefix(SKIPPED).map(str::to_owned));
            }
        }
        ended(program.clone(), child.wait())?;
        Ok(skipped)
    }

    /// Runs a program, its output to the terminal.
    ///
    /// # Errors
    /// When it fails.
    pub(super) fn run(&self, command: &mut Command) -> Result<(), Error> {
        let program = format!("{command:?}");
        let status = command.status();
        ended(program, status)
    }
}

fn ended(program: String, status: std::io::Result<ExitStatus>) -> Result<(), Error> {
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Error::Failed { program, status }),
        Err(reason) => Err(Error::Start { program, reason }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(place: &Place, script: &str) -> Command {
        let mut command = place.command("sh");
        command.args(["-c", script]);
        command
    }

    #[test]
    fn what_a_script_could_not_check_is_its_result() {
        let place = Place::find(false).unwrap();
        let mut script = shell(&place, "echo checked; echo 'SKIPPED: no bus'; echo more");
        assert_eq!(place.script(&mut script).unwrap(), ["no bus"]);
    }

    #[test]
    fn a_script_that_fails_is_an_error_whatever_it_skipped() {
        let place = Place::find(false).unwrap();
        let mut script = shell(&place, "echo 'SKIPPED: no bus'; exit 3");
        assert!(matches!(
            place.script(&mut script),
            Err(Error::Failed { .. })
        ));
    }

    #[test]
    fn a_program_finds_nothing_of_this_package_in_its_environment() {
        let place = Place::find(false).unwrap();
        let output = shell(&place, "env").output().unwrap();
        let environment = String::from_utf8_lossy(&output.stdout);
        assert!(!environment.contains("CARGO_MANIFEST_DIR="));
        assert!(!environment.contains("CARGO_PKG_NAME="));
    }
}
