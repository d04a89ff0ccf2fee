//! A firmware with one axis too many does not compile, and the message names the frame.

use std::path::Path;
use std::process::{Command, Output};

/// Checks the crate that is meant to fail, in a folder of its own: cargo holds the usual one while tests are built.
fn check(features: &[&str]) -> Output {
    let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("one-axis-too-many");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    Command::new(cargo)
        .args(["check", "--locked", "--color", "never", "--manifest-path"])
        .arg(package.join("Cargo.toml"))
        .arg("--target-dir")
        .arg(Path::new(env!("CARGO_TARGET_TMPDIR")).join("one-axis-too-many"))
        .args(["--features", &features.join(",")])
        .output()
        .expect("cargo runs")
}

#[test]
fn one_axis_too_many_does_not_compile_and_the_message_names_the_frame() {
    let fits = check(&["fits"]);
    let message = String::from_utf8_lossy(&fits.stderr);
    assert!(fits.status.success(), "14 axes must compile: {message}");

    let too_many = check(&[]);
    let message = String::from_utf8_lossy(&too_many.stderr);
    assert!(!too_many.status.success(), "15 axes must not compile");
    let expected = "set-point of drive 15 does not fit: with it a cycle carries 1052 bit times, but lasts 1000; \
                    it would fit with cycle_us = 1250, or the first 14 axes";
    assert!(
        message.contains(expected),
        "expected {expected:?} in {message}"
    );
}
