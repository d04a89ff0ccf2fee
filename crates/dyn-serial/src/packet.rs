//! Packet: start byte, length and function code, one to four data bytes, checksum (manual section 7.2).

use core::fmt;

use crate::address::Address;
use crate::error::PacketError;
use crate::groups::{self, Groups, MARK};

/// Bytes of the shortest packet.
pub const MIN_PACKET: usize = 4;

/// Bytes of the longest packet.
pub const MAX_PACKET: usize = 7;

/// Bits 6..5 of the second byte: number of data bytes - 1.
const LENGTH_SHIFT: u8 = 5;
const LENGTH_MASK: u8 = 0b11;

/// Bits 4..0 of the second byte: function code.
const CODE_MASK: u8 = 0x1F;

/// Bytes of the packet whose second byte this is.
pub(crate) const fn announced_len(second: u8) -> usize {
    MIN_PACKET + (second >> LENGTH_SHIFT & LENGTH_MASK) as usize
}

/// A packet that is right as far as its form goes: 4 to 7 bytes with the right marks, length and checksum.
///
/// What it means depends on its direction: [`Request::decode`](crate::Request::decode) or
/// [`Reply::decode`](crate::Reply::decode).
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct Packet([u8; MAX_PACKET]);

impl Packet {
    /// `code` has at most 5 bits.
    pub(crate) fn compose(address: Address, code: u8, data: Groups) -> Self {
        let second = MARK | (data.len - 1) << LENGTH_SHIFT | code;
        let [a, b, c, d] = data.bytes;
        let mut packet = Self([address.start_byte(), second, a, b, c, d, 0]);
        let (sum, last) = (packet.checksum(), packet.last());
        if let Some(last) = packet.0.get_mut(last) {
            *last = sum;
        }
        packet
    }

    /// A packet from bytes that have the right marks and zeros behind the announced length.
    ///
    /// # Errors
    /// The last byte that would fit the others.
    pub(crate) fn with_checksum(bytes: [u8; MAX_PACKET]) -> Result<Self, u8> {
        let packet = Self(bytes);
        let expected = packet.checksum();
        if packet.0.get(packet.last()) == Some(&expected) {
            Ok(packet)
        } else {
            Err(expected)
        }
    }

    /// Place of the last byte.
    const fn last(&self) -> usize {
        let [_, second, ..] = self.0;
        announced_len(second) - 1
    }

    /// The last byte that fits those before it.
    fn checksum(&self) -> u8 {
        let before = self.0.iter().take(self.last());
        before.fold(0_u8, |sum, byte| sum.wrapping_add(*byte)) | MARK
    }

    /// The packet that these bytes are, no more and no less of them.
    ///
    /// # Errors
    /// [`PacketError`] with the first thing that is wrong.
    pub fn parse(bytes: &[u8]) -> Result<Self, PacketError> {
        let Some((start, inner)) = bytes.split_first() else {
            return Err(wrong_length(MIN_PACKET, bytes));
        };
        if *start >= MARK {
            return Err(PacketError::StartByte { actual: *start });
        }
        if let Some(index) = inner.iter().position(|byte| *byte < MARK) {
            let actual = inner.get(index).copied().unwrap_or_default();
            let index = index + 1;
            return Err(PacketError::InnerByte { index, actual });
        }
        let expected = inner
            .first()
            .map_or(MIN_PACKET, |byte| announced_len(*byte));
        if bytes.len() != expected {
            return Err(wrong_length(expected, bytes));
        }
        let mut packet = [0; MAX_PACKET];
        for (to, from) in packet.iter_mut().zip(bytes) {
            *to = *from;
        }
        Self::with_checksum(packet).map_err(|expected| PacketError::Checksum {
            expected,
            actual: bytes.last().copied().unwrap_or_default(),
        })
    }

    /// The bytes on the wire, 4 to 7 of them.
    #[must_use]
    pub fn as_bytes(&self) -> &[u8] {
        self.0.get(..=self.last()).unwrap_or(&self.0)
    }

    /// The first byte: a drive id, the general id, or a reserved id.
    #[must_use]
    pub const fn start_byte(&self) -> u8 {
        let [start, ..] = self.0;
        start
    }

