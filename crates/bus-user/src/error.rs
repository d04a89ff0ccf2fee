//! Errors that a controller reports.

/// What the controller reports of the bus, after `embedded_can::ErrorKind`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum BusErrorKind {
    /// The receive buffer overran: replies were lost.
    Overrun,
    /// A bit was read back differently.
    Bit,
    /// The stuffing rule was broken.
    Stuff,
    /// A checksum was wrong.
    Crc,
    /// A fixed bit was wrong.
    Form,
    /// Nobody acknowledged.
    Acknowledge,
    /// Something else.
    Other,
}

impl From<embedded_can::ErrorKind> for BusErrorKind {
    fn from(kind: embedded_can::ErrorKind) -> Self {
        match kind {
            embedded_can::ErrorKind::Overrun => Self::Overrun,
            embedded_can::ErrorKind::Bit => Self::Bit,
            embedded_can::ErrorKind::Stuff => Self::Stuff,
            embedded_can::ErrorKind::Crc => Self::Crc,
            embedded_can::ErrorKind::Form => Self::Form,
            embedded_can::ErrorKind::Acknowledge => Self::Acknowledge,
            _ => Self::Other,
        }
    }
}
