//! Frames of the drives' bus, as the controllers take them.

use dyn_can::DataFrame;

/// Bytes of a word. A data length code of 9 to 15 on the wire means 8 bytes, too (ISO 11898-1, section 8.4.2.4).
const WORD_BYTES: u8 = 4;

/// From what the registers of a controller hold: `id` has 11 bits, `length` is the data length code, `words` the data bytes in the order
/// of the wire, the first one lowest. Behind the data the registers hold anything.
#[inline(always)]
pub(crate) fn from_registers(id: u16, length: u8, [low, high]: [u32; 2]) -> DataFrame {
    let low = first_bytes(low, length);
    let high = first_bytes(high, length.saturating_sub(WORD_BYTES));
    let data = u64::from(high) << u32::BITS | u64::from(low);
    DataFrame::from_fields(id, length, data.to_le_bytes())
}

/// So many of the bytes, the lowest first; zero in the place of the others.
fn first_bytes(word: u32, bytes: u8) -> u32 {
    if bytes >= WORD_BYTES {
        return word;
    }
    word & !(u32::MAX << (8 * bytes))
}

/// The data bytes as the registers take them.
pub(crate) const fn words(frame: &DataFrame) -> [u32; 2] {
    let [a, b, c, d, e, f, g, h] = *frame.bytes();
    [
        u32::from_le_bytes([a, b, c, d]),
        u32::from_le_bytes([e, f, g, h]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_hold_the_bytes_in_the_order_of_the_wire() {
        let frame = DataFrame::new(0x03C, &[1, 2, 3, 4, 5]).unwrap();
        assert_eq!(words(&frame), [0x0403_0201, 0x0000_0005]);
        let read = from_registers(frame.id(), frame.len(), words(&frame));
        assert_eq!(read, frame);
    }

    #[test]
    fn what_the_registers_hold_behind_the_data_is_no_part_of_the_frame() {
        for length in 0..=8 {
            let read = from_registers(1, length, [u32::MAX; 2]);
            let data = [0xFF; 8];
            assert_eq!(
                read,
                DataFrame::new(1, &data[..usize::from(length)]).unwrap()
            );
        }
    }

    #[test]
    fn a_length_code_above_8_means_8() {
        let frame = from_registers(1, 15, [u32::MAX; 2]);
        assert_eq!(frame.data(), [0xFF; 8]);
    }
}
