//! The recipes of ARCHITECTURE.md, each followed once: a patch of `docs/recipes`, applied to a copy of the tree, and checked.

use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::place::Place;
use crate::error::Error;
use crate::thumb::TARGET;
use crate::toolchain::{Preference, Toolchain};
use crate::workspace::cargo;

/// Where the patches are, from the root.
const PATCHES: &str = "docs/recipes";
/// The version of the workspace's packages, and the one that they have in the copy: with another version cargo keeps what it builds of
/// them apart, so that the copy shares the folder of build products, and with it every dependency, and changes nothing of ours.
const VERSION: [&str; 2] = ["\nversion = \"0.1.0\"\n", "\nversion = \"0.1.999\"\n"];

/// One recipe.
struct Recipe {
    /// The name of the patch.
    name: &'static str,
    /// Lines for cargo, words separated by spaces: the checks that the page names, as narrow as they show what the patch adds.
    checks: &'static [&'static str],
    /// The checks need the target of the boards.
    for_boards: bool,
}

impl Recipe {
    const fn new(name: &'static str, checks: &'static [&'static str]) -> Self {
        Self {
            name,
            checks,
            for_boards: false,
        }
    }
}

const RECIPES: &[Recipe] = &[
    Recipe::new(
        "selector",
        &[
            "test -q -p dyn-can --features embedded-can --lib --test golden",
            "test -q -p drive-sim --lib reads",
            "test -q -p can-decode --lib dyn_drives",
            "test -q -p host-tests --test coverage",
        ],
    ),
    Recipe::new(
        "fault",
        &[
            "test -q -p can-motion --lib servo",
            "test -q -p host-tests --test findings faults_servo",
            "test -q -p host-tests --test docs_are_complete",
            "test -q -p board-settings --lib fault",
            "test -q -p motionctl --bin motionctl fault_text",
        ],
    ),
    Recipe::new(
        "family",
        &[
            "run -q -p can-motion --example increments",
            "test -q -p host-tests --test random_driver increments",
        ],
    ),
    Recipe {
        for_boards: true,
        ..Recipe::new(
            "board",
            &[
                "clippy -q --release -p motion-board --target thumbv7em-none-eabihf --no-default-features --features stm32f446 -- -D warnings",
                "clippy -q --release -p motion-board --target thumbv7em-none-eabihf --no-default-features --features stm32f446,commission -- -D warnings",
                "clippy -q --release -p motion-board --target thumbv7em-none-eabihf --no-default-features --features stm32f446,link -- -D warnings",
                "clippy -q --release -p motion-board --target thumbv7em-none-eabihf --no-default-features --features stm32f446,link-usb -- -D warnings",
                "test -q -p board-settings",
                "test -q -p xtask images",
            ],
        )
    },
    Recipe::new(
        "command",
        &["test -q -p motionctl --test functions --test words"],
    ),
    Recipe::new(
        "policy",
        &[
            "test -q -p can-motion --lib placement",
            "test -q -p can-motion --test life example",
            "test -q -p host-tests --test random_driver third",
        ],
    ),
];

/// Applies each patch to the copy and runs its checks; a patch without a recipe here, or the other way round, is a failure too.
pub(super) fn run(place: &Place) -> Result<Vec<String>, Error> {
    let folder = place.root().join(PATCHES);
    let mut complaints = unpaired(&names(&folder)?);
    let mut unchecked = Vec::new();
    let has_target = Toolchain::find(&TARGET, Preference::Installed).is_ok();
    for recipe in RECIPES {
        let patch = folder.join(recipe.name).with_extension("patch");
        if !patch.is_file() {
            continue;
        }
        if recipe.for_boards && !has_target {
            unchecked.push(format!(
                "{}: {} is not installed",
                recipe.name, TARGET.triple
            ));
            continue;
        }
        println!("{PATCHES}/{}.patch", recipe.name);
        complaints.extend(follow(place, recipe, &patch).err());
    }
    if complaints.is_empty() {
        return Ok(unchecked);
    }
    Err(Error::Recipes { complaints })
}

/// One recipe on a fresh copy; an error is the complaint.
fn follow(place: &Place, recipe: &Recipe, patch: &Path) -> Result<(), String> {
    let name = recipe.name;
    let tree = place.target().join("recipes").join("tree");
    refresh(place, &tree).map_err(|reason| format!("{}: {reason}", tree.display()))?;
    apply(place, patch, &tree).map_err(|_| {
        format!("{PATCHES}/{name}.patch does not apply, see above: follow the recipe again, and mend page and patch")
    })?;
    for line in recipe.checks {
        println!("$ cargo {line}");
        let mut check = place.command(cargo());
        check
            .args(line.split(' '))
            .current_dir(&tree)
            .env("CARGO_TARGET_DIR", place.target());
        place.run(&mut check).map_err(|_| {
            format!(
                "`cargo {line}` fails with {PATCHES}/{name}.patch: see above, the tree is in {}",
                tree.display()
            )
        })?;
    }
    Ok(())
}

/// Applies a patch to a folder that is no repository, although it lies in one.
fn apply(place: &Place, patch: &Path, tree: &Path) -> Result<(), Error> {
    let mut git = place.command("git");
    git.arg("apply").arg(patch).current_dir(tree);
    // Inside a repository `git apply` leaves out what is not in the folder where it runs, without a word.
    git.env("GIT_CEILING_DIRECTORIES", tree.parent().unwrap_or(tree));
    place.run(&mut git)
}

/// Brings the copy to what git tracks, with the version of a copy. Files that are as they should be are not touched, so that nothing is
/// built twice.
fn refresh(place: &Place, tree: &Path) -> io::Result<()> {
    let mut git = place.command("git");
    let listed = git.args(["ls-files", "-z"]).output()?;
    let listed = String::from_utf8_lossy(&listed.stdout);
    let files: BTreeSet<PathBuf> = listed
        .split('\0')
        .filter(|name| !name.is_empty() && place.root().join(name).is_file())
        .map(PathBuf::from)
        .collect();
    fs::create_dir_all(tree)?;
    remove_others(tree, tree, &files)?;
    for file in &files {
        let mut bytes = fs::read(place.root().join(file))?;
        if file == Path::new("Cargo.toml") {
            bytes = of_the_copy(&bytes)?;
        }
        let to = tree.join(file);
        if fs::read(&to).is_ok_and(|present| present == bytes) {
            continue;
        }
        fs::create_dir_all(to.parent().unwrap_or(tree))?;
        fs::write(to, bytes)?;
    }
    Ok(())
}

/// The manifest of the workspace with the version of the copy. Few tests of many builds run there: without optimisation both are sooner done.
fn of_the_copy(manifest: &[u8]) -> io::Result<Vec<u8>> {
    let [ours, of_copy] = VERSION;
    let manifest = String::from_utf8_lossy(manifest);
    if manifest.matches(ours).count() != 1 {
        return Err(io::Error::other(format!(
            "Cargo.toml must have one line{}: the copy needs a version of its own, change it in recipes.rs too",
            ours.trim_end()
        )));
    }
    let copy = manifest.replace(ours, of_copy);
    Ok(copy.replace("opt-level = 2", "opt-level = 0").into_bytes())
}

/// Removes the files that are not in the list, such as those that a patch brought.
fn remove_others(tree: &Path, folder: &Path, files: &BTreeSet<PathBuf>) -> io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let entry = entry?;
        let path = entry.path();
        if entry.file_type()?.is_dir() {
            remove_others(tree, &path, files)?;
        } else if !path
            .strip_prefix(tree)
            .is_ok_and(|name| files.contains(name))
        {
            fs::remove_file(path)?;
        }
    }
    Ok(())
}

