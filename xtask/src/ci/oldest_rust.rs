//! The oldest Rust that the manifests allow compiles everything.

use super::place::Place;
use crate::error::Error;

/// The version; every package has that of the workspace.
pub(super) const VERSION: &str = env!("CARGO_PKG_RUST_VERSION");

/// Checks the workspace with it, apart from the other builds.
pub(super) fn run(place: &Place) -> Result<Vec<String>, Error> {
    let mut check = place.command("rustup");
    check
        .args(["run", VERSION, "cargo", "check", "--locked"])
        .args(["--workspace", "--all-targets", "--target-dir"])
        .arg(place.target().join("oldest-rust"));
    place.run(&mut check)?;
    Ok(Vec::new())
}
