//! `docs/master.md` names every state, fault, event and error of the master.

use std::path::Path;

/// Names of the variants of an enum, read from its source.
fn variants(source: &str, name: &str) -> Vec<String> {
    // With or without type parameters.
    let start = [format!("pub enum {name} {{"), format!("pub enum {name}<")]
        .iter()
        .find_map(|head| source.find(head))
        .unwrap_or_else(|| panic!("enum {name}"));
    let body = &source[start..];
    let body = &body[..body.find("\n}").expect("end of the enum")];
    let names = body.lines().skip(1).filter_map(|line| {
        let word = line.strip_prefix("    ")?;
        let name: String = word
            .chars()
            .take_while(char::is_ascii_alphanumeric)
            .collect();
        word.starts_with(|c: char| c.is_ascii_uppercase())
            .then_some(name)
    });
    names.collect()
}

#[test]
fn every_state_fault_event_and_error_is_in_the_docs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the workspace");
    let read = |path: &str| std::fs::read_to_string(root.join(path)).expect(path);
    let docs = read("docs/master.md");
    let mut missing = Vec::new();
    let mut found = 0;
    for (file, name, prefix) in [
        ("life", "AxisState", ""),
        ("fault", "Fault", ""),
        ("event", "EventKind", ""),
        ("command", "CommandError", "CommandError::"),
        ("command", "TargetError", "TargetError::"),
        ("config", "ConfigError", "ConfigError::"),
        ("procedure/error", "ProcedureError", "ProcedureError::"),
    ] {
        let source = read(&format!("crates/can-motion/src/{file}.rs"));
        for variant in variants(&source, name) {
            found += 1;
            let entry = format!("{prefix}{variant}");
            let in_table =
                docs.contains(&format!("| {entry} |")) || docs.contains(&format!("| `{entry}` |"));
            if !in_table {
                missing.push(format!("{name}::{variant}"));
            }
        }
    }
    assert!(found > 60, "only {found} variants found: the sources moved");
    assert!(
        missing.is_empty(),
        "docs/master.md lacks a row for {missing:?}"
    );
}
