//! Order of bytes in a message.

/// Order of the bytes of a number (D18).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ByteOrder {
    /// Most significant byte first, as in the one example of the documents.
    MsbFirst,
    /// Least significant byte first.
    LsbFirst,
}
