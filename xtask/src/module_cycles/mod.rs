//! `cargo xtask module-cycles`: no two files of a crate may need each other.
//!
//! The rule. A file needs another file of its crate when its code, tests apart, names something that is defined there: in a `use`, in
//! a path, or in the tokens of a macro. A name that a module passes on is traced to the file that defines it, so that
//! `use super::Frame` in `frame/id.rs` counts as what it is, however `frame/mod.rs` came by `Frame`. Two things are not a need, or a
//! crate could not be split into files at all: the declaration `mod child;`, and a `pub use` with which a module passes on what lies
//! below it and which its own code does not mention. What is under `#[cfg(test)]` is left out.
//!
//! Why. Files that need each other can be read, tested and moved only together.

mod cycles;
mod need;
mod paths;
mod resolve;
mod source;

use std::env;
use std::fs;
use std::path::Path;

use self::cycles::shortest_cycles;
use self::resolve::needs;
use self::source::read_crate;
use crate::error::Error;
use crate::workspace::Workspace;

/// Shows which files of a crate need each other.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  \
    cargo xtask module-cycles                          every crate that is kept free of cycles\n  \
    cargo xtask module-cycles --package can-motion     one crate, whether or not it is kept free\n\n\
    A line is one way around. Each arrow names the file, the line and the path by which it needs the next file. Move what both\n\
    need into a file of its own, or hand it over as an argument.")]
pub(crate) struct Arguments {
    /// The package; may be given more than once
    #[arg(long, value_name = "PACKAGE")]
    package: Vec<String>,
}

/// The crates that are free of cycles and stay so.
const FREE: [&str; 18] = [
    "board-link",
    "board-settings",
    "bus-plan",
    "bus-user",
    "can-frame",
    "can-motion",
    "diff-drive",
    "dyn-can",
    "dyn-commission",
    "dyn-serial",
    "dyn-values",
    "homing",
    "host-tests",
    "path",
    "program",
    "record-store",
    "xtask",
    "zlac8030l",
];

/// Runs the task.
///
/// # Errors
/// When a package is unknown, a file cannot be read, or files need each other.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    let workspace = Workspace::find()?;
    let free: Vec<String> = FREE.map(str::to_owned).to_vec();
    let packages = if arguments.package.is_empty() {
        &free
    } else {
        &arguments.package
    };
    // Messages name files as the user would.
    let here = env::current_dir().unwrap_or_default();
    let mut cycles = 0;
    for package in packages {
        for root in &workspace.package(package)?.roots {
            cycles += check(root.strip_prefix(&here).unwrap_or(root))?;
        }
    }
    if cycles == 0 {
        return Ok(());
    }
    Err(Error::ModuleCycles { cycles })
}

/// Prints the cycles of one crate; the result is their number.
fn check(root: &Path) -> Result<usize, Error> {
    let modules = read_crate(root, &|path| fs::read_to_string(path))?;
    let graph = needs(&modules);
    let cycles = shortest_cycles(&graph);
    println!(
        "{}: {} files, {} needs, {} cycles",
        root.display(),
        modules.files().len(),
        graph.len(),
        cycles.len()
    );
    for cycle in &cycles {
        println!();
        for need in cycle {
            println!("  {need}");
        }
    }
    Ok(cycles.len())
}

#[cfg(test)]
mod tests;
