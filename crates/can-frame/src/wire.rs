//! Length of classic CAN data frames with 11-bit identifiers on the wire: exact, worst case, and the textbook bound.
//!
//! Law (Bosch CAN 2.0 A and B part A, section 3.1 and 5; ISO 11898-1): SOF, identifier, RTR, IDE, r0 and DLC are 19 bits, then the
//! data and a CRC of 15 bits with polynomial 0x4599 and start value 0. A bit of the opposite level is stuffed behind five equal
//! bits of that part, counts as the first of the next run, and also follows the last CRC bit. Ten bits without stuffing (CRC
//! delimiter, ACK slot and delimiter, EOF) and three bits of interframe space end the frame.
//!
//! # Cost
//!
//! [`worst_bits`] reads a table of 2.6 KiB, some hundred bits of it in a call. A plan that is evaluated in a `const` leaves nothing of it in
//! the image; one that is computed at run time on a microcontroller puts it into flash.

use crate::worst_case::shortfall;

/// Longest data field in bytes.
const MAX_LEN: u8 = 8;

/// Bits that are never stuffed: CRC delimiter, ACK slot, ACK delimiter, EOF (7), interframe space (3).
const UNSTUFFED_TAIL_BITS: u16 = 13;

/// Bits of interframe space: they belong to the frame before them, receivers have that frame when they begin.
pub const INTERFRAME_BITS: u16 = 3;

const CRC_BITS: u32 = 15;
const CRC15_POLYNOMIAL: u16 = 0x4599;

/// Equal bits in a row after which a bit of the opposite level is stuffed.
const STUFF_RUN: u8 = 5;

/// Exact length in bits, interframe space included, of the data frame with this identifier and data.
///
/// `u16::MAX` for what is no such frame (identifier above 0x7FF, more than 8 bytes), so that no plan admits it.
#[must_use]
pub const fn exact_bits(id: u16, data: &[u8]) -> u16 {
    if id > 0x7FF || data.len() > MAX_LEN as usize {
        return u16::MAX;
    }
    let mut wire = Wire::behind_head(id, data.len() as u8);
    let mut rest = data;
    while let Some((byte, behind)) = rest.split_first() {
        wire = wire.push_field(*byte as u32, 8);
        rest = behind;
    }
    wire.push_field(wire.crc as u32, CRC_BITS).bits + UNSTUFFED_TAIL_BITS
}

/// The textbook bound in bits, interframe space included, for any identifier and `len` bytes: 55 + 10 `len`.
///
/// The first stuff bit needs five bits, each later one four more: 34 + 8 n bits hold at most (33 + 8 n) / 4.
#[must_use]
pub const fn bound_bits(len: u8) -> u16 {
    55 + 10 * len as u16
}

/// Exact worst case in bits, interframe space included, over every payload of `len` bytes behind this identifier.
///
/// `u16::MAX` for what is no such frame (identifier above 0x7FF, more than 8 bytes), so that no plan admits it.
#[must_use]
pub const fn worst_bits(id: u16, len: u8) -> u16 {
    if id > 0x7FF || len > MAX_LEN {
        return u16::MAX;
    }
    let Some(more_bytes) = len.checked_sub(1) else {
        return exact_bits(id, &[]);
    };
    let head = Wire::behind_head(id, len);
    // What was possible if the CRC were free: the run that the head has begun needs so many bits fewer.
    let behind = 8 * len as u16 + CRC_BITS as u16;
    let stuffed = (head.run as u16 - 1 + behind) / (STUFF_RUN as u16 - 1);
    head.bits + behind + stuffed + UNSTUFFED_TAIL_BITS - shortfall(id, more_bytes) as u16
}

/// What was sent so far.
#[derive(Clone, Copy)]
struct Wire {
    crc: u16,
    level: u8,
    run: u8,
    bits: u16,
}

impl Wire {
    const fn idle() -> Self {
        Self {
            crc: 0,
            level: 1,
            run: 0,
            bits: 0,
        }
    }

