//! `cargo xtask windows`: builds the tool for Windows, on any system.

use std::path::PathBuf;
use std::process::Command;

use crate::error::Error;
use crate::target::Target;
use crate::toolchain::{Preference, Toolchain};
use crate::workspace::{Workspace, cargo};

/// 64-bit Windows, linked with MinGW: everything it needs is free and in distributions.
pub(crate) const TARGET: Target = Target {
    triple: "x86_64-pc-windows-gnu",
    libraries: "std,panic_abort",
    linker: "x86_64-w64-mingw32-gcc",
    linker_is_apart: true,
    packages: &["rustc-web", "rust-web-src", "gcc-mingw-w64-x86-64"],
};

/// The profile of a build that is only tried, and the folder of its programs.
pub(crate) const QUICK: Profile = Profile {
    name: "dev",
    folder: "debug",
};
/// The profile of a build that is used.
const USED: Profile = Profile {
    name: "tools",
    folder: "tools",
};

/// A profile of cargo.
#[derive(Clone, Copy)]
pub(crate) struct Profile {
    name: &'static str,
    folder: &'static str,
}

/// Builds motionctl for 64-bit Windows and prints where it is.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask windows                       build motionctl.exe, optimised\n  \
    cargo xtask windows --quick               not optimised, to see whether it builds\n  \
    cargo xtask windows --toolchain source    build std from source, as on a machine without rustup's server\n\n\
    Warnings are errors. It needs the linker x86_64-w64-mingw32-gcc (Debian: gcc-mingw-w64-x86-64).")]
pub(crate) struct Arguments {
    /// Where the standard library of Windows comes from
    #[arg(long, value_enum, default_value = "auto")]
    toolchain: Preference,

    /// Do not optimise
    #[arg(long)]
    quick: bool,
}

/// Runs the task.
///
/// # Errors
/// When there is no toolchain, or the build fails.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    let toolchain = Toolchain::find(&TARGET, arguments.toolchain)?;
    let profile = if arguments.quick { QUICK } else { USED };
    let program = build(&Workspace::find()?, &toolchain, profile)?;
    println!("{}", program.display());
    Ok(())
}

/// Builds the tool; the result is where it is.
///
/// # Errors
/// When the build fails.
pub(crate) fn build(
    workspace: &Workspace,
    toolchain: &Toolchain,
    profile: Profile,
) -> Result<PathBuf, Error> {
    eprintln!("building for {}: {}", TARGET.triple, toolchain.describe());
    // Apart from the host builds: another compiler in the same folder would make both build everything anew each time.
    let folder = workspace.target.join("windows");
    let mut command = Command::new(cargo());
    command
        .current_dir(&workspace.root)
        .args(["rustc", "--package", "motionctl", "--bin", "motionctl"])
        .args(["--target", TARGET.triple, "--profile", profile.name])
        .arg("--target-dir")
        .arg(&folder)
        // Nobody debugs it here, and it halves the time.
        .args(["--config", "profile.dev.debug=false"]);
    toolchain.apply(&mut command);
    command.args(["--", "-D", "warnings"]);
    let program = "cargo rustc --package motionctl";
    match command.status() {
        Ok(status) if status.success() => Ok(folder
            .join(TARGET.triple)
            .join(profile.folder)
            .join("motionctl.exe")),
        Ok(status) => Err(Error::Failed {
            program: program.into(),
            status,
        }),
        Err(reason) => Err(Error::Start {
            program: program.into(),
            reason,
        }),
    }
}
