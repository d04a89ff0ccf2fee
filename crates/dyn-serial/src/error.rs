//! What can be wrong with a value, a packet or a message.
//!
//! Every error is a small `Copy` value that carries what was expected and what was there.

use core::fmt;

use dyn_values::RangeError;

use crate::function::{ReplyFunction, RequestFunction};

/// Bytes that are no packet (manual section 7.2).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PacketError {
    /// Another number of bytes than the second byte announces; 4 ..= 7 where there is none.
    Length {
        /// The number of bytes announced.
        expected: usize,
        /// The number of bytes given.
        actual: usize,
    },
    /// A first byte with bit 7 set.
    StartByte {
        /// The byte.
        actual: u8,
    },
    /// A byte behind the first with bit 7 clear, which would be a start byte.
    InnerByte {
        /// Its place in the packet, from 1.
        index: usize,
        /// The byte.
        actual: u8,
    },
    /// The last byte does not fit the others.
    Checksum {
        /// The byte that would fit.
        expected: u8,
        /// The byte given.
        actual: u8,
    },
}

impl fmt::Display for PacketError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Length { expected, actual } => {
                write!(f, "expected a packet of {expected} bytes, got {actual}")
            }
            Self::StartByte { actual } => {
                write!(f, "expected a start byte below 0x80, got 0x{actual:02X}")
            }
            Self::InnerByte { index, actual } => write!(
                f,
                "expected byte {index} to be 0x80 or more, got 0x{actual:02X}"
            ),
            Self::Checksum { expected, actual } => {
                write!(f, "expected checksum 0x{expected:02X}, got 0x{actual:02X}")
            }
        }
    }
}

impl core::error::Error for PacketError {}

/// A function with its direction, for messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Function {
    /// From host to drive.
    Request(RequestFunction),
    /// From drive to host.
    Reply(ReplyFunction),
}

impl From<RequestFunction> for Function {
    fn from(function: RequestFunction) -> Self {
        Self::Request(function)
    }
}

impl From<ReplyFunction> for Function {
    fn from(function: ReplyFunction) -> Self {
        Self::Reply(function)
    }
}

impl fmt::Display for Function {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Request(function) => function.fmt(f),
            Self::Reply(function) => function.fmt(f),
        }
    }
}

/// A request that must not be sent to this address, or that the dialect has no form for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EncodeError {
    /// The request may not go to the general id, where every drive hears it.
    Broadcast {
        /// The function of the request.
        function: RequestFunction,
    },
    /// The number does not fit the form that the dialect sends: gear number 16384 in two bytes (M13).
    Range(RangeError),
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Broadcast { function } => write_broadcast(f, *function),
            Self::Range(error) => error.fmt(f),
        }
    }
}

impl core::error::Error for EncodeError {}

/// A packet that does not decode as the message it claims to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum DecodeError {
    /// 0x0F, reserved for the factory: never send it.
    Factory,
    /// A code that no drive sends (M18).
    UnknownReply {
        /// The code.
        code: u8,
    },
    /// A request on the general id that may not be sent there.
    Broadcast {
        /// The function of the request.
        function: RequestFunction,
    },
    /// The wrong number of data bytes.
    Length {
        /// The function of the message.
        function: Function,
        /// The fewest data bytes allowed.
        min: u8,
        /// The most data bytes allowed.
        max: u8,
        /// The number of data bytes received.
        actual: u8,
    },
    /// A selector that General_Read does not know.
    Selector {
        /// The data received; 1B and 1E are known.
        actual: u8,
    },
    /// A number outside its range, or a reserved drive id.
    Range(RangeError),
    /// A reply on the general id: it does not say which drive sent it.
    ReplyFromAll,
}

