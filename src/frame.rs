//! The frames of the drives' bus, as the controllers take them.

use embedded_can::{Id, StandardId};

/// Most data bytes of a frame; a data length code of 9 to 15 on the wire also means 8 (ISO 11898-1, section 8.4.2.4).
pub(crate) const MAX_DATA_BYTES: usize = 8;

/// A data frame with a standard identifier: the protocol of the drives has no other, and the filters pass no other.
#[derive(Clone, Copy)]
pub(crate) struct Frame {
    id: StandardId,
    length: u8,
    bytes: [u8; MAX_DATA_BYTES],
}

impl Frame {
    /// From what the registers of a controller hold: `id` has 11 bits, `length` is the data length code, `words` the data bytes in
    /// the order of the wire, the first one lowest.
    pub(crate) fn from_registers(id: u16, length: u8, words: [u32; 2]) -> Self {
        let [[a, b, c, d], [e, f, g, h]] = words.map(u32::to_le_bytes);
        Self {
            // Higher bits than those of an identifier do not exist in the register.
            id: StandardId::new(id).unwrap_or(StandardId::ZERO),
            length: length.min(MAX_DATA_BYTES as u8),
            bytes: [a, b, c, d, e, f, g, h],
        }
    }

    /// The identifier.
    pub(crate) fn standard_id(&self) -> u16 {
        self.id.as_raw()
    }

    /// The data length code.
    pub(crate) const fn length(&self) -> u8 {
        self.length
    }

    /// The data bytes as the registers take them.
    pub(crate) const fn words(&self) -> [u32; 2] {
        let [a, b, c, d, e, f, g, h] = self.bytes;
        [
            u32::from_le_bytes([a, b, c, d]),
            u32::from_le_bytes([e, f, g, h]),
        ]
    }
}

impl embedded_can::Frame for Frame {
    /// `None` for an extended identifier and for more than 8 bytes.
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        let Id::Standard(id) = id.into() else {
            return None;
        };
        let mut bytes = [0; MAX_DATA_BYTES];
        bytes.get_mut(..data.len())?.copy_from_slice(data);
        Some(Self {
            id,
            length: data.len() as u8,
            bytes,
        })
    }

    /// `None`: there are none in the protocol.
    fn new_remote(_id: impl Into<Id>, _dlc: usize) -> Option<Self> {
        None
    }

    fn is_extended(&self) -> bool {
        false
    }

    fn is_remote_frame(&self) -> bool {
        false
    }

    fn id(&self) -> Id {
        Id::Standard(self.id)
    }

    fn dlc(&self) -> usize {
        usize::from(self.length)
    }

    fn data(&self) -> &[u8] {
        // The length is at most that of the buffer.
        self.bytes.get(..self.dlc()).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use embedded_can::{ExtendedId, Frame as _};

    use super::*;

    #[test]
    fn registers_hold_the_bytes_in_the_order_of_the_wire() {
        let id = StandardId::new(0x03C).unwrap();
        let frame = Frame::new(id, &[1, 2, 3, 4, 5]).unwrap();
        assert_eq!(frame.words(), [0x0403_0201, 0x0000_0005]);
        let read = Frame::from_registers(frame.standard_id(), frame.length(), frame.words());
        assert_eq!((read.id(), read.data()), (Id::Standard(id), frame.data()));
    }

    #[test]
    fn a_length_code_above_8_means_8() {
        let frame = Frame::from_registers(1, 15, [u32::MAX; 2]);
        assert_eq!(frame.data(), [0xFF; 8]);
    }

    #[test]
    fn only_standard_data_frames_of_at_most_8_bytes_are_made() {
        let id = StandardId::new(1).unwrap();
        assert!(Frame::new(ExtendedId::new(1).unwrap(), &[]).is_none());
        assert!(Frame::new(id, &[0; 9]).is_none());
        assert!(Frame::new_remote(id, 0).is_none());
    }
}
