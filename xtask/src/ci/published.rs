//! The packages as crates.io would have them, and somebody who has nothing else.

use std::fs;
use std::path::{Path, PathBuf};

use super::place::Place;
use crate::error::Error;

/// The project of somebody else, from the root.
const OUTSIDE: &str = "outside";
/// Most lines of its program: a start that needs more is no easy one.
const MOST_LINES: usize = 60;
/// An example that a package brings along.
const EXAMPLE: (&str, &str) = ("can-motion", "servo");

/// Packs every crate for users, unpacks what was packed, and builds and runs a project outside the workspace, and an example, from it.
pub(super) fn run(place: &Place) -> Result<Vec<String>, Error> {
    let crates = crates(&place.root().join("crates"))?;
    let packed: Vec<String> = crates.iter().map(|name| format!("-p {name}")).collect();
    // What is packed is built below, where nothing of the workspace is near.
    place.cargo(&format!(
        "package --no-verify --allow-dirty {}",
        packed.join(" ")
    ))?;
    let folder = place.target().join("published");
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(|reason| file(&folder, reason))?;
    }
    let unpacked = folder.join("packages");
    fs::create_dir_all(&unpacked).map_err(|reason| file(&unpacked, reason))?;
    let mut patches = Vec::new();
    for name in &crates {
        let package = newest(&place.target().join("package"), name)?;
        let mut tar = place.command("tar");
        place.run(tar.arg("xzf").arg(&package).arg("-C").arg(&unpacked))?;
        let home = unpacked.join(package.file_stem().unwrap_or_default());
        patches.push(format!("patch.crates-io.{name}.path={home:?}"));
    }
    let project = project(place, &folder)?;
    run_from(place, &folder, &patches, &project, &[])?;
    let (package, example) = EXAMPLE;
    let home = newest(&place.target().join("package"), package)?;
    let manifest = unpacked
        .join(home.file_stem().unwrap_or_default())
        .join("Cargo.toml");
    let without_itself: Vec<String> = patches
        .iter()
        .filter(|patch| !patch.starts_with(&format!("patch.crates-io.{package}.")))
        .cloned()
        .collect();
    run_from(
        place,
        &folder,
        &without_itself,
        &manifest,
        &["--example", example],
    )?;
    Ok(Vec::new())
}

/// Runs a program with the unpacked packages in place of those of crates.io.
fn run_from(
    place: &Place,
    folder: &Path,
    patches: &[String],
    manifest: &Path,
    more: &[&str],
) -> Result<(), Error> {
    let mut cargo = place.command(crate::workspace::cargo());
    cargo.args(["run", "-q"]).args(more);
    cargo.arg("--manifest-path").arg(manifest);
    cargo.arg("--target-dir").arg(folder.join("target"));
    for patch in patches {
        cargo.args(["--config", patch]);
    }
    // A page of events; that it ends well is what counts.
    cargo.stdout(std::process::Stdio::null());
    println!(
        "$ cargo run {} --manifest-path {} (with the packages)",
        more.join(" "),
        manifest.display()
    );
    place.run(&mut cargo)
}

/// A copy of the project outside, with the versions that the workspace was tested with. Returns its manifest.
fn project(place: &Place, folder: &Path) -> Result<PathBuf, Error> {
    let (from, to) = (place.root().join(OUTSIDE), folder.join(OUTSIDE));
    let copy = |from: PathBuf, to: PathBuf| {
        fs::copy(&from, &to)
            .map(|_| ())
            .map_err(|reason| file(&from, reason))
    };
    fs::create_dir_all(to.join("src")).map_err(|reason| file(&to, reason))?;
    let program = from.join("src/main.rs");
    let text = fs::read_to_string(&program).map_err(|reason| file(&program, reason))?;
    if text.lines().count() > MOST_LINES {
        return Err(Error::Answer {
            program: program.display().to_string(),
            expected: "at most 60 lines",
        });
    }
    copy(program, to.join("src/main.rs"))?;
    copy(from.join("Cargo.toml"), to.join("Cargo.toml"))?;
    copy(place.root().join("Cargo.lock"), to.join("Cargo.lock"))?;
    Ok(to.join("Cargo.toml"))
}

/// The names of the crates that are for users.
fn crates(folder: &Path) -> Result<Vec<String>, Error> {
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(|reason| file(folder, reason))? {
        let entry = entry.map_err(|reason| file(folder, reason))?;
        names.push(entry.file_name().to_string_lossy().into_owned());
    }
    names.sort_unstable();
    Ok(names)
}

/// The file of a package: the name, a hyphen, a version.
fn newest(folder: &Path, name: &str) -> Result<PathBuf, Error> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(|reason| file(folder, reason))? {
        let path = entry.map_err(|reason| file(folder, reason))?.path();
        if is_of(&path, name) {
            found.push(path);
        }
    }
    let changed = |path: &PathBuf| fs::metadata(path).and_then(|data| data.modified()).ok();
    found
        .into_iter()
        .max_by_key(changed)
        .ok_or(Error::MissingTool {
            tool: "package",
            place: folder.join(name),
        })
}

/// Whether a file is a package of this name, and not of one that begins with it.
fn is_of(path: &Path, name: &str) -> bool {
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let version = file
        .strip_prefix(name)
        .and_then(|rest| rest.strip_prefix('-'))
        .and_then(|rest| rest.strip_suffix(".crate"));
    version.is_some_and(|version| version.starts_with(|letter: char| letter.is_ascii_digit()))
}

fn file(path: &Path, reason: std::io::Error) -> Error {
    Error::Start {
        program: path.display().to_string(),
        reason,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_package_is_known_by_its_whole_name() {
        let is = |file: &str, name| is_of(Path::new(file), name);
        assert!(is("target/package/path-0.1.0.crate", "path"));
        assert!(!is("target/package/path-planner-0.1.0.crate", "path"));
        assert!(!is("target/package/path-0.1.0", "path"));
        assert!(!is("target/package/can-path-0.1.0.crate", "path"));
    }
}
