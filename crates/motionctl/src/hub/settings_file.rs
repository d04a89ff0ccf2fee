//! The objects of drives in a file: what `backup` writes and `restore` reads.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;
use toml::value::Datetime;
use zlac8030l::NodeId;

use super::object::{ObjectSetting, object};
use super::read::Value;
use crate::settings_file::Origin;

/// The layout that this tool writes and reads.
const FORMAT: i64 = 1;
/// The family that the file is for.
const FAMILY: &str = "zlac";
/// Larger than any file of 127 drives.
const MOST_BYTES: u64 = 4 << 20;

const BEGIN: &str = "\
# Objects of ZLAC8030L hub motors. `motionctl restore --drives zlac` compares them with the drives and writes only what differs.
# Each number is the one that the drive holds; behind it are its name in the guide and its unit. Node number and bit rate are left out:
# `motionctl assign-id --drives zlac` sets them.
";

/// The objects of one drive.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct NodeSettings {
    pub(super) node: NodeId,
    pub(super) settings: Vec<ObjectSetting>,
}

/// The text of a file.
pub(super) fn write(origin: &Origin, drives: &[(NodeId, u16, Vec<Value>)]) -> String {
    let Origin { tool, date } = origin;
    let mut text = format!(
        "{BEGIN}\nformat = {FORMAT}\nfamily = \"{FAMILY}\"\ntool = \"{tool}\"\ndate = {date}\n"
    );
    for (node, software, values) in drives {
        // A text takes whatever is written to it.
        let _ = writeln!(
            text,
            "\n[[drive]]\nnode = {node}\nsoftware = 0x{software:04X}\n[drive.objects]"
        );
        for value in values {
            let _ = writeln!(text, "{}", line(value));
        }
    }
    text
}

fn line(value: &Value) -> String {
    let unit = value.unit();
    let unit = if unit.is_empty() {
        String::new()
    } else {
        format!(", {unit}")
    };
    format!(
        "\"{}\" = {}  # {}{unit}",
        value.object, value.value, value.name
    )
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileText {
    format: Spanned<i64>,
    family: Option<Spanned<String>>,
    #[serde(rename = "tool")]
    _tool: Option<String>,
    #[serde(rename = "date")]
    _date: Option<Datetime>,
    #[serde(default)]
    drive: Vec<DriveText>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct DriveText {
    node: Spanned<i64>,
    #[serde(rename = "software")]
    _software: Option<i64>,
    objects: BTreeMap<Spanned<String>, Spanned<i64>>,
}

/// The text of a file.
///
/// # Errors
/// Why it cannot be read.
pub(super) fn read(path: &Path) -> Result<String, String> {
    use io::Read as _;
    let cannot = |source: io::Error| format!("cannot read {}: {source}", path.display());
    let mut text = String::new();
    let file = std::fs::File::open(path).map_err(cannot)?;
    file.take(MOST_BYTES + 1)
        .read_to_string(&mut text)
        .map_err(cannot)?;
    if text.len() as u64 > MOST_BYTES {
        return Err(format!(
            "{}: expected a file of at most {MOST_BYTES} bytes",
            path.display()
        ));
    }
    Ok(text)
}

/// The drives of a file.
///
/// # Errors
/// What is wrong, and where: line, expected, actual, what to do.
pub(super) fn parse(text: &str) -> Result<Vec<NodeSettings>, String> {
    let at = |offset: usize, what: String| {
        let before = text.get(..offset).unwrap_or(text);
        let line = before.matches('\n').count() + 1;
        format!("line {line}: {what}")
    };
    if is_of_servos(text) {
        return Err(
            "the file is of servo drives: use `motionctl restore` without --drives zlac".to_owned(),
        );
    }
    let file: FileText = toml::from_str(text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start);
        at(start, error.message().to_owned())
    })?;
    if *file.format.get_ref() != FORMAT {
        let what = format!("format must be {FORMAT}, got {}", file.format.get_ref());
        return Err(at(file.format.span().start, what));
    }
    match &file.family {
        Some(family) if family.get_ref() == FAMILY => {}
        Some(family) => {
            let what = format!("family must be \"{FAMILY}\", got \"{}\"", family.get_ref());
            return Err(at(family.span().start, what));
        }
        None => {
            return Err(format!(
                "family = \"{FAMILY}\" is missing: this is no backup of hub motors"
            ));
        }
    }
    let mut drives: Vec<NodeSettings> = Vec::new();
    for drive in &file.drive {
        let node = node_of(&drive.node).map_err(|what| at(drive.node.span().start, what))?;
        if drives.iter().any(|other| other.node == node) {
            let what = format!("node {node} is there twice: leave one");
            return Err(at(drive.node.span().start, what));
        }
        let mut settings = Vec::new();
        for (name, value) in &drive.objects {
            let setting = object(name.get_ref())
                .and_then(|entry| ObjectSetting::new(entry, *value.get_ref()))
                .map_err(|what| at(name.span().start, what))?;
            let same = |other: &ObjectSetting| other.entry.address == setting.entry.address;
            if settings.iter().any(same) {
                let what = format!(
                    "{} is there twice under two names: leave one",
                    name.get_ref()
                );
                return Err(at(name.span().start, what));
            }
            settings.push(setting);
        }
        settings.sort_by_key(|setting| setting.entry.address);
        drives.push(NodeSettings { node, settings });
    }
    if drives.is_empty() {
        return Err("the file has no [[drive]]: nothing to restore".to_owned());
    }
    Ok(drives)
}

