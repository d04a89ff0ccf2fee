//! The Python package: its wheel, built here, its types, its tests and its examples.

use std::fs;
use std::path::Path;

use super::interop::virtual_environment;
use super::place::Place;
use crate::error::Error;

/// Pinned: a step must not change because one of them was released.
const PACKAGES: [&str; 4] = [
    "maturin==1.16.0",
    "numpy==2.4.6",
    "pytest==9.2.0",
    "mypy==2.4.1",
];
const FOLDER: &str = "python";

/// Builds the wheel into `target`, installs it beside the tools, and runs the tests against it and the tool.
pub(super) fn run(place: &Place) -> Result<Vec<String>, Error> {
    place.cargo(&format!("fmt --manifest-path {FOLDER}/Cargo.toml --check"))?;
    let python = virtual_environment(place, "python-package", &PACKAGES)?;
    let products = place.target().join("python");
    lint(place, &python, &products)?;
    let wheels = products.join("wheels");
    // One of another version would be installed as well.
    let _ = fs::remove_dir_all(&wheels);
    let mut build = place.command(&python);
    build
        .args(["-m", "maturin", "build", "--release", "--quiet"])
        .args(["--manifest-path", "python/Cargo.toml", "--out"])
        .arg(&wheels)
        .arg("--interpreter")
        .arg(&python)
        .env("CARGO_TARGET_DIR", &products);
    place.run(&mut build)?;
    let mut install = place.command(&python);
    install
        .args(["-m", "pip", "-q", "--disable-pip-version-check", "install"])
        .args([
            "--no-index",
            "--no-deps",
            "--force-reinstall",
            "--find-links",
        ])
        .arg(&wheels)
        .arg("motion-board");
    place.run(&mut install)?;
    let mut types = place.command(&python);
    types
        .current_dir(place.root().join(FOLDER))
        .args(["-m", "mypy", "--no-error-summary", "--cache-dir"])
        .arg(products.join("mypy"));
    place.run(&mut types)?;
    let motionctl = place.tool("motionctl", "motionctl")?;
    let mut tests = place.command(&python);
    tests
        .current_dir(place.root().join(FOLDER))
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider"])
        .env("MOTIONCTL", motionctl);
    place.script(&mut tests)
}

fn lint(place: &Place, python: &Path, products: &Path) -> Result<(), Error> {
    let mut clippy = place.command(crate::workspace::cargo());
    clippy
        .args(["clippy", "-q", "--release", "--manifest-path"])
        .args(["python/Cargo.toml", "--", "-D", "warnings"])
        .env("PYO3_PYTHON", python)
        .env("CARGO_TARGET_DIR", products);
    place.run(&mut clippy)
}
