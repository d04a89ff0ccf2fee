//! What can be wrong with a value, a frame or a message.
//!
//! Every error is a small `Copy` value that carries what was expected and what was there.

use core::fmt;

use dyn_values::RangeError;

use crate::function::{FunctionCode, Refusal};

/// A request that must not be sent to this address or in this revision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EncodeError {
    /// The function code has no request in this revision.
    Refused(Refusal),
    /// The request may not go to identifier 0, where every drive hears it (D2, D7).
    Broadcast {
        /// The function of the request.
        function: FunctionCode,
    },
    /// Assign_Drive_ID would store 0, the broadcast address, without `Dialect::allow_assign_zero` (D2).
    Range(RangeError),
}

impl From<RangeError> for EncodeError {
    fn from(error: RangeError) -> Self {
        Self::Range(error)
    }
}

impl From<Refusal> for EncodeError {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Refused(refusal) => refusal.fmt(f),
            Self::Broadcast { function } => write_broadcast(f, *function),
            Self::Range(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for EncodeError {}

/// A frame that does not decode as the message it claims to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum DecodeError {
    /// The function code has no such message in this revision.
    Refused(Refusal),
    /// A request on identifier 0 that may not be broadcast (D2, D7).
    Broadcast {
        /// The function of the request.
        function: FunctionCode,
    },
    /// The wrong number of data bytes.
    Length {
        /// The function of the message.
        function: FunctionCode,
        /// The fewest data bytes allowed.
        min: u8,
        /// The most data bytes allowed.
        max: u8,
        /// The number of data bytes received.
        actual: u8,
    },
    /// A number in more bytes than it needs, refused because of `Dialect::strict_minimal`.
    NotShortest {
        /// The function of the message.
        function: FunctionCode,
        /// The number of data bytes that would do.
        expected: u8,
        /// The number of data bytes received.
        actual: u8,
    },
    /// A selector or magic byte that the function does not know.
    Magic {
        /// The function of the message.
        function: FunctionCode,
        /// The two bytes it knows; the same byte twice where there is only one.
        expected: [u8; 2],
        /// The byte received.
        actual: u8,
    },
    /// A number outside its range.
    Range(RangeError),
    /// A General_Read reply without the outstanding request: position and torque look alike (D31).
    SelectorUnknown,
    /// A Read_Param_Group3 reply whose ON_POS_RANGE fits neither byte order (D20).
    ByteOrder {
        /// The two bytes of ON_POS_RANGE.
        on_pos_range: [u8; 2],
    },
    /// A Read_Param_Group3 reply of 1.2A that is within its ranges in both byte orders (D21).
    OrderUnknown {
        /// Gear number read MSB first.
        msb_first: u16,
        /// Gear number read LSB first.
        lsb_first: u16,
    },
    /// An echo that is not what was sent.
    EchoMismatch {
        /// The bytes sent.
        expected: [u8; 4],
        /// The bytes received.
        actual: [u8; 4],
    },
    /// A reply to something else than the outstanding request.
    Unexpected {
        /// The function of the outstanding request.
        expected: FunctionCode,
        /// The function of the frame.
        actual: FunctionCode,
    },
}

impl From<RangeError> for DecodeError {
    fn from(error: RangeError) -> Self {
        Self::Range(error)
    }
}

impl From<Refusal> for DecodeError {
    fn from(refusal: Refusal) -> Self {
        Self::Refused(refusal)
    }
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Refused(refusal) => refusal.fmt(f),
            Self::Broadcast { function } => write_broadcast(f, function),
            Self::Length {
                function,
                min,
                max,
                actual,
            } if min == max => {
                write!(f, "{function} needs {min} data bytes, got {actual}")
            }
            Self::Length {
                function,
                min,
                max,
                actual,
            } => {
                write!(f, "{function} needs {min}..={max} data bytes, got {actual}")
            }
            Self::NotShortest {
                function,
                expected,
                actual,
            } => {
                write!(
                    f,
                    "{function}: the number needs {expected} data bytes, got {actual}"
                )
            }
            Self::Magic {
                function,
                expected: [first, second],
                actual,
            } if first == second => {
                write!(f, "{function} knows data 0x{first:02X}, got 0x{actual:02X}")
            }
            Self::Magic {
                function,
                expected: [first, second],
                actual,
            } => {
                write!(
                    f,
                    "{function} knows data 0x{first:02X} and 0x{second:02X}, got 0x{actual:02X}"
                )
            }
            Self::Range(error) => error.fmt(f),
            Self::SelectorUnknown => f.write_str(
                "General_Read reply without its request: position and torque look alike",
            ),
            Self::ByteOrder {
                on_pos_range: [first, second],
            } => write!(
                f,
                "ON_POS_RANGE must be 1..=127 in one byte order, got the bytes 0x{first:02X} 0x{second:02X}"
            ),
            Self::OrderUnknown {
                msb_first,
                lsb_first,
            } => write!(
                f,
                "the gear number is {msb_first} or {lsb_first}, and the document does not state the byte order: fix the byte order of this drive"
            ),
            Self::EchoMismatch { expected, actual } => {
                write!(f, "expected the echo {expected:02X?}, got {actual:02X?}")
            }
            Self::Unexpected { expected, actual } => {
                write!(f, "expected a reply to {expected}, got {actual}")
            }
        }
    }
}

