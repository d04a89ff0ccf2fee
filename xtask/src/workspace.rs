//! Where the workspace and its build products are.

use std::env;
use std::ffi::OsString;
use std::path::PathBuf;
use std::process::Command;

use serde_json::Value;

use crate::error::Error;

/// The cargo that runs this program, or the one on the path when it was started by hand.
pub(crate) fn cargo() -> OsString {
    env::var_os("CARGO").unwrap_or_else(|| "cargo".into())
}

/// Places of the workspace.
pub(crate) struct Workspace {
    /// The folder of the workspace's Cargo.toml.
    pub(crate) root: PathBuf,
    /// The folder of host builds.
    pub(crate) target: PathBuf,
}

impl Workspace {
    /// Asks cargo, which knows about `CARGO_TARGET_DIR` and the configuration files.
    ///
    /// # Errors
    /// When cargo cannot be started, fails, or prints something else.
    pub(crate) fn find() -> Result<Self, Error> {
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
        Self::from_metadata(&output.stdout).ok_or(Error::Answer {
            program: program.into(),
            expected: "`workspace_root` and `target_directory`",
        })
    }

    fn from_metadata(json: &[u8]) -> Option<Self> {
        let metadata: Value = serde_json::from_slice(json).ok()?;
        Some(Self {
            root: metadata.get("workspace_root")?.as_str()?.into(),
            target: metadata.get("target_directory")?.as_str()?.into(),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn both_folders_are_read_from_the_metadata() {
        let json = br#"{"packages":[],"workspace_root":"/a","target_directory":"/b/target"}"#;
        let workspace = Workspace::from_metadata(json).unwrap();
        assert_eq!(workspace.root, Path::new("/a"));
        assert_eq!(workspace.target, Path::new("/b/target"));
    }

    #[test]
    fn metadata_without_a_folder_is_no_workspace() {
        assert!(Workspace::from_metadata(br#"{"workspace_root":"/a"}"#).is_none());
        assert!(Workspace::from_metadata(b"not json").is_none());
    }
}
