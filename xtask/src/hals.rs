//! `cargo xtask hals`: the examples for other people's drivers compile.

use std::process::Command;

use crate::error::Error;
use crate::target::Target;
use crate::thumb;
use crate::toolchain::{Preference, Toolchain};
use crate::workspace::{Workspace, cargo};

/// The workspace of the examples, from the root.
const FOLDER: &str = "hal-examples";
/// The processor of an ESP32-C3.
static RISCV: Target = Target {
    triple: "riscv32imc-unknown-none-elf",
    ..thumb::TARGET
};
/// Target, `None` for the host, and the packages that are for it.
static EXAMPLES: [(Option<&Target>, &[&str]); 3] = [
    (None, &["with-bxcan", "with-mcp2515", "with-socketcan"]),
    (Some(&thumb::TARGET), &["with-embassy"]),
    (Some(&RISCV), &["with-esp32"]),
];

/// Checks the examples for other people's drivers: on the host those that need no chip, for a Cortex-M4F and an ESP32-C3 the others.
#[derive(clap::Args)]
pub(crate) struct Arguments {
    /// Where the core library of the targets comes from
    #[arg(long, value_enum, default_value = "auto")]
    toolchain: Preference,
}

/// Runs the task.
///
/// # Errors
/// When there is no toolchain for a target, or an example does not compile.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    let workspace = Workspace::find()?;
    for &(target, packages) in &EXAMPLES {
        let mut check = Command::new(cargo());
        check
            .current_dir(workspace.root.join(FOLDER))
            // The compiler that builds a core library of its own may have no clippy.
            .args([
                if target.is_some() { "check" } else { "clippy" },
                "--locked",
            ])
            .arg("--target-dir")
            .arg(workspace.target.join(FOLDER));
        if let Some(target) = target {
            // What is installed for the boards need not be for other chips.
            let preference = match arguments.toolchain {
                Preference::Installed if target.triple != thumb::TARGET.triple => Preference::Auto,
                preference => preference,
            };
            let toolchain = Toolchain::find(target, preference)?;
            eprintln!("checking for {}: {}", target.triple, toolchain.describe());
            toolchain.apply(&mut check);
            check.args(["--target", target.triple]);
        }
        for package in packages {
            check.args(["--package", package]);
        }
        check.env("RUSTFLAGS", "-D warnings");
        let program = format!("cargo check in {FOLDER}, {}", packages.join(" "));
        match check.status() {
            Ok(status) if status.success() => {}
            Ok(status) => return Err(Error::Failed { program, status }),
            Err(reason) => return Err(Error::Start { program, reason }),
        }
    }
    Ok(())
}
