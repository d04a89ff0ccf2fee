//! Where the workspace and its build products are.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
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
    /// The packages.
    pub(crate) packages: Vec<Package>,
}

/// A package of the workspace.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct Package {
    pub(crate) name: String,
    /// The folder of its Cargo.toml.
    pub(crate) folder: PathBuf,
    /// The root files of its libraries and programs.
    pub(crate) roots: Vec<PathBuf>,
}

impl Package {
    fn from_metadata(package: &Value) -> Option<Self> {
        let mut roots = Vec::new();
        for target in package.get("targets")?.as_array()? {
            let kinds = target.get("kind")?.as_array()?;
            if kinds.iter().any(|kind| kind == "lib" || kind == "bin") {
                roots.push(target.get("src_path")?.as_str()?.into());
            }
        }
        let manifest = Path::new(package.get("manifest_path")?.as_str()?);
        Some(Self {
            name: package.get("name")?.as_str()?.to_owned(),
            folder: manifest.parent()?.to_path_buf(),
            roots,
        })
    }
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
            expected: "`workspace_root`, `target_directory` and `packages`",
        })
    }

    /// The package with this name.
    ///
    /// # Errors
    /// [`Error::UnknownPackage`].
    pub(crate) fn package(&self, name: &str) -> Result<&Package, Error> {
        let found = self.packages.iter().find(|package| package.name == name);
        found.ok_or_else(|| Error::UnknownPackage {
            package: name.to_owned(),
        })
    }

    fn from_metadata(json: &[u8]) -> Option<Self> {
        let metadata: Value = serde_json::from_slice(json).ok()?;
        Some(Self {
            root: metadata.get("workspace_root")?.as_str()?.into(),
            target: metadata.get("target_directory")?.as_str()?.into(),
            packages: metadata
                .get("packages")?
                .as_array()?
                .iter()
                .map(Package::from_metadata)
                .collect::<Option<_>>()?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_folders_are_read_from_the_metadata() {
        let json = br#"{"packages":[],"workspace_root":"/a","target_directory":"/b/target"}"#;
        let workspace = Workspace::from_metadata(json).unwrap();
        assert_eq!(workspace.root, Path::new("/a"));
        assert_eq!(workspace.target, Path::new("/b/target"));
    }

    #[test]
    fn packages_are_read_with_the_roots_of_libraries_and_programs() {
        let json = br#"{"workspace_root":"/w","target_directory":"/w/target","packages":[
            {"name":"p","manifest_path":"/w/p/Cargo.toml","targets":[
                {"kind":["lib"],"src_path":"/w/p/src/lib.rs"},
                {"kind":["test"],"src_path":"/w/p/tests/t.rs"}]}]}"#;
        let package = Package {
            name: "p".into(),
            folder: "/w/p".into(),
            roots: vec!["/w/p/src/lib.rs".into()],
        };
        assert_eq!(Workspace::from_metadata(json).unwrap().packages, [package]);
    }

    #[test]
    fn metadata_without_a_folder_is_no_workspace() {
        assert!(Workspace::from_metadata(br#"{"workspace_root":"/a"}"#).is_none());
        assert!(Workspace::from_metadata(b"not json").is_none());
    }
}
