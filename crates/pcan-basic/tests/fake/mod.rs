//! A library with the functions of PCAN-Basic, built for the test.

use std::path::PathBuf;
use std::process::Command;
use std::sync::OnceLock;

/// The source.
const SOURCE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fake/pcan_basic.c");

/// The library, as a file. It is built once for each test program.
pub(crate) fn library() -> PathBuf {
    static FILE: OnceLock<PathBuf> = OnceLock::new();
    FILE.get_or_init(|| {
        let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR"))
            .join(format!("libfake_pcan_{}.so", std::process::id()));
        let built = Command::new("cc")
            .args(["-shared", "-fPIC", "-Wall", "-Werror", "-o"])
            .args([file.as_os_str(), SOURCE.as_ref()])
            .status()
            .expect("a C compiler, which Rust links with as well");
        assert!(built.success());
        file
    })
    .clone()
}
