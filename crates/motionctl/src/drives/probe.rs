//! What a drive shows of its byte orders.

use core::fmt;

use dyn_can::{ByteOrder, ParamGroup3};
use dyn_commission::Group3Readings;
use schemars::JsonSchema;
use serde::Serialize;

/// Gear and line number in one of the two orders.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
struct Reading {
    gear_number: u16,
    line_number: Option<u16>,
}

impl From<ParamGroup3> for Reading {
    fn from(group: ParamGroup3) -> Self {
        Self {
            gear_number: group.gear_number.get(),
            line_number: group.line_number.map(dyn_can::LineNumber::get),
        }
    }
}

/// The byte orders of a drive; an order that is not known is `None`.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub(crate) struct ProbeEnd {
    drive: u8,
    revision: String,
    /// Of signed numbers: positions, speeds, amplitudes.
    pub(crate) numbers: Option<&'static str>,
    /// Of gear and line number in the reply of parameter group 3.
    group3: Option<&'static str>,
    /// What this reply is with its most significant byte first, when that is legal.
    group3_msb_first: Option<Reading>,
    /// The same with its least significant byte first.
    group3_lsb_first: Option<Reading>,
}

impl ProbeEnd {
    pub(crate) fn new(drive: u8, numbers: Option<ByteOrder>, group3: &Group3Readings) -> Self {
        Self {
            drive,
            revision: group3.revision.to_string(),
            numbers: numbers.map(name),
            group3: group3.order().map(name),
            group3_msb_first: group3.msb_first.map(Reading::from),
            group3_lsb_first: group3.lsb_first.map(Reading::from),
        }
    }
}

/// The order in the words of `--group3-order`.
const fn name(order: ByteOrder) -> &'static str {
    match order {
        ByteOrder::MsbFirst => "msb-first",
        ByteOrder::LsbFirst => "lsb-first",
    }
}

impl fmt::Display for ProbeEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "drive {}, CAN {}", self.drive, self.revision)?;
        match self.numbers {
            Some("msb-first") => writeln!(
                f,
                "numbers: msb-first (it refuses 10 01 as 4097 and takes 01 10 as 272), as this tool sends them"
            )?,
            Some(order) => writeln!(
                f,
                "numbers: {order}. This tool sends the most significant byte first: MOVE NOTHING with this drive"
            )?,
            None => writeln!(
                f,
                "numbers: not known, it refuses both or none of 10 01 and 01 10. MOVE NOTHING with this drive until that is settled"
            )?,
        }
        f.write_str("group 3: ")?;
        match (self.group3, self.group3_msb_first, self.group3_lsb_first) {
            (Some(order), ..) => write!(f, "{order}, the other order gives no legal number"),
            (None, Some(msb), Some(lsb)) if msb == lsb => write!(
                f,
                "gear number {} in both orders: nothing to tell apart",
                msb.gear_number
            ),
            (None, Some(msb), Some(lsb)) => write!(
                f,
                "not known, its gear number is {} with msb-first and {} with lsb-first: see which the vendor's tool shows, then use --group3-order",
                msb.gear_number, lsb.gear_number
            ),
            _ => f.write_str("neither order gives legal numbers: read it with the vendor's tool"),
        }
    }
}
