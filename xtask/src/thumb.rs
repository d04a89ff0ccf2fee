//! Builds packages for the Cortex-M4F of the boards.

use std::path::PathBuf;
use std::process::Command;

use crate::error::Error;
use crate::toolchain::{Preference, Toolchain};
use crate::workspace::{Workspace, cargo};

/// The target of every board: Cortex-M4 with its floating-point unit.
pub(crate) const TARGET: &str = "thumbv7em-none-eabihf";

/// A release build of one package for [`TARGET`].
pub(crate) struct Build<'a> {
    /// The package.
    pub(crate) package: &'a str,
    /// Which toolchain to take.
    pub(crate) preference: Preference,
    /// Further arguments for `cargo build`.
    pub(crate) arguments: &'a [String],
}

impl Build<'_> {
    /// Builds, with the messages of cargo on the standard error, and returns the folder of the images.
    ///
    /// # Errors
    /// When there is no toolchain for the target or the build fails.
    pub(crate) fn run(&self) -> Result<PathBuf, Error> {
        let workspace = Workspace::find()?;
        let toolchain = Toolchain::find(TARGET, self.preference)?;
        eprintln!(
            "building {} for {TARGET}: {}",
            self.package,
            toolchain.describe()
        );
        // Apart from the host builds: another compiler in the same folder would make both build everything anew each time.
        let folder = workspace.target.join("thumb");
        let mut build = Command::new(cargo());
        build
            .current_dir(&workspace.root)
            .args([
                "build",
                "--release",
                "--target",
                TARGET,
                "--package",
                self.package,
                "--target-dir",
            ])
            .arg(&folder)
            .args(self.arguments);
        toolchain.apply(&mut build);
        let program = format!("cargo build --package {}", self.package);
        match build.status() {
            Ok(status) if status.success() => Ok(folder.join(TARGET).join("release")),
            Ok(status) => Err(Error::Failed { program, status }),
            Err(reason) => Err(Error::Start { program, reason }),
        }
    }
}