impl core::error::Error for DecodeError {}

fn write_broadcast(f: &mut fmt::Formatter<'_>, function: FunctionCode) -> fmt::Result {
    write!(
        f,
        "{function} may not be broadcast: only Sync_Trigger may, more by Dialect::zero_address"
    )
}

#[cfg(test)]
mod tests {
    use dyn_values::Quantity;

    use super::*;

    const FUNCTION: FunctionCode = FunctionCode::GeneralRead;
    const REFUSED: Refusal = Refusal::DriveOnly;
    const RANGE: RangeError = RangeError {
        quantity: Quantity::DriveId,
        actual: 64,
    };
    const BROADCAST: &str = "General_Read (0x0E) may not be broadcast: only Sync_Trigger may, more by Dialect::zero_address";

    #[test]
    fn a_refused_request_says_why() {
        let golden = [
            (
                EncodeError::from(REFUSED),
                "Drive_Error (0x1D) is sent by drives only",
            ),
            (EncodeError::Broadcast { function: FUNCTION }, BROADCAST),
            (EncodeError::from(RANGE), "drive id must be 1..=63, got 64"),
        ];
        for (error, text) in golden {
            assert_eq!(std::format!("{error}"), text);
        }
    }

    #[test]
    fn a_refused_frame_says_what_was_expected_and_what_came() {
        let length = |min, max| DecodeError::Length {
            function: FUNCTION,
            min,
            max,
            actual: 5,
        };
        let magic = |expected| DecodeError::Magic {
            function: FUNCTION,
            expected,
            actual: 0x1D,
        };
        let golden = [
            (
                DecodeError::from(REFUSED),
                "Drive_Error (0x1D) is sent by drives only",
            ),
            (DecodeError::Broadcast { function: FUNCTION }, BROADCAST),
            (
                length(1, 1),
                "General_Read (0x0E) needs 1 data bytes, got 5",
            ),
            (
                length(1, 4),
                "General_Read (0x0E) needs 1..=4 data bytes, got 5",
            ),
            (
                DecodeError::NotShortest {
                    function: FUNCTION,
                    expected: 1,
                    actual: 4,
                },
                "General_Read (0x0E): the number needs 1 data bytes, got 4",
            ),
            (
                magic([0x1B, 0x1B]),
                "General_Read (0x0E) knows data 0x1B, got 0x1D",
            ),
            (
                magic([0x1B, 0x1E]),
                "General_Read (0x0E) knows data 0x1B and 0x1E, got 0x1D",
            ),
            (DecodeError::from(RANGE), "drive id must be 1..=63, got 64"),
            (
                DecodeError::SelectorUnknown,
                "General_Read reply without its request: position and torque look alike",
            ),
            (
                DecodeError::ByteOrder {
                    on_pos_range: [0x0A, 0x80],
                },
                "ON_POS_RANGE must be 1..=127 in one byte order, got the bytes 0x0A 0x80",
            ),
            (
                DecodeError::OrderUnknown {
                    msb_first: 4_112,
                    lsb_first: 4_096,
                },
                "the gear number is 4112 or 4096, and the document does not state the byte order: fix the byte order of this drive",
            ),
            (
                DecodeError::EchoMismatch {
                    expected: [1, 2, 3, 4],
                    actual: [1, 2, 3, 0xFF],
                },
                "expected the echo [01, 02, 03, 04], got [01, 02, 03, FF]",
            ),
            (
                DecodeError::Unexpected {
                    expected: FUNCTION,
                    actual: FunctionCode::ReadDriveStatus,
                },
                "expected a reply to General_Read (0x0E), got Read_Drive_Status (0x09)",
            ),
        ];
        for (error, text) in golden {
            assert_eq!(std::format!("{error}"), text);
        }
    }
}
