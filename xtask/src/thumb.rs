//! Builds packages for the Cortex-M4F of the boards.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus};

use crate::error::Error;
use crate::places;
use crate::target::Target;
use crate::toolchain::{Preference, Toolchain};
use crate::workspace::{Workspace, cargo};

/// The target of every board: Cortex-M4 with its floating-point unit.
pub(crate) const TARGET: Target = Target {
    triple: "thumbv7em-none-eabihf",
    libraries: "core",
    linker: "rust-lld",
    linker_is_apart: false,
    packages: &["rustc-web", "rust-web-src"],
};

/// What a build has beside its package.
#[derive(Default)]
pub(crate) struct Variant {
    /// Further arguments for cargo.
    pub(crate) arguments: Vec<String>,
    /// Variables of the environment.
    pub(crate) environment: Vec<(String, String)>,
}

impl Variant {
    /// Only arguments.
    pub(crate) fn with_arguments(arguments: &[String]) -> Self {
        Self {
            arguments: arguments.to_vec(),
            environment: Vec::new(),
        }
    }
}

/// Release builds for [`TARGET`] with one toolchain.
pub(crate) struct Builder {
    workspace: Workspace,
    toolchain: Toolchain,
    folder: PathBuf,
}

impl Builder {
    /// Looks for a toolchain and says which one it is.
    ///
    /// # Errors
    /// When there is no toolchain for the target.
    pub(crate) fn find(preference: Preference) -> Result<Self, Error> {
        let workspace = Workspace::find()?;
        let toolchain = Toolchain::find(&TARGET, preference)?;
        eprintln!("building for {}: {}", TARGET.triple, toolchain.describe());
        // Apart from the host builds: another compiler in the same folder would make both build everything anew each time.
        let folder = workspace.target.join("thumb");
        Ok(Self {
            workspace,
            toolchain,
            folder,
        })
    }

    /// The folder of the workspace.
    pub(crate) fn root(&self) -> &Path {
        &self.workspace.root
    }

    /// The folder of build products.
    pub(crate) fn target(&self) -> &Path {
        &self.workspace.target
    }

    /// The compiler with its version, and where the target's core library comes from.
    pub(crate) fn compiler(&self) -> String {
        self.toolchain.version()
    }

    /// The folder of the images.
    pub(crate) fn images(&self) -> PathBuf {
        self.folder.join(TARGET.triple).join("release")
    }

    /// Builds a package, with the messages of cargo on the standard error.
    ///
    /// # Errors
    /// When the build fails.
    pub(crate) fn build(&self, package: &str, variant: &Variant) -> Result<(), Error> {
        let mut build = self.command(package);
        build.args(&variant.arguments).envs(
            variant
                .environment
                .iter()
                .map(|(name, value)| (name, value)),
        );
        match build.status() {
            Ok(status) if status.success() => Ok(()),
            Ok(status) => Err(failed(package, status)),
            Err(reason) => Err(not_started(package, reason)),
        }
    }

    /// Builds an image that must not link because of an undefined symbol with this text in its name.
    ///
    /// # Errors
    /// When it links, or fails for another reason.
    pub(crate) fn refuse(
        &self,
        package: &str,
        image: &'static str,
        symbol: &str,
    ) -> Result<(), Error> {
        let mut build = self.command(package);
        let output = build
            .args(["--features", image, "--bin", image])
            .output()
            .map_err(|reason| not_started(package, reason))?;
        let messages = String::from_utf8_lossy(&output.stderr);
        if output.status.success() {
            return Err(Error::Linked { image });
        }
        if messages.contains(symbol) {
            return Ok(());
        }
        eprint!("{messages}");
        Err(failed(package, output.status))
    }

    fn command(&self, package: &str) -> Command {
        let mut build = Command::new(cargo());
        build
            .current_dir(&self.workspace.root)
            .args(["build", "--release", "--target", TARGET.triple, "--package"])
            .arg(package)
            .arg("--target-dir")
            .arg(&self.folder)
            .args(places::shorter(&self.toolchain.rustc(), TARGET.triple));
        self.toolchain.apply(&mut build);
        build
    }
}

fn program(package: &str) -> String {
    format!("cargo build --package {package}")
}

fn failed(package: &str, status: ExitStatus) -> Error {
    Error::Failed {
        program: program(package),
        status,
    }
}

fn not_started(package: &str, reason: std::io::Error) -> Error {
    Error::Start {
        program: program(package),
        reason,
    }
}
