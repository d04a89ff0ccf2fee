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

/// Fails when a page lacks a row for a variant of one of these enums: file, name, prefix in the page.
fn check(page: &str, at_least: usize, enums: &[(&str, &str, &str)]) {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("the workspace");
    let read = |path: &str| std::fs::read_to_string(root.join(path)).expect(path);
    let docs = read(page);
    // The first cell of each row may name several.
    let rows: Vec<&str> = docs
        .lines()
        .filter_map(|line| line.strip_prefix("| ")?.split(" |").next())
        .flat_map(|cell| cell.split(", "))
        .map(|entry| entry.trim_matches('`'))
        .collect();
    let mut missing = Vec::new();
    let mut found = 0;
    for (file, name, prefix) in enums {
        let source = read(&format!("crates/can-motion/src/{file}.rs"));
        for variant in variants(&source, name) {
            found += 1;
            if !rows.contains(&format!("{prefix}{variant}").as_str()) {
                missing.push(format!("{name}::{variant}"));
            }
        }
    }
    assert!(
        found >= at_least,
        "only {found} variants found: the sources moved"
    );
    assert!(missing.is_empty(), "{page} lacks a row for {missing:?}");
}

#[test]
fn every_state_fault_event_and_error_is_in_the_docs() {
    check(
        "docs/master.md",
        60,
        &[
            ("core/state", "AxisState", ""),
            ("servo/fault", "Fault", ""),
            ("servo/event", "EventKind", ""),
            ("core/command", "CommandError", "CommandError::"),
            ("core/command", "TargetError", "TargetError::"),
            ("servo/config/error", "ConfigError", "ConfigError::"),
            (
                "servo/procedure/error",
                "ProcedureError",
                "ProcedureError::",
            ),
        ],
    );
}

#[test]
fn everything_about_wheels_is_in_the_docs() {
    check(
        "docs/wheels.md",
        60,
        &[
            ("core/state", "AxisState", ""),
            ("wheel/fault", "WheelFault", ""),
            ("wheel/event", "WheelEventKind", ""),
            ("wheel/transfer", "TransferError", "TransferError::"),
            (
                "wheel/config/error",
                "WheelConfigError",
                "WheelConfigError::",
            ),
        ],
    );
}

#[test]
fn every_test_that_the_findings_name_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = std::fs::read_to_string(root.join("../docs/findings.md")).expect("docs/findings.md");
    let named: Vec<&str> = page
        .lines()
        .filter_map(|line| line.split("| `").nth(1)?.split('`').next())
        .collect();
    assert!(named.len() > 60, "only {} tests are named", named.len());
    for path in named {
        let (file, rest) = path.split_once("::").expect(path);
        let test = rest.rsplit("::").next().expect(path);
        let source = root.join(format!("tests/findings/{file}.rs"));
        let source = std::fs::read_to_string(&source).expect(path);
        // One of a macro is written `name: Stage`.
        let is_there =
            source.contains(&format!("fn {test}()")) || source.contains(&format!("{test}: "));
        assert!(is_there, "docs/findings.md names {path}, which is gone");
    }
}
