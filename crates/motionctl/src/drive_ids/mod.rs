//! Lists of drive ids on the command line.

use core::fmt;

use dyn_can::{DriveId, StoredDriveId};
use zlac8030l::NodeId;

/// A drive id.
pub(crate) fn drive_id(text: &str) -> Result<DriveId, String> {
    let number: i32 = text.parse().map_err(|_| "expected a number".to_owned())?;
    DriveId::new(number).map_err(|error| error.to_string())
}

/// The id of a drive as it is stored: 0 is a drive that was never given one, which has an address on its serial port only.
pub(crate) fn stored_id(text: &str) -> Result<StoredDriveId, String> {
    let number: i32 = text.parse().map_err(|_| "expected a number".to_owned())?;
    StoredDriveId::new(number).map_err(|error| error.to_string())
}

/// Numbers and ranges of drive ids, as in `1,2,5-7`: at least one, each once, in the order given.
pub(crate) fn drive_ids(text: &str) -> Result<Vec<DriveId>, String> {
    id_list(text, "drive", drive_id, DriveId::all)
}

/// The same with 0, the id of a drive that was never given one.
pub(crate) fn stored_ids(text: &str) -> Result<Vec<StoredDriveId>, String> {
    let all = || (0..=63).filter_map(|id| StoredDriveId::new(id).ok());
    id_list(text, "drive", stored_id, all)
}

/// The ids for a message, as in `1, 2, 5`.
pub(crate) fn list(drives: &[DriveId]) -> String {
    let numbers: Vec<String> = drives.iter().map(ToString::to_string).collect();
    numbers.join(", ")
}

/// What is said of drives, in the right number, as in `drive 1 is on` and `drives 1, 2 are on`.
pub(crate) fn about(drives: &[DriveId], one: &str, many: &str) -> String {
    match drives {
        [drive] => format!("drive {drive} {one}"),
        drives => format!("drives {} {many}", list(drives)),
    }
}

/// The drives of a motion: of which family, and which ones.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum DriveSet {
    /// DYN servo drives.
    Dyn(Vec<DriveId>),
    /// ZLAC8030L hub-motor drives; none: as many as there are columns, from the factory's node on.
    Zlac(Vec<NodeId>),
}

/// Drive ids as in `9,1-3`, or hub motors as in `zlac` and `zlac:4,5`.
pub(crate) fn drive_set(text: &str) -> Result<DriveSet, String> {
    match text.strip_prefix("zlac") {
        None => drive_ids(text).map(DriveSet::Dyn),
        Some("") => Ok(DriveSet::Zlac(Vec::new())),
        Some(rest) => {
            let nodes = rest
                .strip_prefix(':')
                .ok_or("expected zlac or zlac:NODES")?;
            id_list(nodes, "node", node_id, NodeId::all).map(DriveSet::Zlac)
        }
    }
}

fn node_id(text: &str) -> Result<NodeId, String> {
    let number: i32 = text.parse().map_err(|_| "expected a number".to_owned())?;
    NodeId::new(number).map_err(|error| error.to_string())
}

/// Numbers and ranges, at least one, each once, in the order given.
fn id_list<T: Copy + PartialOrd + fmt::Display, I: Iterator<Item = T>>(
    text: &str,
    what: &str,
    parse: impl Fn(&str) -> Result<T, String>,
    all: impl Fn() -> I,
) -> Result<Vec<T>, String> {
    let mut ids = Vec::new();
    for part in text.split(',') {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        let (first, last) = (parse(first.trim())?, parse(last.trim())?);
        if last < first {
            return Err(format!("the range {part} runs backwards"));
        }
        ids.extend(all().filter(|id| (first..=last).contains(id)));
    }
    for (place, id) in ids.iter().enumerate() {
        if ids[..place].contains(id) {
            return Err(format!("{what} {id} is listed twice"));
        }
    }
    Ok(ids)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_ranges_in_any_order() {
        let numbers =
            |text| drive_ids(text).map(|ids| ids.iter().map(|id| id.get()).collect::<Vec<_>>());
        assert_eq!(numbers("3"), Ok(vec![3]));
        assert_eq!(numbers("9, 1-3,5"), Ok(vec![9, 1, 2, 3, 5]));
        assert_eq!(numbers("1-2,2").unwrap_err(), "drive 2 is listed twice");
        assert_eq!(numbers("3-1").unwrap_err(), "the range 3-1 runs backwards");
        for wrong in ["", "0", "64", "1-", "a", "1,,2", "-1"] {
            assert!(numbers(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn hub_motors_are_named_by_their_family() {
        let nodes = |text| match drive_set(text) {
            Ok(DriveSet::Zlac(nodes)) => Some(nodes.iter().map(|node| node.get()).collect()),
            _ => None,
        };
        assert_eq!(nodes("zlac"), Some(vec![]));
        assert_eq!(nodes("zlac:9,4-5"), Some(vec![9, 4, 5]));
        for wrong in ["zlac:", "zlac:0", "zlac:128", "zlac4", "zlac:4,4", "3"] {
            assert_eq!(nodes(wrong), None::<Vec<u8>>, "{wrong}");
        }
    }
}
