//! Numbers in one to four groups of 7 bits, most significant group first (manual section 7.2.5; M7).

/// Bit 7, set in every byte of a packet but the first.
pub(crate) const MARK: u8 = 0x80;

/// Bits that a byte carries.
const GROUP_BITS: u32 = 7;

/// The data bytes of a packet as they are on the wire, zero behind them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Groups {
    pub(crate) bytes: [u8; 4],
    pub(crate) len: u8,
}

impl Groups {
    /// The shortest form of a signed number of at most 28 bits.
    pub(crate) const fn signed(value: i32) -> Self {
        Self::fixed(value, shortest_len(value))
    }

    /// An unsigned number of at most 7 bits in one byte.
    pub(crate) const fn one(value: u8) -> Self {
        Self::fixed(value as i32, 1)
    }

    /// The lower `len` groups of a number, 1 ..= 4.
    pub(crate) const fn fixed(value: i32, len: u8) -> Self {
        let unused = 4 - len as u32;
        let left = (value as u32) << (GROUP_BITS * unused);
        let marks = 0x8080_8080_u32 << (8 * unused);
        let [a, b, c, d] = marks.to_be_bytes();
        Self {
            bytes: [
                a | (left >> 21 & 0x7F) as u8,
                b | (left >> 14 & 0x7F) as u8,
                c | (left >> 7 & 0x7F) as u8,
                d | (left & 0x7F) as u8,
            ],
            len,
        }
    }
}

/// Number of bytes of the shortest two's-complement form, 1 ..= 4, of a number of at most 28 bits.
const fn shortest_len(value: i32) -> u8 {
    if value << 25 >> 25 == value {
        1
    } else if value << 18 >> 18 == value {
        2
    } else if value << 11 >> 11 == value {
        3
    } else {
        4
    }
}

/// The groups of one to four data bytes as one unsigned number.
pub(crate) fn unsigned(data: &[u8]) -> u32 {
    data.iter().fold(0, |number, byte| {
        number << GROUP_BITS | u32::from(byte & !MARK)
    })
}

/// The groups of one to four data bytes as one signed number.
///
/// Explicit shifts on 32 bits: the manual's sample code leans on the sign of `char` and the width of `long` (M9, M10).
pub(crate) fn signed(data: &[u8]) -> i32 {
    let unused_bits = 32 - GROUP_BITS * (data.len() as u32).clamp(1, 4);
    (unsigned(data) << unused_bits) as i32 >> unused_bits
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bytes(value: i32) -> std::vec::Vec<u8> {
        let groups = Groups::signed(value);
        groups.bytes[..usize::from(groups.len)].to_vec()
    }

    #[test]
    fn boundaries_of_every_length() {
        assert_eq!(bytes(63), [0xBF]);
        assert_eq!(bytes(-64), [0xC0]);
        assert_eq!(bytes(64), [0x80, 0xC0]);
        assert_eq!(bytes(-65), [0xFF, 0xBF]);
        assert_eq!(bytes(8_191), [0xBF, 0xFF]);
        assert_eq!(bytes(-8_193), [0xFF, 0xBF, 0xFF]);
        assert_eq!(bytes(1_048_576), [0x80, 0xC0, 0x80, 0x80]);
        // The 24-bit mask of the sample code would send this one as 0 (M8).
        assert_eq!(bytes(-(1 << 27)), [0xC0, 0x80, 0x80, 0x80]);
        assert_eq!(bytes((1 << 27) - 1), [0xBF, 0xFF, 0xFF, 0xFF]);
    }

    #[test]
    fn one_byte_parameters_are_unsigned() {
        // 100 through the signed reader of the sample code would be -28 (M11).
        assert_eq!(unsigned(&[0xE4]), 100);
        assert_eq!(signed(&[0xE4]), -28);
        assert_eq!(Groups::one(100).bytes, [0xE4, 0, 0, 0]);
    }

    #[test]
    fn gear_numbers_take_two_bytes_and_the_largest_one_three() {
        assert_eq!(Groups::fixed(500, 2).bytes, [0x83, 0xF4, 0, 0]);
        assert_eq!(Groups::fixed(16_384, 3).bytes, [0x81, 0x80, 0x80, 0]);
    }

    proptest! {
        #[test]
        fn every_number_comes_back(value in -(1_i32 << 27)..(1 << 27)) {
            prop_assert_eq!(signed(&bytes(value)), value);
        }
    }
}