/// The names of the patches in a folder.
fn names(folder: &Path) -> Result<Vec<String>, Error> {
    let list = || -> io::Result<Vec<String>> {
        let mut names = Vec::new();
        for entry in fs::read_dir(folder)? {
            let name = entry?.file_name().to_string_lossy().into_owned();
            names.extend(name.strip_suffix(".patch").map(str::to_owned));
        }
        names.sort_unstable();
        Ok(names)
    };
    list().map_err(|reason| Error::Source {
        path: folder.into(),
        reason: reason.to_string(),
    })
}

/// What is wrong between the patches and the table.
fn unpaired(patches: &[String]) -> Vec<String> {
    let without_row = patches
        .iter()
        .filter(|name| RECIPES.iter().all(|recipe| recipe.name != **name))
        .map(|name| {
            format!(
                "{PATCHES}/{name}.patch has no checks: give it a row in xtask/src/ci/recipes.rs"
            )
        });
    let without_patch = RECIPES
        .iter()
        .filter(|recipe| patches.iter().all(|name| recipe.name != name))
        .map(|recipe| {
            format!(
                "there is no {PATCHES}/{}.patch: follow the recipe and save it",
                recipe.name
            )
        });
    without_row.chain(without_patch).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_patch_has_its_checks_and_each_row_its_patch() {
        let place = Place::find(false).unwrap();
        let mut patches = names(&place.root().join(PATCHES)).unwrap();
        assert_eq!(unpaired(&patches), [""; 0]);
        patches.push("engine".into());
        assert!(unpaired(&patches)[0].contains("engine.patch has no checks"));
        patches.retain(|name| name != "engine" && name != "board");
        assert!(unpaired(&patches)[0].contains("no docs/recipes/board.patch"));
    }

    #[test]
    fn the_copy_has_a_version_of_its_own_or_is_refused() {
        let manifest = b"[workspace.package]\nversion = \"0.1.0\"\n[dependencies]\n";
        let copy = of_the_copy(manifest).unwrap();
        assert_eq!(
            copy,
            b"[workspace.package]\nversion = \"0.1.999\"\n[dependencies]\n"
        );
        assert!(of_the_copy(&copy).is_err());
        let place = Place::find(false).unwrap();
        let ours = fs::read(place.root().join("Cargo.toml")).unwrap();
        assert!(of_the_copy(&ours).is_ok());
    }

    #[test]
    fn the_copy_is_the_tracked_tree_and_a_patch_changes_it_or_is_refused() {
        let place = Place::find(false).unwrap();
        let folder = place
            .target()
            .join("tmp")
            .join(format!("recipes-{}", std::process::id()));
        let tree = folder.join("tree");
        refresh(&place, &tree).unwrap();
        let page = tree.join("ARCHITECTURE.md");
        let before = fs::read_to_string(&page).unwrap();
        let lines: Vec<&str> = before.lines().take(3).collect();
        let [first, second, third] = lines[..] else {
            panic!("a page of three lines");
        };
        let patch = folder.join("one.patch");
        let text = format!(
            "--- a/ARCHITECTURE.md\n+++ b/ARCHITECTURE.md\n@@ -1,3 +1,3 @@\n-{first}\n+other\n {second}\n {third}\n--- /dev/null\n+++ b/new\n@@ -0,0 +1 @@\n+new\n"
        );
        fs::write(&patch, text).unwrap();
        apply(&place, &patch, &tree).unwrap();
        assert!(fs::read_to_string(&page).unwrap().starts_with("other\n"));
        assert!(apply(&place, &patch, &tree).is_err());
        refresh(&place, &tree).unwrap();
        assert_eq!(fs::read_to_string(&page).unwrap(), before);
        assert!(!tree.join("new").exists());
        fs::remove_dir_all(folder).unwrap();
    }
}
