//! The revisions of the CAN specification.

use core::fmt;

/// A published revision of the CAN specification.
///
/// A drive does not tell its revision, but the length of its Read_Param_Group3 reply does
/// ([`Revision::from_group3_reply_len`], D62).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Revision {
    /// 1.2A of 2018.
    V1_2A,
    /// 1.6A of 2026.
    V1_6A,
}

impl Revision {
    /// The revision that sends a Read_Param_Group3 reply of this length: 5 bytes in 1.2A, 6 in 1.6A.
    #[must_use]
    pub const fn from_group3_reply_len(len: usize) -> Option<Self> {
        match len {
            5 => Some(Self::V1_2A),
            6 => Some(Self::V1_6A),
            _ => None,
        }
    }
}

impl fmt::Display for Revision {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::V1_2A => "1.2A",
            Self::V1_6A => "1.6A",
        })
    }
}
