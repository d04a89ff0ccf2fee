//! Emergency messages and SYNC. The guide prints the same identifier for both (Z21).

use core::fmt;

use can_frame::DataFrame;

use crate::error::DecodeError;
use crate::frame::{compose, exactly, node_of};
use crate::node::{EMCY, NodeId, Service};

/// An emergency message (CiA 301): 8 bytes at 80h + node.
///
/// The guide describes no content. Error code 0 means that an error is gone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Emcy {
    /// Error code of CiA 301, or of the maker.
    pub error_code: u16,
    /// Error register 1001h; bit 0 is set with any error.
    pub error_register: u8,
    /// Five bytes of the maker, not described.
    pub manufacturer: [u8; 5],
}

impl Emcy {
    /// The frame of a drive.
    #[must_use]
    pub const fn encode(&self, node: NodeId) -> DataFrame {
        let [low, high] = self.error_code.to_le_bytes();
        let [a, b, c, d, e] = self.manufacturer;
        let bytes = [low, high, self.error_register, a, b, c, d, e];
        compose(Service::Emcy(node), 8, bytes)
    }

    /// An emergency message; no node when the drive sends on 080h, as the guide's default says (Z21).
    ///
    /// # Errors
    /// [`DecodeError`] for another service and for a length other than 8.
    pub const fn decode(frame: &DataFrame) -> Result<(Option<NodeId>, Self), DecodeError> {
        let node = match node_of(frame, EMCY) {
            Ok(node) => Some(node),
            Err(DecodeError::Node { .. }) => None,
            Err(error) => return Err(error),
        };
        let [low, high, error_register, a, b, c, d, e] = match exactly(frame, 8) {
            Ok(bytes) => bytes,
            Err(error) => return Err(error),
        };
        let message = Self {
            error_code: u16::from_le_bytes([low, high]),
            error_register,
            manufacturer: [a, b, c, d, e],
        };
        Ok((node, message))
    }
}

impl fmt::Display for Emcy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "emergency {:04X}h, error register {:02X}h, maker's bytes {:02X?}",
            self.error_code, self.error_register, self.manufacturer
        )
    }
}

/// SYNC, without the counter that came after CiA 301 4.02.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Sync;

impl Sync {
    /// The frame.
    #[must_use]
    pub const fn encode(self) -> DataFrame {
        compose(Service::Sync, 0, [0; 8])
    }

    /// A SYNC frame. Eight bytes on 080h are an emergency message and no SYNC (Z21).
    ///
    /// # Errors
    /// [`DecodeError`] for another service and for any data.
    pub const fn decode(frame: &DataFrame) -> Result<Self, DecodeError> {
        if frame.id() != Service::Sync.can_id() {
            return Err(DecodeError::Service { can_id: frame.id() });
        }
        match exactly(frame, 0) {
            Ok(_) => Ok(Self),
            Err(error) => Err(error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_emergency_message_is_never_a_sync() {
        let frame = DataFrame::new(0x080, &[0x10, 0x32, 0x05, 1, 2, 3, 4, 5]).unwrap();
        assert!(Sync::decode(&frame).is_err());
        let emcy = Emcy {
            error_code: 0x3210,
            error_register: 5,
            manufacturer: [1, 2, 3, 4, 5],
        };
        assert_eq!(Emcy::decode(&frame), Ok((None, emcy)));
        let own = emcy.encode(NodeId::FACTORY);
        assert_eq!(own.id(), 0x084);
        assert_eq!(Emcy::decode(&own), Ok((Some(NodeId::FACTORY), emcy)));
        assert_eq!(Sync::decode(&Sync.encode()), Ok(Sync));
        assert!(Emcy::decode(&Sync.encode()).is_err());
    }

    #[test]
    fn an_emergency_message_prints_all_that_it_has() {
        let emcy = Emcy {
            error_code: 0x3210,
            error_register: 5,
            manufacturer: [1, 2, 3, 4, 0xFF],
        };
        assert_eq!(
            std::format!("{emcy}"),
            "emergency 3210h, error register 05h, maker's bytes [01, 02, 03, 04, FF]"
        );
    }
}
