//! The Python package: its wheel, built here, its types, its tests and its examples.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use super::interop::virtual_environment;
use super::place::Place;
use crate::error::Error;
use crate::workspace::cargo;

/// Pinned: a step must not change because one of them was released.
const PACKAGES: [&str; 4] = [
    "maturin==1.16.0",
    "numpy==2.4.6",
    "pytest==9.2.0",
    "mypy==2.4.1",
];
const FOLDER: &str = "python";

/// Checks the package, and runs its tests against itself and the tool.
pub(super) fn run(place: &Place) -> Result<Vec<String>, Error> {
    place.cargo(&format!("fmt --manifest-path {FOLDER}/Cargo.toml --check"))?;
    let python = installed(place)?;
    lint(place, &python)?;
    let mut types = in_folder(place, &python);
    types
        .args(["-m", "mypy", "--no-error-summary", "--cache-dir"])
        .arg(products(place).join("mypy"));
    place.run(&mut types)?;
    let motionctl = place.tool("motionctl", "motionctl")?;
    let mut tests = in_folder(place, &python);
    tests
        .args(["-m", "pytest", "-q", "-p", "no:cacheprovider"])
        .env("MOTIONCTL", motionctl);
    place.script(&mut tests)
}

/// Runs an example against the real image on the emulated board.
pub(super) fn on_emulator(place: &Place) -> Result<Vec<String>, Error> {
    let python = installed(place)?;
    let mut test = place.command(&python);
    test.arg("python/tests/on_emulator.py")
        .arg(cargo())
        .arg(products(place).join("emulator"));
    place.script(&mut test)
}

/// The Python in which the wheel is installed, built here.
fn installed(place: &Place) -> Result<PathBuf, Error> {
    let python = virtual_environment(place, "python-package", &PACKAGES)?;
    let wheels = products(place).join("wheels");
    // One of another version would be installed as well.
    let _ = fs::remove_dir_all(&wheels);
    let mut build = place.command(&python);
    build
        .args(["-m", "maturin", "build", "--release", "--quiet"])
        .args(["--manifest-path", "python/Cargo.toml", "--out"])
        .arg(&wheels)
        .arg("--interpreter")
        .arg(&python)
        .env("CARGO_TARGET_DIR", products(place));
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
    Ok(python)
}

fn products(place: &Place) -> PathBuf {
    place.target().join("python")
}

fn in_folder(place: &Place, python: &Path) -> Command {
    let mut command = place.command(python);
    command.current_dir(place.root().join(FOLDER));
    command
}

fn lint(place: &Place, python: &Path) -> Result<(), Error> {
    let mut clippy = place.command(cargo());
    clippy
        .args(["clippy", "-q", "--release", "--manifest-path"])
        .args(["python/Cargo.toml", "--", "-D", "warnings"])
        .env("PYO3_PYTHON", python)
        .env("CARGO_TARGET_DIR", products(place));
    place.run(&mut clippy)
}
