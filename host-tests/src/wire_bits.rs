//! `can_wire_bits.json`: exact length of a frame on the wire, for any implementation that computes a part of it.

use std::path::Path;

use serde::Deserialize;

use crate::frame_fields::HexBytes;
use crate::report::{Mismatch, Report, same};
use crate::vector_file::check_file;

/// The file name.
pub const FILE: &str = "can_wire_bits.json";

/// What an implementation says about one frame; `None` for what it does not compute.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct WireBits {
    /// CRC-15 over SOF to data.
    pub crc15: Option<u16>,
    /// Number of stuff bits.
    pub stuff_bits: Option<u32>,
    /// SOF to EOF and three bits of interframe space.
    pub bits_exact_with_ifs: Option<u32>,
    /// SOF to EOF.
    pub bits_exact_without_ifs: Option<u32>,
    /// Length with interframe space, not counting stuff bits.
    pub bits_unstuffed_with_ifs: Option<u32>,
    /// Upper bound of the length with interframe space, for any identifier and data of this length.
    pub bits_worst_with_ifs: Option<u32>,
    /// The bits from SOF to the last CRC bit with stuff bits, as `0` and `1`.
    pub sof_to_crc_stuffed: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Vector {
    can_id: u16,
    dlc: usize,
    data: HexBytes,
    crc15: u16,
    stuff_bits: u32,
    bits_exact_with_ifs: u32,
    bits_exact_without_ifs: u32,
    bits_unstuffed_with_ifs: u32,
    bits_worst_with_ifs: u32,
    sof_to_crc_stuffed: String,
}

/// Holds an implementation, from 11-bit identifier and data to [`WireBits`], against every vector.
pub fn check(dir: &Path, implementation: impl Fn(u16, &[u8]) -> WireBits) -> Report {
    check_file(dir, FILE, |vector| check_vector(vector, &implementation))
}

fn check_vector(
    vector: Vector,
    implementation: impl Fn(u16, &[u8]) -> WireBits,
) -> Result<(), Mismatch> {
    same("dlc", &vector.dlc, &vector.data.0.len())?;
    if vector.can_id > 0x7FF {
        return Err(Mismatch::unreadable(format!(
            "identifier 0x{:X} is beyond 11 bits",
            vector.can_id
        )));
    }
    let actual = implementation(vector.can_id, &vector.data.0);
    if actual == WireBits::default() {
        return Err(Mismatch::unreadable("the implementation computes nothing"));
    }
    computed("crc15", vector.crc15, actual.crc15)?;
    computed("stuff_bits", vector.stuff_bits, actual.stuff_bits)?;
    computed(
        "bits_exact_with_ifs",
        vector.bits_exact_with_ifs,
        actual.bits_exact_with_ifs,
    )?;
    computed(
        "bits_exact_without_ifs",
        vector.bits_exact_without_ifs,
        actual.bits_exact_without_ifs,
    )?;
    computed(
        "bits_unstuffed_with_ifs",
        vector.bits_unstuffed_with_ifs,
        actual.bits_unstuffed_with_ifs,
    )?;
    computed(
        "bits_worst_with_ifs",
        vector.bits_worst_with_ifs,
        actual.bits_worst_with_ifs,
    )?;
    computed(
        "sof_to_crc_stuffed",
        vector.sof_to_crc_stuffed,
        actual.sof_to_crc_stuffed,
    )
}

fn computed<T: PartialEq + std::fmt::Debug>(
    what: &str,
    expected: T,
    actual: Option<T>,
) -> Result<(), Mismatch> {
    actual.map_or(Ok(()), |actual| same(what, &expected, &actual))
}
