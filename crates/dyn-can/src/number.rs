//! Signed numbers in one to four bytes (1.6A section 4, data length field).

use can_frame::DataFrame;

use crate::byte_order::ByteOrder;
use crate::dialect::Dialect;
use crate::error::DecodeError;
use crate::frame::{DynFrame, Payload, first_word};

/// A number of bytes that a number may be sent in, and the bits of a word that it leaves unused.
#[derive(Clone, Copy)]
pub(crate) struct Form {
    pub(crate) len: u8,
    unused_bits: u32,
}

impl Form {
    const ONE: Self = Self::of_bytes(1);
    pub(crate) const TWO: Self = Self::of_bytes(2);
    const THREE: Self = Self::of_bytes(3);
    const FOUR: Self = Self::of_bytes(4);

    const fn of_bytes(len: u8) -> Self {
        Self {
            len,
            unused_bits: 8 * (4 - len as u32),
        }
    }

    /// The shortest two's-complement form of a number.
    #[inline(always)]
    pub(crate) const fn shortest(value: i32) -> Self {
        if value as i8 as i32 == value {
            Self::ONE
        } else if value as i16 as i32 == value {
            Self::TWO
        } else if value << 8 >> 8 == value {
            Self::THREE
        } else {
            Self::FOUR
        }
    }
}

/// The shortest two's-complement form.
#[inline(always)]
pub(crate) const fn encode(value: i32, order: ByteOrder) -> Payload {
    encode_in(value, Form::shortest(value), order)
}

/// The two's-complement form in so many bytes, which must hold the value.
#[inline(always)]
pub(crate) const fn encode_in(
    value: i32,
    Form { len, unused_bits }: Form,
    order: ByteOrder,
) -> Payload {
    let word = match order {
        ByteOrder::MsbFirst => ((value as u32) << unused_bits).to_be_bytes(),
        ByteOrder::LsbFirst => ((value as u32) << unused_bits >> unused_bits).to_le_bytes(),
    };
    Payload::from_word(word, len)
}

/// Reads the whole data field as one number; the caller has checked that it has 1 ..= 4 bytes.
pub(crate) const fn decode(frame: &DataFrame, order: ByteOrder) -> i32 {
    match order {
        ByteOrder::MsbFirst => decode_msb_first(frame),
        ByteOrder::LsbFirst => {
            let unused_bits = unused_bits(frame);
            i32::from_le_bytes(first_word(frame)) << unused_bits >> unused_bits
        }
    }
}

/// The same with the most significant byte first.
pub(crate) const fn decode_msb_first(frame: &DataFrame) -> i32 {
    // Frames are zero-filled behind their data, so the shift alone extends the sign.
    i32::from_be_bytes(first_word(frame)) >> unused_bits(frame)
}

const fn unused_bits(frame: &DataFrame) -> u32 {
    8 * (4_u32.wrapping_sub(frame.len() as u32) & 3)
}

/// Reads the whole data field, 1 ..= 4 bytes as the caller has checked, and where asked insists on the shortest form.
pub(crate) fn decode_checked(frame: &DataFrame, dialect: &Dialect) -> Result<i32, DecodeError> {
    let value = decode(frame, dialect.number_order);
    let expected = Form::shortest(value).len;
    if dialect.strict_minimal && frame.len() > expected {
        return Err(DecodeError::NotShortest {
            function: frame.function(),
            expected,
            actual: frame.len(),
        });
    }
    Ok(value)
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

    #[test]
    fn every_length_keeps_its_sign_in_both_orders() {
        let of_each_length = [-1, 100, -129, 30_000, -32_769, 40_000, -8_388_609, 1 << 26];
        for value in of_each_length {
            for order in [ByteOrder::MsbFirst, ByteOrder::LsbFirst] {
                let frame = DataFrame::new(0x021, &bytes(value, order)).unwrap();
                assert_eq!(decode(&frame, order), value);
            }
        }
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
