//! Lists of drive ids on the command line.

use dyn_can::{DriveId, StoredDriveId};

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
    let mut ids = Vec::new();
    for part in text.split(',') {
        let (first, last) = part.split_once('-').unwrap_or((part, part));
        let (first, last) = (drive_id(first.trim())?, drive_id(last.trim())?);
        if last < first {
            return Err(format!("the range {part} runs backwards"));
        }
        ids.extend(DriveId::all().filter(|id| (first..=last).contains(id)));
    }
    for (place, id) in ids.iter().enumerate() {
        if ids[..place].contains(id) {
            return Err(format!("drive {id} is listed twice"));
        }
    }
    Ok(ids)
}

/// The ids for a message, as in `1, 2, 5`.
pub(crate) fn list(drives: &[DriveId]) -> String {
    let numbers: Vec<String> = drives.iter().map(ToString::to_string).collect();
    numbers.join(", ")
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
}
