//! Field types that several vector files share.

use dyn_can::{Address, DataFrame, DriveId, FrameError, FunctionCode, RangeError, Revision};
use serde::{Deserialize, Deserializer, de};

use crate::report::{Mismatch, same};

/// Revision of the CAN specification, as printed in the vectors.
#[derive(Debug, Clone, Copy, Deserialize)]
pub enum RevisionField {
    /// 1.2A of 2018.
    #[serde(rename = "1.2A")]
    V1_2A,
    /// 1.6A of 2026.
    #[serde(rename = "1.6A")]
    V1_6A,
}

impl From<RevisionField> for Revision {
    fn from(field: RevisionField) -> Self {
        match field {
            RevisionField::V1_2A => Self::V1_2A,
            RevisionField::V1_6A => Self::V1_6A,
        }
    }
}

/// Bytes printed as pairs of hexadecimal digits without separators.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct HexBytes(pub Vec<u8>);

impl HexBytes {
    /// The bytes of a text such as `f830`; `None` when it is not pairs of hexadecimal digits.
    pub fn parse(text: &str) -> Option<Self> {
        let digits: Vec<u8> = text
            .chars()
            .map(|digit| digit.to_digit(16).map(|digit| digit as u8))
            .collect::<Option<_>>()?;
        let (pairs, rest) = digits.as_chunks::<2>();
        rest.is_empty()
            .then(|| Self(pairs.iter().map(|[high, low]| high << 4 | low).collect()))
    }
}

impl<'de> Deserialize<'de> for HexBytes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = String::deserialize(deserializer)?;
        Self::parse(&text).ok_or_else(|| {
            de::Error::custom(format!("{text:?} is not pairs of hexadecimal digits"))
        })
    }
}

/// A command by the name that the documents print.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Command(pub FunctionCode);

impl<'de> Deserialize<'de> for Command {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        let function = FunctionCode::ALL
            .into_iter()
            .find(|function| function.name() == name);
        function
            .map(Self)
            .ok_or_else(|| de::Error::custom(format!("unknown command {name:?}")))
    }
}

/// What the outstanding General_Read asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum What {
    /// Selector 1B.
    Position,
    /// Selector 1E.
    Torque,
}

/// What the receiver of a reply knows beside the frame.
#[derive(Debug, Clone, Copy, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Context {
    /// The selector of the outstanding General_Read.
    #[serde(default)]
    pub what: Option<What>,
}

/// The address that a vector's `drive_id` stands for; 0 is broadcast.
///
/// # Errors
/// [`RangeError`] for a number that is no drive.
pub fn address(drive_id: i32) -> Result<Address, RangeError> {
    match drive_id {
        0 => Ok(Address::Broadcast),
        id => DriveId::new(id).map(Address::Drive),
    }
}

/// A data frame as a vector prints it, with the redundant fields checked against each other.
///
/// # Errors
/// [`Mismatch`] when the vector contradicts itself or is not a frame of the drives.
pub fn data_frame(can_id: u32, dlc: usize, data: &HexBytes) -> Result<DataFrame, Mismatch> {
    same("dlc", &dlc, &data.0.len())?;
    DataFrame::from_parts(can_id, false, false, &data.0)
        .map_err(|error: FrameError| Mismatch::unreadable(error))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_whole_bytes_are_hexadecimal() {
        assert_eq!(HexBytes::parse("f830"), Some(HexBytes(vec![0xF8, 0x30])));
        assert_eq!(HexBytes::parse(""), Some(HexBytes(vec![])));
        assert_eq!(HexBytes::parse("f83"), None);
        assert_eq!(HexBytes::parse("+1"), None);
    }
}
