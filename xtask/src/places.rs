//! The folder of the packages, which the compiler writes into an image as a part of the place of each possible panic, is left out: it is
//! another one on each machine, and some hundred bytes.

use std::env;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Only the places that a program can tell; debug information keeps whole paths.
const SCOPE: &str = "--remap-path-scope=macro";

/// What makes cargo leave the folders out for a target; nothing when the compiler cannot, before 1.95.
pub(crate) fn shorter(rustc: &OsStr, triple: &str) -> Vec<String> {
    if !knows_scope(rustc) {
        return Vec::new();
    }
    let folders = cargo_home().map(|home| folders_of(&home));
    let flags = flags(&folders.unwrap_or_default());
    if flags.is_empty() {
        return Vec::new();
    }
    vec![
        "--config".into(),
        format!("target.{triple}.rustflags={flags:?}"),
    ]
}

fn knows_scope(rustc: &OsStr) -> bool {
    Command::new(rustc)
        .args([SCOPE, "--version"])
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status()
        .is_ok_and(|status| status.success())
}

fn cargo_home() -> Option<PathBuf> {
    let usual = || Some(env::home_dir()?.join(".cargo"));
    env::var_os("CARGO_HOME").map(Into::into).or_else(usual)
}

/// Where cargo unpacks the packages of each registry, in order: another order would compile everything anew.
fn folders_of(home: &Path) -> Vec<PathBuf> {
    let registries = home.join("registry").join("src").read_dir();
    let mut folders: Vec<PathBuf> = registries
        .into_iter()
        .flatten()
        .flatten()
        .map(|folder| folder.path())
        .collect();
    folders.sort();
    folders
}

fn flags(folders: &[PathBuf]) -> Vec<String> {
    let remap = |folder: &PathBuf| Some(format!("--remap-path-prefix={}=", folder.to_str()?));
    let mut flags: Vec<String> = folders.iter().filter_map(remap).collect();
    if !flags.is_empty() {
        flags.push(SCOPE.into());
    }
    flags
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_a_registry_there_is_nothing_to_leave_out() {
        assert!(flags(&[]).is_empty());
        assert!(folders_of(Path::new("no such folder")).is_empty());
    }

    #[test]
    fn each_folder_is_left_out_of_places_alone() {
        let folders = ["/a b/registry/src/x".into(), "/c/\"d".into()];
        assert_eq!(
            flags(&folders),
            [
                "--remap-path-prefix=/a b/registry/src/x=",
                "--remap-path-prefix=/c/\"d=",
                SCOPE
            ]
        );
    }

    #[test]
    fn a_compiler_that_is_not_there_leaves_nothing_out() {
        let rustc = OsStr::new("no-such-compiler");
        assert!(shorter(rustc, "thumbv7em-none-eabihf").is_empty());
    }
}
