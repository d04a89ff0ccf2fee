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

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use serde_json::Value;

use self::cycles::shortest_cycles;
use self::resolve::needs;
use self::source::read_crate;
use crate::error::Error;
use crate::workspace::cargo;

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
const FREE: [&str; 8] = [
    "can-frame",
    "dyn-can",
    "dyn-serial",
    "dyn-values",
    "host-tests",
    "motionctl",
    "xtask",
    "zlac8030l",
];

/// Runs the task.
///
/// # Errors
/// When a package is unknown, a file cannot be read, or files need each other.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Error> {
    let roots = crate_roots()?;
    let free: Vec<String> = FREE.map(str::to_owned).to_vec();
    let packages = if arguments.package.is_empty() {
        &free
    } else {
        &arguments.package
    };
    let mut cycles = 0;
    for package in packages {
        let roots = roots.get(package).ok_or_else(|| Error::UnknownPackage {
            package: package.clone(),
        })?;
        for root in roots {
            cycles += check(root)?;
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

/// The root files of libraries and programs, relative to the current folder where they are below it, by package.
fn crate_roots() -> Result<BTreeMap<String, Vec<PathBuf>>, Error> {
    let program = "cargo metadata";
    let output = Command::new(cargo())
        .args(["metadata", "--no-deps", "--format-version", "1"])
        .output()
        .map_err(|reason| Error::Start {
            program: program.into(),
            reason,
        })?;
    if !output.status.success() {
        eprint!("{}", String::from_utf8_lossy(&output.stderr));
        return Err(Error::Failed {
            program: program.into(),
            status: output.status,
        });
    }
    let here = std::env::current_dir().unwrap_or_default();
    roots_in_metadata(&output.stdout, &here).ok_or(Error::Answer {
        program: program.into(),
        expected: "packages with targets",
    })
}

fn roots_in_metadata(json: &[u8], here: &Path) -> Option<BTreeMap<String, Vec<PathBuf>>> {
    let metadata: Value = serde_json::from_slice(json).ok()?;
    let mut roots = BTreeMap::new();
    for package in metadata.get("packages")?.as_array()? {
        let mut files = Vec::new();
        for target in package.get("targets")?.as_array()? {
            let kinds = target.get("kind")?.as_array()?;
            if kinds.iter().any(|kind| kind == "lib" || kind == "bin") {
                let path = Path::new(target.get("src_path")?.as_str()?);
                files.push(path.strip_prefix(here).unwrap_or(path).to_path_buf());
            }
        }
        roots.insert(package.get("name")?.as_str()?.to_owned(), files);
    }
    Some(roots)
}

#[cfg(test)]
mod tests;