    /// The function code, 0 ..= 0x1F.
    #[must_use]
    pub const fn code(&self) -> u8 {
        let [_, second, ..] = self.0;
        second & CODE_MASK
    }

    /// Number of data bytes, 1 ..= 4.
    #[must_use]
    pub const fn data_len(&self) -> u8 {
        let [_, second, ..] = self.0;
        (second >> LENGTH_SHIFT & LENGTH_MASK) + 1
    }

    /// The data bytes as they are on the wire, with bit 7 set.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        let [_, _, data @ .., _] = &self.0;
        data.get(..usize::from(self.data_len())).unwrap_or(data)
    }

    /// The data as a signed number, -2^27 ..= 2^27 - 1.
    #[must_use]
    pub fn signed(&self) -> i32 {
        groups::signed(self.data())
    }

    /// The data as an unsigned number, 0 ..= 2^28 - 1.
    #[must_use]
    pub fn unsigned(&self) -> u32 {
        groups::unsigned(self.data())
    }
}

fn wrong_length(expected: usize, bytes: &[u8]) -> PacketError {
    PacketError::Length {
        expected,
        actual: bytes.len(),
    }
}

impl fmt::Display for Packet {
    /// `08 8A B2 C4`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write_bytes(f, self.as_bytes())
    }
}

impl fmt::Debug for Packet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Packet({self})")
    }
}

#[cfg(feature = "defmt")]
impl defmt::Format for Packet {
    fn format(&self, f: defmt::Formatter<'_>) {
        defmt::write!(f, "{=[u8]:02X}", self.as_bytes());
    }
}

pub(crate) fn write_bytes(f: &mut fmt::Formatter<'_>, bytes: &[u8]) -> fmt::Result {
    for (index, byte) in bytes.iter().enumerate() {
        let gap = if index == 0 { "" } else { " " };
        write!(f, "{gap}{byte:02X}")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::address::DriveId;
    use std::string::ToString;

    /// Manual section 7.2.6: drive 8 at 50 rpm.
    const AT_50_RPM: [u8; 4] = [0x08, 0x8A, 0xB2, 0xC4];

    #[test]
    fn the_example_of_the_packet_section_both_ways() {
        let drive = Address::Drive(DriveId::new(8).unwrap());
        let packet = Packet::compose(drive, 0x0A, Groups::signed(50));
        assert_eq!(packet.as_bytes(), AT_50_RPM);
        assert_eq!(Packet::parse(&AT_50_RPM), Ok(packet));
        assert_eq!((packet.start_byte(), packet.code()), (8, 0x0A));
        assert_eq!((packet.signed(), packet.unsigned()), (50, 50));
        assert_eq!(packet.to_string(), "08 8A B2 C4");
    }

    #[test]
    fn what_is_wrong_is_named_with_both_values() {
        let refused = |bytes: &[u8]| Packet::parse(bytes).unwrap_err();
        assert_eq!(
            refused(&[]),
            PacketError::Length {
                expected: 4,
                actual: 0
            }
        );
        assert_eq!(
            refused(&[0x08, 0xAA, 0xB2, 0xC4]),
            PacketError::Length {
                expected: 5,
                actual: 4
            }
        );
        assert_eq!(
            refused(&[0x88, 0x8A, 0xB2, 0xC4]),
            PacketError::StartByte { actual: 0x88 }
        );
        assert_eq!(
            refused(&[0x08, 0x8A, 0x32, 0xC4]),
            PacketError::InnerByte {
                index: 2,
                actual: 0x32
            }
        );
        assert_eq!(
            refused(&[0x08, 0x8A, 0xB2, 0xC5]),
            PacketError::Checksum {
                expected: 0xC4,
                actual: 0xC5
            }
        );
    }

    #[test]
    fn one_changed_bit_is_always_noticed() {
        for bit in 0..32 {
            let mut bytes = AT_50_RPM;
            bytes[bit / 8] ^= 1 << (bit % 8);
            assert!(Packet::parse(&bytes).is_err(), "bit {bit}");
        }
    }
}