fn node_of(number: &Spanned<i64>) -> Result<NodeId, String> {
    let number = i32::try_from(*number.get_ref()).unwrap_or(i32::MAX);
    NodeId::new(number).map_err(|error| error.to_string())
}

/// A file of servo drives has ids and no family.
fn is_of_servos(text: &str) -> bool {
    let table: Result<toml::Table, _> = text.parse();
    table.is_ok_and(|table| {
        let drives = table.get("drive").and_then(|drives| drives.as_array());
        let first = drives.and_then(|drives| drives.first());
        !table.contains_key("family") && first.is_some_and(|drive| drive.get("id").is_some())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "format = 1\nfamily = \"zlac\"\n[[drive]]\nnode = 4\n[drive.objects]\n\"2014h:00\" = 120\n\"2011h:00\" = -5\n";

    #[test]
    fn a_file_gives_its_drives_in_the_order_of_addresses() {
        let drives = parse(FILE).unwrap();
        assert_eq!(drives.len(), 1);
        let settings: Vec<String> = drives[0].settings.iter().map(ToString::to_string).collect();
        assert_eq!(settings, ["2011h:00 = -5", "2014h:00 = 120"]);
    }

    #[test]
    fn wrong_files_say_where_and_what() {
        let broken = |from: &str, to: &str| {
            assert!(FILE.contains(from));
            parse(&FILE.replace(from, to)).expect_err(to)
        };
        for (from, to, words) in [
            (
                "120",
                "151",
                "line 6: 2014h:00 (rated current) must be 0..=150, got 151",
            ),
            ("120", "\"a\"", "line 6"),
            (
                "2014h:00",
                "2024h:00",
                "line 6: the dictionary has no object 2024h:00",
            ),
            ("2014h:00", "200Dh", "line 6: 200Dh:00"),
            ("2014h:00", "60FFh", "could move the motor"),
            ("2014h:00", "2011h", "twice under two names"),
            ("node = 4", "node = 128", "line 4"),
            ("node = 4", "nodes = 4", "line 4: unknown field `nodes`"),
            (
                "format = 1",
                "format = 2",
                "line 1: format must be 1, got 2",
            ),
            (
                "\"zlac\"",
                "\"dyn\"",
                "line 2: family must be \"zlac\", got \"dyn\"",
            ),
            ("family = \"zlac\"\n", "", "is missing"),
            ("[[drive]]", "[[drives]]", "line 5"),
            ("format = 1", "format", "line 1"),
        ] {
            let error = broken(from, to);
            assert!(error.contains(words), "{to}: {error}");
        }
        let twice = FILE.replace("[[drive]]", "[[drive]]\nnode = 4\nobjects = {}\n[[drive]]");
        assert!(
            parse(&twice)
                .expect_err("twice")
                .contains("node 4 is there twice")
        );
    }

    #[test]
    fn a_file_of_servo_drives_is_told_apart() {
        let servos = "format = 1\n[[drive]]\nid = 1\nmain-gain = 20\n";
        let error = parse(servos).expect_err("another family");
        assert!(error.contains("without --drives zlac"), "{error}");
    }
}
