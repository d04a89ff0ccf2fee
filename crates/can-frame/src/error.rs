//! What can be wrong with a frame.

use core::fmt;

/// What is no data frame with an 11-bit identifier, the only kind that the drives know.
///
/// DYN drives: CAN specification 1.6A and 1.2A, section 1, CAN 2.0A data frames only. CANopen: CiA 301; remote frames, such as a node
/// guarding request, are not used here.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FrameError {
    /// A 29-bit identifier.
    Extended {
        /// The 29-bit identifier.
        id: u32,
    },
    /// A remote frame; the drives do not answer them.
    Remote {
        /// The identifier asked for.
        id: u32,
    },
    /// An identifier beyond 11 bits, such as DYN drive 64 would need.
    Identifier {
        /// The identifier that was given.
        id: u32,
    },
    /// More than the 8 data bytes of a classic CAN frame.
    DataLength {
        /// The number of data bytes that was given.
        actual: usize,
    },
}

impl fmt::Display for FrameError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Extended { id } => {
                write!(
                    f,
                    "expected an 11-bit identifier, got the 29-bit identifier 0x{id:08X}"
                )
            }
            Self::Remote { id } => write!(
                f,
                "expected a data frame, got a remote frame for 0x{id:03X}"
            ),
            Self::Identifier { id } => write!(f, "identifier must be 0..=0x7FF, got 0x{id:X}"),
            Self::DataLength { actual } => write!(f, "expected at most 8 data bytes, got {actual}"),
        }
    }
}

impl core::error::Error for FrameError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_given_is_named_beside_what_is_expected() {
        let golden = [
            (
                FrameError::Extended { id: 0x0ABC_DEF0 },
                "expected an 11-bit identifier, got the 29-bit identifier 0x0ABCDEF0",
            ),
            (
                FrameError::Remote { id: 0x1B },
                "expected a data frame, got a remote frame for 0x01B",
            ),
            (
                FrameError::Identifier { id: 0x800 },
                "identifier must be 0..=0x7FF, got 0x800",
            ),
            (
                FrameError::DataLength { actual: 9 },
                "expected at most 8 data bytes, got 9",
            ),
        ];
        for (error, text) in golden {
            assert_eq!(std::format!("{error}"), text);
        }
    }
}
