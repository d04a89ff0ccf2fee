//! A frame, as the library has it (`TPCANMsg` in PCANBasic.h).

/// A classic CAN frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[repr(C)]
pub struct Message {
    /// Identifier of 11 or 29 bits.
    pub id: u32,
    kind: u8,
    length: u8,
    data: [u8; 8],
}

/// Bits of the kind (`TPCANMessageType`).
const REMOTE: u8 = 0x01;
const EXTENDED: u8 = 0x02;

impl Message {
    /// A data frame; `None` with more than eight bytes.
    #[must_use]
    pub fn new(id: u32, is_extended: bool, bytes: &[u8]) -> Option<Self> {
        let mut data = [0; 8];
        data.get_mut(..bytes.len())?.copy_from_slice(bytes);
        Some(Self {
            id,
            kind: if is_extended { EXTENDED } else { 0 },
            length: bytes.len() as u8,
            data,
        })
    }

    /// A remote frame that asks for so many bytes; `None` with more than eight.
    #[must_use]
    pub fn new_remote(id: u32, is_extended: bool, length: usize) -> Option<Self> {
        let frame = Self::new(id, is_extended, [0; 8].get(..length)?)?;
        Some(Self {
            kind: frame.kind | REMOTE,
            ..frame
        })
    }

    /// The identifier has 29 bits.
    #[must_use]
    pub const fn is_extended(&self) -> bool {
        self.kind & EXTENDED != 0
    }

    /// It asks for data.
    #[must_use]
    pub const fn is_remote(&self) -> bool {
        self.kind & REMOTE != 0
    }

    /// Neither a status of the adapter nor an error nor an echo.
    pub(crate) const fn is_frame(&self) -> bool {
        self.kind & !(REMOTE | EXTENDED) == 0 && self.length <= 8
    }

    /// Number of bytes that it carries or asks for.
    #[must_use]
    pub const fn length(&self) -> usize {
        self.length as usize
    }

    /// The bytes; none in a remote frame.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        let length = if self.is_remote() { 0 } else { self.length() };
        self.data.get(..length).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use core::mem::{align_of, offset_of, size_of};

    use super::*;

    #[test]
    fn the_layout_is_that_of_the_header() {
        // DWORD ID; BYTE MSGTYPE; BYTE LEN; BYTE DATA[8].
        assert_eq!((size_of::<Message>(), align_of::<Message>()), (16, 4));
        let places = [
            offset_of!(Message, id),
            offset_of!(Message, kind),
            offset_of!(Message, length),
            offset_of!(Message, data),
        ];
        assert_eq!(places, [0, 4, 5, 6]);
    }

    #[test]
    fn a_frame_has_at_most_eight_bytes() {
        assert_eq!(Message::new(1, false, &[0; 9]), None);
        assert_eq!(Message::new_remote(1, false, 9), None);
        let remote = Message::new_remote(0x123, true, 4).unwrap();
        assert!(remote.is_remote() && remote.is_extended() && remote.is_frame());
        assert_eq!((remote.length(), remote.data()), (4, &[][..]));
    }
}
