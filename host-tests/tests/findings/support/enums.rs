//! Variants of the enums of the master, read from its source, wherever it is.

use std::path::{Path, PathBuf};

fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder of the crate") {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

/// Names of the variants of the first enum with one of these names.
pub(crate) fn variants(names: &[&str]) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/can-motion/src");
    let mut files = Vec::new();
    sources(&root, &mut files);
    for file in files {
        let source = std::fs::read_to_string(&file).expect("a source");
        let head = names
            .iter()
            .find_map(|name| source.find(&format!("pub enum {name} {{")));
        let Some(start) = head else { continue };
        let body = &source[start..];
        let body = &body[..body.find("\n}").expect("end of the enum")];
        return body.lines().skip(1).filter_map(variant).collect();
    }
    panic!("no enum {names:?} in {}", root.display());
}

fn variant(line: &str) -> Option<String> {
    let word = line.strip_prefix("    ")?;
    let name: String = word
        .chars()
        .take_while(char::is_ascii_alphanumeric)
        .collect();
    word.starts_with(|c: char| c.is_ascii_uppercase())
        .then_some(name)
}

/// The name of a variant by its text for debugging.
pub(crate) fn name_of(fault: &impl core::fmt::Debug) -> String {
    let text = format!("{fault:?}");
    text.chars()
        .take_while(char::is_ascii_alphanumeric)
        .collect()
}
