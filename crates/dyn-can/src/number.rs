//! Signed numbers in one to four bytes (1.6A section 4, data length field).

use can_frame::DataFrame;

use crate::byte_order::ByteOrder;
use crate::error::DecodeError;
use crate::frame::{DynFrame, Payload, expect_len, first_word};
use crate::function::FunctionCode;

/// Number of bytes of the shortest two's-complement form, 1 ..= 4.
pub(crate) const fn shortest_len(value: i32) -> u8 {
    if value as i8 as i32 == value {
        1
    } else if value as i16 as i32 == value {
        2
    } else if value << 8 >> 8 == value {
        3
    } else {
        4
    }
}

/// The shortest two's-complement form.
pub(crate) const fn encode(value: i32, order: ByteOrder) -> Payload {
    encode_in(value, shortest_len(value), order)
}

/// The two's-complement form in `len` bytes, 1 ..= 4, which must hold the value.
pub(crate) const fn encode_in(value: i32, len: u8, order: ByteOrder) -> Payload {
    let unused_bits = 8 * (4 - len as u32);
    let word = match order {
        ByteOrder::MsbFirst => ((value as u32) << unused_bits).to_be_bytes(),
        ByteOrder::LsbFirst => ((value as u32) << unused_bits >> unused_bits).to_le_bytes(),
    };
    Payload::from_word(word, len)
}

/// Reads the whole data field as one number; the caller has checked that it has 1 ..= 4 bytes.
pub(crate) const fn decode(frame: &DataFrame, order: ByteOrder) -> i32 {
    let word = first_word(frame);
    // Frames are zero-filled behind their data, so the shift alone extends the sign.
    let unused_bits = 8 * (4_u32.wrapping_sub(frame.len() as u32) & 3);
    match order {
        ByteOrder::MsbFirst => i32::from_be_bytes(word) >> unused_bits,
        ByteOrder::LsbFirst => i32::from_le_bytes(word) << unused_bits >> unused_bits,
    }
}

/// Reads a number of `min` to `max` bytes and, where asked, insists on its shortest form.
pub(crate) fn decode_checked(
    frame: &DataFrame,
    (min, max): (u8, u8),
    order: ByteOrder,
    strict_minimal: bool,
) -> Result<i32, DecodeError> {
    let function = frame.function();
    expect_len(frame, min, max)?;
    let value = decode(frame, order);
    if strict_minimal {
        require_shortest(function, value, frame.len())?;
    }
    Ok(value)
}

fn require_shortest(function: FunctionCode, value: i32, actual: u8) -> Result<(), DecodeError> {
    let expected = shortest_len(value);
    if actual > expected {
        return Err(DecodeError::NotShortest {
            function,
            expected,
            actual,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn bytes(value: i32, order: ByteOrder) -> std::vec::Vec<u8> {
        encode(value, order).as_slice().to_vec()
    }

    #[test]
    fn boundaries_of_every_length() {
        use ByteOrder::MsbFirst;
        assert_eq!(bytes(0, MsbFirst), [0x00]);
        assert_eq!(bytes(-128, MsbFirst), [0x80]);
        assert_eq!(bytes(128, MsbFirst), [0x00, 0x80]);
        assert_eq!(bytes(-129, MsbFirst), [0xFF, 0x7F]);
        assert_eq!(bytes(32_768, MsbFirst), [0x00, 0x80, 0x00]);
        assert_eq!(bytes(-32_769, MsbFirst), [0xFF, 0x7F, 0xFF]);
        assert_eq!(bytes(8_388_608, MsbFirst), [0x00, 0x80, 0x00, 0x00]);
        assert_eq!(bytes(-8_388_609, MsbFirst), [0xFF, 0x7F, 0xFF, 0xFF]);
        assert_eq!(bytes(-(1 << 27), MsbFirst), [0xF8, 0x00, 0x00, 0x00]);
    }

    #[test]
    fn the_only_example_of_the_documents() {
        // 1.6A section 6, #10: -2000 rpm is F8 30, 50 rpm is 32.
        assert_eq!(bytes(-2000, ByteOrder::MsbFirst), [0xF8, 0x30]);
        assert_eq!(bytes(50, ByteOrder::MsbFirst), [0x32]);
        assert_eq!(bytes(-2000, ByteOrder::LsbFirst), [0x30, 0xF8]);
    }

    proptest! {
        #[test]
        fn every_number_comes_back(value: i32, lsb_first: bool) {
            let order = if lsb_first { ByteOrder::LsbFirst } else { ByteOrder::MsbFirst };
            let frame = DataFrame::new(0x021, encode(value, order).as_slice()).unwrap();
            prop_assert_eq!(decode(&frame, order), value);
        }
    }
}
