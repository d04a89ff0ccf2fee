//! What can be wrong with a value, a frame or a message.
//!
//! Every error is a small `Copy` value that carries what was expected and what was there.

use core::fmt;

use crate::object::{DataType, ObjectAddress};

/// A node number outside 1 ..= 127.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct NodeError {
    /// The number that was given.
    pub actual: i32,
}

impl fmt::Display for NodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a node is 1..=127, got {}", self.actual)
    }
}

impl core::error::Error for NodeError {}

/// A frame that is no message of this protocol.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum DecodeError {
    /// The identifier belongs to no service, or to another one than expected.
    Service {
        /// The identifier.
        can_id: u16,
    },
    /// The identifier of a service of node 0, which does not exist.
    Node {
        /// The identifier.
        can_id: u16,
    },
    /// Another number of data bytes than the message has.
    Length {
        /// The identifier.
        can_id: u16,
        /// The number of bytes of the message.
        expected: u8,
        /// The number of bytes that came.
        actual: u8,
    },
    /// An SDO command specifier that is not expedited: segmented or block transfer, or the other direction.
    Specifier {
        /// The specifier.
        actual: u8,
    },
    /// A heartbeat state that CiA 301 does not list.
    NmtState {
        /// The state byte.
        actual: u8,
    },
    /// An NMT command that CiA 301 does not list.
    NmtCommand {
        /// The command byte.
        actual: u8,
    },
    /// An NMT command to a node beyond 127.
    NmtNode {
        /// The node byte.
        actual: u8,
    },
}

impl fmt::Display for DecodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Service { can_id } => write!(
                f,
                "no message expected here has the identifier 0x{can_id:03X}"
            ),
            Self::Node { can_id } => write!(
                f,
                "a node is 1..=127, the identifier 0x{can_id:03X} is of node 0"
            ),
            Self::Length {
                can_id,
                expected,
                actual,
            } => {
                write!(
                    f,
                    "0x{can_id:03X} needs {expected} data bytes, got {actual}"
                )
            }
            Self::Specifier { actual } => write!(
                f,
                "expected an expedited SDO, got the command specifier 0x{actual:02X}"
            ),
            Self::NmtState { actual } => write!(
                f,
                "a heartbeat has 0x00, 0x04, 0x05 or 0x7F, got 0x{actual:02X}"
            ),
            Self::NmtCommand { actual } => {
                write!(
                    f,
                    "an NMT command is 0x01, 0x02, 0x80, 0x81 or 0x82, got 0x{actual:02X}"
                )
            }
            Self::NmtNode { actual } => {
                write!(f, "an NMT command goes to 0 or 1..=127, got {actual}")
            }
        }
    }
}

impl core::error::Error for DecodeError {}

/// Why a value may not be written to an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum WriteError {
    /// The guide's dictionary has no such object.
    NoSuchObject {
        /// The object asked for.
        address: ObjectAddress,
    },
    /// The object is read-only.
    ReadOnly {
        /// The object.
        address: ObjectAddress,
    },
    /// The value leaves the printed range, or the range of the type where none is printed.
    Range {
        /// The object.
        address: ObjectAddress,
        /// Its type.
        data_type: DataType,
        /// The smallest value.
        min: i64,
        /// The largest value.
        max: i64,
        /// The value that was given.
        actual: i64,
    },
}

impl fmt::Display for WriteError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::NoSuchObject { address } => write!(f, "the object dictionary has no {address}"),
            Self::ReadOnly { address } => write!(f, "{address} is read-only"),
            Self::Range {
                address,
                data_type,
                min,
                max,
                actual,
            } => {
                write!(
                    f,
                    "{address} ({data_type}) must be {min}..={max}, got {actual}"
                )
            }
        }
    }
}

impl core::error::Error for WriteError {}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    #[test]
    fn a_refused_frame_says_what_was_expected_and_what_came() {
        let golden = [
            (
                DecodeError::Service { can_id: 0x7FF },
                "no message expected here has the identifier 0x7FF",
            ),
            (
                DecodeError::Node { can_id: 0x080 },
                "a node is 1..=127, the identifier 0x080 is of node 0",
            ),
            (
                DecodeError::Length {
                    can_id: 0x704,
                    expected: 1,
                    actual: 2,
                },
                "0x704 needs 1 data bytes, got 2",
            ),
            (
                DecodeError::Specifier { actual: 0xE0 },
                "expected an expedited SDO, got the command specifier 0xE0",
            ),
            (
                DecodeError::NmtState { actual: 0x06 },
                "a heartbeat has 0x00, 0x04, 0x05 or 0x7F, got 0x06",
            ),
            (
                DecodeError::NmtCommand { actual: 0x03 },
                "an NMT command is 0x01, 0x02, 0x80, 0x81 or 0x82, got 0x03",
            ),
            (
                DecodeError::NmtNode { actual: 128 },
                "an NMT command goes to 0 or 1..=127, got 128",
            ),
        ];
        for (error, text) in golden {
            assert_eq!(error.to_string(), text);
        }
        let node = NodeError { actual: 128 };
        assert_eq!(node.to_string(), "a node is 1..=127, got 128");
    }

    #[test]
    fn a_refused_write_names_the_object_and_its_range() {
        let address = ObjectAddress::new(0x6081, 0);
        let golden = [
            (
                WriteError::NoSuchObject { address },
                "the object dictionary has no 6081h:00",
            ),
            (WriteError::ReadOnly { address }, "6081h:00 is read-only"),
            (
                WriteError::Range {
                    address,
                    data_type: DataType::U32,
                    min: 0,
                    max: 3_000,
                    actual: 3_001,
                },
                "6081h:00 (U32) must be 0..=3000, got 3001",
            ),
        ];
        for (error, text) in golden {
            assert_eq!(error.to_string(), text);
        }
    }
}
