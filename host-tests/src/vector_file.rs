//! Reading a vector file, one vector at a time, so that a vector that cannot be read is reported by its id.

use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value};

use crate::report::{Failure, Mismatch, Report};

/// Environment variable that names another folder of vectors.
pub const VECTORS_DIR: &str = "VECTORS_DIR";

/// The folder named by [`VECTORS_DIR`], otherwise `vectors` in this package. Cargo runs tests in the folder of their package, so a
/// relative path counts from there.
pub fn vectors_dir() -> PathBuf {
    std::env::var_os(VECTORS_DIR).map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("vectors"),
        PathBuf::from,
    )
}

/// The fields that every vector of every file has.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Label {
    id: String,
    name: String,
    #[serde(rename = "group")]
    _group: String,
    #[serde(rename = "source")]
    _source: String,
    #[serde(rename = "note", default)]
    _note: Option<String>,
}

const LABEL_FIELDS: [&str; 5] = ["id", "name", "group", "source", "note"];

/// Reads `file` in `dir` and checks each of its vectors with `check`.
pub fn check_file<T: DeserializeOwned>(
    dir: &Path,
    file: &str,
    check: impl Fn(T) -> Result<(), Mismatch>,
) -> Report {
    let mut report = Report {
        file: file.into(),
        checked: 0,
        failures: Vec::new(),
    };
    let vectors = match read(&dir.join(file)) {
        Ok(vectors) => vectors,
        Err(reason) => {
            report
                .failures
                .push(failure(file, "whole file", Mismatch::unreadable(reason)));
            return report;
        }
    };
    let mut ids = HashSet::new();
    for (index, vector) in vectors.into_iter().enumerate() {
        report.checked += 1;
        if let Err(found) = check_one(vector, &mut ids, &check) {
            report.failures.push(found.unwrap_or_else(|mismatch| {
                failure(
                    &format!("{file}[{index}]"),
                    "vector without a readable label",
                    mismatch,
                )
            }));
        }
    }
    report
}

/// The vectors of a file, at least one.
fn read(path: &Path) -> Result<Vec<Map<String, Value>>, String> {
    let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
    let vectors: Vec<Map<String, Value>> =
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    if vectors.is_empty() {
        return Err(format!("{}: the list of vectors is empty", path.display()));
    }
    Ok(vectors)
}

/// The outer error is a failure; it lacks the label when the label itself cannot be read.
fn check_one<T: DeserializeOwned>(
    mut vector: Map<String, Value>,
    ids: &mut HashSet<String>,
    check: impl Fn(T) -> Result<(), Mismatch>,
) -> Result<(), Result<Failure, Mismatch>> {
    let label: Label = parse(take(&mut vector, &LABEL_FIELDS)).map_err(Err)?;
    let result = if ids.insert(label.id.clone()) {
        parse(vector).and_then(check)
    } else {
        Err(Mismatch::unreadable("this id occurs twice"))
    };
    result.map_err(|mismatch| Ok(failure(&label.id, &label.name, mismatch)))
}

fn take(vector: &mut Map<String, Value>, fields: &[&str]) -> Map<String, Value> {
    fields
        .iter()
        .filter_map(|field| vector.remove_entry(*field))
        .collect()
}

fn parse<T: DeserializeOwned>(fields: Map<String, Value>) -> Result<T, Mismatch> {
    serde_json::from_value(Value::Object(fields)).map_err(Mismatch::unreadable)
}

fn failure(id: &str, name: &str, mismatch: Mismatch) -> Failure {
    Failure {
        id: id.into(),
        name: name.into(),
        expected: mismatch.expected,
        actual: mismatch.actual,
    }
}
