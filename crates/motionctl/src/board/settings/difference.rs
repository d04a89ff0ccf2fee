//! What a file would change.

use core::fmt;

use board_settings::Settings;
use schemars::JsonSchema;
use serde::Serialize;

/// A value that differs.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub(super) struct Difference {
    /// The part of the file: a section, or the drive of an axis.
    part: String,
    key: String,
    before: Option<String>,
    after: Option<String>,
}

impl fmt::Display for Difference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let or_none = |value: &Option<String>| value.clone().unwrap_or_else(|| "-".to_owned());
        if !self.part.is_empty() {
            write!(f, "{}: ", self.part)?;
        }
        let (before, after) = (or_none(&self.before), or_none(&self.after));
        write!(f, "{}: {before} -> {after}", self.key)
    }
}

/// A value of the file with its place.
type Entry = ((String, String), String);

/// What differs, in the order of the file; of a board without settings everything.
pub(super) fn differences(before: Option<&Settings>, after: &Settings) -> Vec<Difference> {
    let (before, after) = (before.map(entries).unwrap_or_default(), entries(after));
    let of = |entries: &[Entry], place: &(String, String)| {
        let found = entries.iter().find(|(known, _)| known == place);
        found.map(|(_, value)| value.clone())
    };
    let gone = before
        .iter()
        .filter(|(place, _)| of(&after, place).is_none());
    let places = after.iter().chain(gone).map(|(place, _)| place);
    places
        .filter_map(|place| {
            let (before, after) = (of(&before, place), of(&after, place));
            let (part, key) = place.clone();
            (before != after).then_some(Difference {
                part,
                key,
                before,
                after,
            })
        })
        .collect()
}

/// The values of the file that these settings make.
fn entries(settings: &Settings) -> Vec<Entry> {
    let text = board_settings::file::write(settings);
    let (mut part, mut entries) = (String::new(), Vec::new());
    for line in text.lines() {
        if let Some(name) = line.strip_prefix('[') {
            part = name.trim_matches(['[', ']']).to_owned();
        }
        let Some((key, value)) = line.split_once(" = ").filter(|_| !line.starts_with('#')) else {
            continue;
        };
        if key == "drive" {
            // The axes have no other name.
            part = format!("drive {value}");
        }
        entries.push(((part.clone(), key.to_owned()), value.to_owned()));
    }
    entries
}

#[cfg(test)]
mod tests {
    use board_settings::{AxisSettings, BusSettings, Inputs, MotorLimits, Travel};

    use super::*;

    fn settings(speed_rpm: u32, drives: &[u8]) -> Settings {
        let limits = MotorLimits {
            speed_rpm,
            acceleration_rpm_per_s: 1_000,
        };
        let travel = Travel::Counts { min: -5, max: 5 };
        let axis = |&drive| AxisSettings::new(drive, 4_096, limits, travel);
        Settings {
            name: "a = b".parse().unwrap(),
            bus: BusSettings::new(1_000),
            inputs: Inputs::default(),
            axes: drives.iter().map(axis).collect(),
        }
    }

    #[test]
    fn what_differs_is_named_with_its_drive() {
        let same = differences(Some(&settings(100, &[1, 2])), &settings(100, &[1, 2]));
        assert_eq!(same, []);
        let speed = differences(Some(&settings(100, &[1, 2])), &settings(150, &[1, 2]));
        let text: Vec<String> = speed.iter().map(ToString::to_string).collect();
        assert_eq!(
            text,
            [
                "drive 1: speed_rpm: 100 -> 150",
                "drive 2: speed_rpm: 100 -> 150"
            ]
        );
        let gone = differences(Some(&settings(100, &[1, 2])), &settings(100, &[2]));
        assert!(
            gone.iter()
                .all(|one| one.part == "drive 1" && one.after.is_none())
        );
        let fresh = differences(None, &settings(100, &[1]));
        assert!(fresh.iter().all(|one| one.before.is_none()));
        assert!(fresh.iter().any(|one| one.part == "bus"));
    }
}
