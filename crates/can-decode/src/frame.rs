//! A classic CAN frame as a log or an interface reports it.

use core::fmt;

/// Most data bytes of a classic CAN frame.
pub const MAX_DATA_BYTES: usize = 8;

/// Largest identifiers: 11 bits, 29 bits.
pub const MAX_STANDARD_ID: u32 = 0x7FF;
/// The largest 29-bit identifier.
pub const MAX_EXTENDED_ID: u32 = 0x1FFF_FFFF;

/// A classic CAN data or remote frame; the bytes behind its data are zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Frame {
    id: u32,
    extended: bool,
    remote: bool,
    len: u8,
    data: [u8; MAX_DATA_BYTES],
}

impl Frame {
    /// A data frame; `None` for an identifier beyond 11 (or 29) bits or more than 8 bytes.
    #[must_use]
    pub fn new(id: u32, extended: bool, data: &[u8]) -> Option<Self> {
        let mut bytes = [0; MAX_DATA_BYTES];
        bytes.get_mut(..data.len())?.copy_from_slice(data);
        fits(id, extended).then_some(Self {
            id,
            extended,
            remote: false,
            len: data.len() as u8,
            data: bytes,
        })
    }

    /// A remote frame that asks for `len` bytes; `None` for an identifier or a length that do not exist.
    #[must_use]
    pub fn remote(id: u32, extended: bool, len: u8) -> Option<Self> {
        (fits(id, extended) && usize::from(len) <= MAX_DATA_BYTES).then_some(Self {
            id,
            extended,
            remote: true,
            len,
            data: [0; MAX_DATA_BYTES],
        })
    }

    /// The frame of a CAN driver or of the virtual bus; `None` only for what no classic frame can be.
    #[must_use]
    pub fn from_can(frame: &impl embedded_can::Frame) -> Option<Self> {
        let (id, extended) = match frame.id() {
            embedded_can::Id::Standard(id) => (u32::from(id.as_raw()), false),
            embedded_can::Id::Extended(id) => (id.as_raw(), true),
        };
        if frame.is_remote_frame() {
            Self::remote(id, extended, u8::try_from(frame.dlc()).ok()?)
        } else {
            Self::new(id, extended, frame.data())
        }
    }

    /// The identifier, 11 or 29 bits.
    #[must_use]
    pub const fn id(&self) -> u32 {
        self.id
    }

    /// Whether the identifier has 29 bits.
    #[must_use]
    pub const fn is_extended(&self) -> bool {
        self.extended
    }

    /// Whether it asks for data instead of carrying it.
    #[must_use]
    pub const fn is_remote(&self) -> bool {
        self.remote
    }

    /// The data; none for a remote frame.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        let len = if self.remote {
            0
        } else {
            usize::from(self.len)
        };
        self.data.get(..len).unwrap_or(&self.data)
    }

    /// Data bytes that it carries, or asks for when it is a remote frame.
    #[must_use]
    pub const fn len(&self) -> u8 {
        self.len
    }

    /// Whether it neither carries data nor asks for any.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Length in bits without stuff bits, interframe space included: the least that the frame costs the bus.
    #[must_use]
    pub fn least_bits(&self) -> u32 {
        let frame_bits = if self.extended { 67 } else { 47 };
        frame_bits + 8 * self.data().len() as u32
    }
}

fn fits(id: u32, extended: bool) -> bool {
    id <= if extended {
        MAX_EXTENDED_ID
    } else {
        MAX_STANDARD_ID
    }
}

/// Identifier and data as `03C FF 88`, a 29-bit identifier with eight digits, a remote frame as `03C R4`.
impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = Text::default();
        text.push_hex(self.id, if self.extended { 8 } else { 3 });
        if self.remote {
            text.push_bytes(b" R");
            text.push_hex(u32::from(self.len), 1);
        }
        for &byte in self.data() {
            text.push_bytes(b" ");
            text.push_hex(u32::from(byte), 2);
        }
        f.pad(text.as_str())
    }
}

/// A short text without a heap: eight digits and eight times three bytes.
#[derive(Default)]
struct Text {
    bytes: [u8; 32],
    len: usize,
}

impl Text {
    fn push_bytes(&mut self, bytes: &[u8]) {
        if let Some(free) = self.bytes.get_mut(self.len..self.len + bytes.len()) {
            free.copy_from_slice(bytes);
            self.len += bytes.len();
        }
    }

    fn push_hex(&mut self, value: u32, digits: u32) {
        for place in (0..digits).rev() {
            let digit = (value >> (4 * place)) & 0xF;
            self.push_bytes(&[b"0123456789ABCDEF"[digit as usize]]);
        }
    }

    fn as_str(&self) -> &str {
        // Only ASCII was pushed.
        core::str::from_utf8(&self.bytes[..self.len]).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_no_classic_frame_can_be_is_refused() {
        assert!(Frame::new(0x7FF, false, &[0; 8]).is_some());
        assert_eq!(Frame::new(0x800, false, &[]), None);
        assert_eq!(Frame::new(0x2000_0000, true, &[]), None);
        assert_eq!(Frame::new(1, false, &[0; 9]), None);
        assert_eq!(Frame::remote(1, false, 9), None);
    }

    #[test]
    fn text_is_identifier_and_bytes() {
        let text = |frame: Option<Frame>| frame.map(|frame| frame.to_string()).unwrap_or_default();
        assert_eq!(text(Frame::new(0x3C, false, &[0xFF, 0x88])), "03C FF 88");
        assert_eq!(text(Frame::new(0x3C, true, &[1])), "0000003C 01");
        assert_eq!(text(Frame::remote(0x3C, false, 4)), "03C R4");
        let longest = Frame::new(0x1FFF_FFFF, true, &[0xAB; 8]);
        assert_eq!(text(longest), "1FFFFFFF AB AB AB AB AB AB AB AB");
    }
}
