//! The harness notices a damaged vector, and exactly that one.

use std::fs;
use std::path::{Path, PathBuf};

use host_tests::{
    Report, dyn_can_rejects, dyn_can_replies, dyn_can_requests, dyn_serial, dyn_units, vectors_dir,
    zlac_misc, zlac_sdo,
};
use serde_json::Value;

/// A folder for one damaged file; removed when dropped.
struct TemporaryFolder(PathBuf);

impl TemporaryFolder {
    fn new(test: &str) -> Self {
        let path =
            std::env::temp_dir().join(format!("damaged-vectors-{test}-{}", std::process::id()));
        fs::create_dir_all(&path).expect("the temporary folder can be created");
        Self(path)
    }

    fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for TemporaryFolder {
    fn drop(&mut self) {
        // A folder that stays behind does no harm.
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// Writes a copy of `file` after `damage` did its work on one vector, the last that has data where vectors have data; returns its id.
fn damage_one(folder: &TemporaryFolder, file: &str, damage: impl Fn(&mut Value)) -> String {
    let text = fs::read_to_string(vectors_dir().join(file)).expect("the vector file is readable");
    let mut vectors: Vec<Value> = serde_json::from_str(&text).expect("the vector file is a list");
    let has_data = |vector: &&mut Value| vector.get("data").is_none_or(|data| data != "");
    let vector = vectors
        .iter_mut()
        .rev()
        .find(has_data)
        .expect("a vector with data");
    damage(vector);
    let id = vector["id"]
        .as_str()
        .expect("every vector has an id")
        .to_owned();
    let text = serde_json::to_string(&vectors).expect("the list can be written");
    fs::write(folder.path().join(file), text).expect("the copy can be written");
    id
}

/// Changes the lowest bit of the last byte of a text of hexadecimal digits.
fn flip_last_bit(data: &mut Value) {
    let mut text = data.as_str().expect("data is a text").to_owned();
    let last = text
        .pop()
        .and_then(|digit| digit.to_digit(16))
        .expect("the chosen vector has data");
    text.push(char::from_digit(last ^ 1, 16).expect("one bit changed keeps one digit"));
    *data = text.into();
}

fn expect_exactly(report: &Report, id: &str) {
    let ids: Vec<&str> = report
        .failures
        .iter()
        .map(|failure| failure.id.as_str())
        .collect();
    assert_eq!(ids, [id], "{report}");
    assert!(report.checked > 1, "the other vectors were checked too");
}

#[test]
fn a_changed_byte_of_a_request_is_reported() {
    let folder = TemporaryFolder::new("request");
    let id = damage_one(&folder, dyn_can_requests::FILE, |vector| {
        flip_last_bit(&mut vector["data"])
    });
    expect_exactly(&dyn_can_requests::check(folder.path()), &id);
}

#[test]
fn a_changed_byte_of_a_reply_is_reported() {
    let folder = TemporaryFolder::new("reply");
    let id = damage_one(&folder, dyn_can_replies::FILE, |vector| {
        flip_last_bit(&mut vector["data"])
    });
    expect_exactly(&dyn_can_replies::check(folder.path()), &id);
}

#[test]
fn a_damaged_vector_of_the_hub_motor_drive_is_reported() {
    let folder = TemporaryFolder::new("zlac");
    let id = damage_one(&folder, zlac_sdo::FILE, |vector| {
        vector["code"] = "remote".into();
    });
    expect_exactly(&zlac_sdo::check(folder.path()), &id);
    let id = damage_one(&folder, zlac_sdo::FILE, |vector| {
        vector["unheard_of"] = 1.into()
    });
    expect_exactly(&zlac_sdo::check(folder.path()), &id);
    let id = damage_one(&folder, zlac_misc::FILE, |vector| {
        vector["names"] = Value::Array(vec!["gremlin".into()]);
    });
    expect_exactly(&zlac_misc::check(folder.path()), &id);
}

#[test]
fn a_changed_byte_of_a_serial_stream_is_reported() {
    let folder = TemporaryFolder::new("serial");
    let id = damage_one(&folder, dyn_serial::FILE, |vector| {
        flip_last_bit(&mut vector["stream"])
    });
    expect_exactly(&dyn_serial::check(folder.path()), &id);
}

#[test]
fn another_code_of_a_refusal_is_reported() {
    let folder = TemporaryFolder::new("reject");
    let id = damage_one(&folder, dyn_can_rejects::FILE, |vector| {
        let other = if vector["code"] == "range" {
            "length"
        } else {
            "range"
        };
        vector["code"] = other.into();
    });
    expect_exactly(&dyn_can_rejects::check(folder.path()), &id);
}

#[test]
fn an_unknown_field_is_reported_not_skipped() {
    let folder = TemporaryFolder::new("field");
    let id = damage_one(&folder, dyn_units::FILE, |vector| {
        vector["unheard_of"] = 1.into()
    });
    expect_exactly(&dyn_units::check(folder.path()), &id);
}

#[test]
fn unknown_commands_options_codes_and_stages_are_reported_not_skipped() {
    let folder = TemporaryFolder::new("words");
    let id = damage_one(&folder, dyn_can_requests::FILE, |vector| {
        vector["command"] = "Go_Home".into()
    });
    expect_exactly(&dyn_can_requests::check(folder.path()), &id);
    let id = damage_one(&folder, dyn_can_requests::FILE, |vector| {
        vector["options"]["mood"] = "good".into()
    });
    expect_exactly(&dyn_can_requests::check(folder.path()), &id);
    let id = damage_one(&folder, dyn_can_rejects::FILE, |vector| {
        vector["code"] = "because".into()
    });
    expect_exactly(&dyn_can_rejects::check(folder.path()), &id);
    let id = damage_one(&folder, dyn_can_rejects::FILE, |vector| {
        vector["stage"] = "dream".into()
    });
    expect_exactly(&dyn_can_rejects::check(folder.path()), &id);
    let id = damage_one(&folder, dyn_units::FILE, |vector| {
        vector["kind"] = "phlogiston".into()
    });
    expect_exactly(&dyn_units::check(folder.path()), &id);
}

#[test]
fn a_missing_and_an_empty_file_are_failures() {
    let folder = TemporaryFolder::new("file");
    let missing = dyn_can_replies::check(folder.path());
    assert_eq!(missing.failures.len(), 1, "{missing}");
    for text in ["", "[]", "{}"] {
        fs::write(folder.path().join(dyn_can_replies::FILE), text)
            .expect("the copy can be written");
        let empty = dyn_can_replies::check(folder.path());
        assert_eq!(empty.failures.len(), 1, "{text:?}: {empty}");
    }
}

#[test]
fn an_id_that_occurs_twice_is_reported() {
    let folder = TemporaryFolder::new("twice");
    let text = fs::read_to_string(vectors_dir().join(dyn_units::FILE))
        .expect("the vector file is readable");
    let mut vectors: Vec<Value> = serde_json::from_str(&text).expect("the vector file is a list");
    vectors.push(vectors[0].clone());
    let text = serde_json::to_string(&vectors).expect("the list can be written");
    fs::write(folder.path().join(dyn_units::FILE), text).expect("the copy can be written");
    expect_exactly(
        &dyn_units::check(folder.path()),
        vectors[0]["id"].as_str().expect("every vector has an id"),
    );
}