impl From<RangeError> for DecodeError {
    fn from(error: RangeError) -> Self {
        Self::Range(error)
    }
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Factory => {
                f.write_str("function code 0x0F is reserved for the factory: never send it")
            }
            Self::UnknownReply { code } => {
                write!(
                    f,
                    "expected a reply code, got 0x{code:02X}: no drive sends it"
                )
            }
            Self::Broadcast { function } => write_broadcast(f, function),
            Self::Length {
                function,
                min,
                max,
                actual,
            } if min == max => write!(f, "{function} needs {min} data bytes, got {actual}"),
            Self::Length {
                function,
                min,
                max,
                actual,
            } => write!(f, "{function} needs {min}..={max} data bytes, got {actual}"),
            Self::Selector { actual } => {
                write!(f, "General_Read knows 0x1B and 0x1E, got 0x{actual:02X}")
            }
            Self::Range(error) => error.fmt(f),
            Self::ReplyFromAll => {
                f.write_str("expected a reply from one drive, got one from the general id 127")
            }
        }
    }
}

impl core::error::Error for DecodeError {}

fn write_broadcast(f: &mut fmt::Formatter<'_>, function: RequestFunction) -> fmt::Result {
    write!(
        f,
        "{function} may not go to the general id 127: only coordinated moves may, more by Dialect::general_id"
    )
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use dyn_values::Quantity;

    use super::*;

    const RANGE: RangeError = RangeError {
        quantity: Quantity::SerialDriveId,
        actual: 64,
    };
    const FUNCTION: RequestFunction = RequestFunction::SetOrigin;
    const BROADCAST: &str = "Set_Origin (0x00) may not go to the general id 127: only coordinated moves may, more by Dialect::general_id";

    #[test]
    fn bytes_that_are_no_packet_say_what_was_expected() {
        let golden = [
            (
                PacketError::Length {
                    expected: 4,
                    actual: 5,
                },
                "expected a packet of 4 bytes, got 5",
            ),
            (
                PacketError::StartByte { actual: 0x83 },
                "expected a start byte below 0x80, got 0x83",
            ),
            (
                PacketError::InnerByte {
                    index: 2,
                    actual: 0x03,
                },
                "expected byte 2 to be 0x80 or more, got 0x03",
            ),
            (
                PacketError::Checksum {
                    expected: 0x9E,
                    actual: 0x9F,
                },
                "expected checksum 0x9E, got 0x9F",
            ),
        ];
        for (error, text) in golden {
            assert_eq!(error.to_string(), text);
        }
    }

    #[test]
    fn a_refused_request_says_why() {
        let broadcast = EncodeError::Broadcast { function: FUNCTION };
        assert_eq!(broadcast.to_string(), BROADCAST);
        let range = EncodeError::Range(RANGE);
        assert_eq!(range.to_string(), "drive id must be 0..=63, got 64");
    }

    #[test]
    fn a_refused_packet_says_what_was_expected_and_what_came() {
        let length = |function, min, max| DecodeError::Length {
            function,
            min,
            max,
            actual: 4,
        };
        let golden = [
            (
                DecodeError::Factory,
                "function code 0x0F is reserved for the factory: never send it",
            ),
            (
                DecodeError::UnknownReply { code: 0x1F },
                "expected a reply code, got 0x1F: no drive sends it",
            ),
            (DecodeError::Broadcast { function: FUNCTION }, BROADCAST),
            (
                length(FUNCTION.into(), 1, 1),
                "Set_Origin (0x00) needs 1 data bytes, got 4",
            ),
            (
                length(ReplyFunction::IsStatus.into(), 1, 3),
                "Is_Status (0x19) needs 1..=3 data bytes, got 4",
            ),
            (
                DecodeError::Selector { actual: 0x1C },
                "General_Read knows 0x1B and 0x1E, got 0x1C",
            ),
            (DecodeError::from(RANGE), "drive id must be 0..=63, got 64"),
            (
                DecodeError::ReplyFromAll,
                "expected a reply from one drive, got one from the general id 127",
            ),
        ];
        for (error, text) in golden {
            assert_eq!(error.to_string(), text);
        }
    }
}
