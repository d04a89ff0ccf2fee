//! Why a set-up stops.

use core::fmt;

use crate::abort::AbortCode;
use crate::object::ObjectAddress;
use crate::object::WidthError;

/// Why a set-up stopped. Nothing is undone.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SetUpError {
    /// Another drive than this codec knows, or another firmware than expected.
    Identity {
        /// What was compared.
        address: ObjectAddress,
        /// What this drive has.
        expected: u32,
        /// What is there.
        actual: u32,
    },
    /// A value that the set-up expects and does not write is another one.
    Differs {
        /// The object.
        address: ObjectAddress,
        /// What it should be.
        expected: u32,
        /// What it is.
        actual: u32,
    },
    /// The drive refused.
    Refused {
        /// The object.
        address: ObjectAddress,
        /// Why.
        code: AbortCode,
    },
    /// The drive did not answer, or not with an expedited transfer.
    Silent {
        /// The object.
        address: ObjectAddress,
    },
    /// The drive holds the object in another width.
    Width {
        /// The object.
        address: ObjectAddress,
        /// Both widths.
        error: WidthError,
    },
    /// The list of steps is too long; nothing was written.
    TooManySteps {
        /// The longest.
        most: usize,
        /// The length of the list.
        actual: usize,
    },
    /// The value read back is not the one that was written.
    NotTaken {
        /// The object.
        address: ObjectAddress,
        /// What was written.
        expected: u32,
        /// What is there.
        actual: u32,
    },
}

impl fmt::Display for SetUpError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Identity {
                address,
                expected,
                actual,
            } => write!(
                f,
                "this is another drive or firmware: {address} should be 0x{expected:X}, it is 0x{actual:X}"
            ),
            Self::Differs {
                address,
                expected,
                actual,
            } => write!(f, "{address} must be 0x{expected:X}, it is 0x{actual:X}"),
            Self::Refused { address, code } => write!(f, "the drive refuses {address}: {code}"),
            Self::Silent { address } => write!(f, "no answer about {address}"),
            Self::Width { address, error } => write!(f, "{address}: {error}"),
            Self::TooManySteps { most, actual } => write!(
                f,
                "a set-up has at most {most} steps, this one has {actual}: divide it"
            ),
            Self::NotTaken {
                address,
                expected,
                actual,
            } => {
                write!(
                    f,
                    "{address} was written as 0x{expected:X} and reads 0x{actual:X}"
                )
            }
        }
    }
}

impl core::error::Error for SetUpError {}

#[cfg(test)]
mod tests {
    use std::format;

    use super::*;

    #[test]
    fn a_set_up_that_stops_says_where_and_why() {
        let address = ObjectAddress::new(0x1017, 0);
        let (expected, actual) = (0x64, 0xC8);
        let code = AbortCode::VALUE_RANGE;
        let error = WidthError {
            expected: 2,
            actual: 4,
        };
        let golden = [
            (
                SetUpError::Identity {
                    address,
                    expected,
                    actual,
                },
                "this is another drive or firmware: 1017h:00 should be 0x64, it is 0xC8".into(),
            ),
            (
                SetUpError::Differs {
                    address,
                    expected,
                    actual,
                },
                "1017h:00 must be 0x64, it is 0xC8".into(),
            ),
            (
                SetUpError::Refused { address, code },
                format!("the drive refuses 1017h:00: {code}"),
            ),
            (
                SetUpError::Silent { address },
                "no answer about 1017h:00".into(),
            ),
            (
                SetUpError::Width { address, error },
                "1017h:00: the object has 2 bytes, got 4".into(),
            ),
            (
                SetUpError::NotTaken {
                    address,
                    expected,
                    actual,
                },
                "1017h:00 was written as 0x64 and reads 0xC8".into(),
            ),
            (
                SetUpError::TooManySteps {
                    most: 254,
                    actual: 300,
                },
                "a set-up has at most 254 steps, this one has 300: divide it".into(),
            ),
        ];
        for (error, text) in golden {
            assert_eq!(format!("{error}"), text);
        }
    }
}
