//! What the frames of these drives carry: address and function in the identifier, a message in the data.

use can_frame::DataFrame;

use crate::error::DecodeError;
use crate::function::FunctionCode;
use crate::id::Address;

/// What the identifier of a frame says.
pub trait DynFrame {
    /// The address in the identifier.
    fn address(&self) -> Address;

    /// The function code in the identifier.
    fn function(&self) -> FunctionCode;
}

impl DynFrame for DataFrame {
    fn address(&self) -> Address {
        Address::from_can_id(self.id())
    }

    fn function(&self) -> FunctionCode {
        FunctionCode::from_can_id(self.id())
    }
}

/// Data bytes of a message that is being built; behind `len` they are zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Payload {
    len: u8,
    data: [u8; 8],
}

impl Payload {
    pub(crate) const EMPTY: Self = Self {
        len: 0,
        data: [0; 8],
    };

    /// A payload of `len` bytes, at most 4, whose other bytes are zero.
    pub(crate) const fn from_word([a, b, c, d]: [u8; 4], len: u8) -> Self {
        Self {
            len,
            data: [a, b, c, d, 0, 0, 0, 0],
        }
    }

    pub(crate) const fn one(byte: u8) -> Self {
        Self::from_word([byte, 0, 0, 0], 1)
    }

    pub(crate) const fn five([a, b, c, d, e]: [u8; 5]) -> Self {
        Self {
            len: 5,
            data: [a, b, c, d, e, 0, 0, 0],
        }
    }

    pub(crate) const fn six([a, b, c, d, e, f]: [u8; 6]) -> Self {
        Self {
            len: 6,
            data: [a, b, c, d, e, f, 0, 0],
        }
    }

    #[cfg(test)]
    pub(crate) fn as_slice(&self) -> &[u8] {
        &self.data[..usize::from(self.len)]
    }
}

/// The frame of a message.
pub(crate) const fn compose(to: Address, function: FunctionCode, payload: Payload) -> DataFrame {
    DataFrame::from_fields(to.can_id(function), payload.len, payload.data)
}

/// The first four bytes, zero behind the data.
pub(crate) const fn first_word(frame: &DataFrame) -> [u8; 4] {
    let [a, b, c, d, ..] = *frame.bytes();
    [a, b, c, d]
}

/// Checks the number of data bytes against the fewest and the most.
pub(crate) fn expect_len(frame: &DataFrame, (min, max): (u8, u8)) -> Result<(), DecodeError> {
    if frame.len() < min || frame.len() > max {
        return Err(DecodeError::Length {
            function: frame.function(),
            min,
            max,
            actual: frame.len(),
        });
    }
    Ok(())
}