    /// SOF and the recessive level before it, identifier, RTR, IDE and r0, which are dominant, and the number of bytes.
    const fn behind_head(id: u16, len: u8) -> Self {
        Self::idle().push_field((id as u32) << 7 | len as u32, 19)
    }

    /// Sends the lowest `len` bits of `field`, the most significant first.
    const fn push_field(mut self, field: u32, len: u32) -> Self {
        let mut left = len;
        while left > 0 {
            left -= 1;
            self = self.push((field >> left & 1) as u8);
        }
        self
    }

    const fn push(self, bit: u8) -> Self {
        let is_fed_back = self.crc >> (CRC_BITS - 1) & 1 != bit as u16;
        let shifted = self.crc << 1 & 0x7FFF;
        let run = if bit == self.level { self.run + 1 } else { 1 };
        let is_stuffed = run == STUFF_RUN;
        Self {
            crc: if is_fed_back {
                shifted ^ CRC15_POLYNOMIAL
            } else {
                shifted
            },
            level: if is_stuffed { 1 - bit } else { bit },
            run: if is_stuffed { 1 } else { run },
            bits: self.bits + 1 + is_stuffed as u16,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_lengths_of_known_frames() {
        assert_eq!(exact_bits(0x000, &[]), 53);
        assert_eq!(exact_bits(0x7EF, &[]), 49);
        assert_eq!(exact_bits(0x7FF, &[0xFF]), 60);
        assert_eq!(exact_bits(0x2C7, &[0xDC, 0x4F, 0x0E, 0x0D]), 80);
        assert_eq!(
            exact_bits(0x078, &[0x0F, 0xE1, 0xFF, 0x87, 0x87, 0xFF, 0xFF, 0x00]),
            128
        );
    }

    #[test]
    fn what_is_no_frame_fits_no_plan() {
        assert_eq!(exact_bits(0x800, &[]), u16::MAX);
        assert_eq!(exact_bits(0, &[0; 9]), u16::MAX);
        assert_eq!(worst_bits(0x800, 0), u16::MAX);
        assert_eq!(worst_bits(0, 9), u16::MAX);
    }

    #[test]
    fn a_byte_more_is_always_longer() {
        for id in 0..=0x7FF {
            for len in 0..8 {
                assert!(worst_bits(id, len) < worst_bits(id, len + 1));
            }
        }
    }

    #[test]
    fn no_frame_is_longer_than_the_textbook_bound() {
        const LENGTHS: [u8; 9] = [0, 1, 2, 3, 4, 5, 6, 7, 8];
        let bounds = LENGTHS.map(bound_bits);
        assert_eq!(bounds, [55, 65, 75, 85, 95, 105, 115, 125, 135]);
        for id in 0..=0x7FF {
            for (len, bound) in LENGTHS.into_iter().zip(bounds) {
                assert!(worst_bits(id, len) <= bound, "{id:#x}, {len} bytes");
            }
        }
    }

    #[test]
    fn without_payload_the_worst_case_is_the_frame() {
        for id in 0..=0x7FF {
            assert_eq!(worst_bits(id, 0), exact_bits(id, &[]));
        }
    }

    #[test]
    fn a_plan_can_be_a_constant() {
        const PD: u16 = worst_bits(1 << 5 | 0x1C, 2);
        assert_eq!(PD, 71);
    }

    /// Largest over drives 1..=14.
    fn largest(bits: impl Fn(u16) -> u16) -> u16 {
        (1..=14).map(bits).max().unwrap()
    }

    #[test]
    fn frames_of_drives_1_to_14() {
        assert_eq!(largest(|drive| worst_bits(drive << 5 | 0x1C, 2)), 72);
        assert_eq!(largest(|drive| worst_bits(drive << 5 | 0x1C, 1)), 61);
        assert_eq!(largest(|drive| worst_bits(drive << 5 | 0x09, 1)), 61);
        let set_points: u16 = (1..=14).map(|drive| worst_bits(drive << 5 | 0x1C, 2)).sum();
        assert_eq!(set_points, 981);
    }
}
