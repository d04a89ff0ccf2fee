//! A classic CAN frame, and the order in which frames win arbitration.
//!
//! Specification: at most 8 data bytes; an identifier of 11 bits (standard) or 29 bits (extended); a remote frame has a length code but no data;
//! the frame with the first dominant (0) bit in its arbitration field wins (Bosch CAN 2.0 B, sections 3.1 and 3.2.1).

use core::fmt;

use embedded_can::{ExtendedId, Id};

/// Most data bytes in one classic CAN frame.
pub const MAX_DATA_BYTES: usize = 8;

/// Bits of an extended identifier behind its 11 base bits.
pub(crate) const EXTENSION_BITS: u32 = 18;

/// A classic CAN data or remote frame.
///
/// Bytes behind the data length are always zero, so equality is equality on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Frame {
    id: Id,
    remote: bool,
    dlc: u8,
    data: [u8; MAX_DATA_BYTES],
}

impl Frame {
    /// The arbitration field as it goes over the wire, most significant bit first: the smaller number wins.
    ///
    /// Base identifier (11 bits), RTR or SRR, IDE, identifier extension (18 bits), RTR of an extended frame. A standard frame has zeros
    /// behind IDE. The order agrees with that of [`embedded_can::Id`] and also ranks a data frame above the remote frame of its identifier.
    pub fn arbitration_field(&self) -> u32 {
        let remote = u32::from(self.remote);
        match self.id {
            Id::Standard(id) => u32::from(id.as_raw()) << 21 | remote << 20,
            Id::Extended(id) => {
                u32::from(id.standard_id().as_raw()) << 21
                    | 0b11 << 19
                    | extension(id) << 1
                    | remote
            }
        }
    }

    /// Number of data bytes that go over the wire: 0..=8, always 0 for a remote frame.
    pub fn data_bytes(&self) -> usize {
        if self.remote {
            0
        } else {
            usize::from(self.dlc)
        }
    }

    /// The data length code, 0..=8, as it stands in the control field.
    pub(crate) fn length_code(&self) -> u8 {
        self.dlc
    }

    /// The data right-aligned in a big-endian number: the last data byte is the least significant.
    pub(crate) fn data_bits(&self) -> u64 {
        match self.data_bytes() {
            0 => 0,
            bytes => u64::from_be_bytes(self.data) >> (64 - 8 * bytes),
        }
    }
}

/// The 18 identifier bits behind the base identifier.
pub(crate) fn extension(id: ExtendedId) -> u32 {
    id.as_raw() & ((1 << EXTENSION_BITS) - 1)
}

impl embedded_can::Frame for Frame {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        let mut bytes = [0; MAX_DATA_BYTES];
        bytes.get_mut(..data.len())?.copy_from_slice(data);
        let dlc = u8::try_from(data.len()).ok()?;
        Some(Self {
            id: id.into(),
            remote: false,
            dlc,
            data: bytes,
        })
    }

    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        let dlc = u8::try_from(dlc)
            .ok()
            .filter(|dlc| usize::from(*dlc) <= MAX_DATA_BYTES)?;
        Some(Self {
            id: id.into(),
            remote: true,
            dlc,
            data: [0; MAX_DATA_BYTES],
        })
    }

    fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }

    fn is_remote_frame(&self) -> bool {
        self.remote
    }

    fn id(&self) -> Id {
        self.id
    }

    fn dlc(&self) -> usize {
        usize::from(self.dlc)
    }

    fn data(&self) -> &[u8] {
        &self.data[..self.data_bytes()]
    }
}

/// As the Linux tool `candump` writes it: `03C#FF88`, `0000003C#` (extended), `03C#R` or `03C#R4` (remote).
impl fmt::Display for Frame {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.id {
            Id::Standard(id) => write!(f, "{:03X}#", id.as_raw())?,
            Id::Extended(id) => write!(f, "{:08X}#", id.as_raw())?,
        }
        match (self.remote, self.dlc) {
            (true, 0) => f.write_str("R"),
            (true, dlc) => write!(f, "R{dlc}"),
            (false, _) => self.data[..self.data_bytes()]
                .iter()
                .try_for_each(|byte| write!(f, "{byte:02X}")),
        }
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use embedded_can::{Frame as _, StandardId};

    pub(crate) fn standard(id: u16, data: &[u8]) -> Frame {
        Frame::new(StandardId::new(id).unwrap(), data).unwrap()
    }

    pub(crate) fn extended(id: u32, data: &[u8]) -> Frame {
        Frame::new(ExtendedId::new(id).unwrap(), data).unwrap()
    }

    pub(crate) fn remote(id: u16, dlc: usize) -> Frame {
        Frame::new_remote(StandardId::new(id).unwrap(), dlc).unwrap()
    }

    #[test]
    fn text_is_that_of_candump() {
        assert_eq!(standard(0x03C, &[0xFF, 0x88]).to_string(), "03C#FF88");
        assert_eq!(standard(0x7FF, &[]).to_string(), "7FF#");
        assert_eq!(remote(0x03C, 0).to_string(), "03C#R");
        assert_eq!(remote(0x03C, 4).to_string(), "03C#R4");
        assert_eq!(extended(0x3C, &[1]).to_string(), "0000003C#01");
    }

    #[test]
    fn too_long_is_refused() {
        let id = StandardId::ZERO;
        assert!(Frame::new(id, &[0; 8]).is_some());
        assert_eq!(Frame::new(id, &[0; 9]), None);
        assert!(Frame::new_remote(id, 8).is_some());
        assert_eq!(Frame::new_remote(id, 9), None);
        assert_eq!(Frame::new_remote(id, 256), None);
    }

    #[test]
    fn remote_frame_has_a_length_but_no_data() {
        let frame = remote(0x10, 5);
        assert_eq!(
            (frame.dlc(), frame.data_bytes(), frame.data()),
            (5, 0, &[][..])
        );
    }

    #[test]
    fn arbitration_ranks_data_remote_standard_extended() {
        let base = 0x123;
        let in_order = [
            standard(base - 1, &[]),
            standard(base, &[9]),
            remote(base, 0),
            extended(u32::from(base) << 18, &[]),
            extended(u32::from(base) << 18 | 1, &[]),
            standard(base + 1, &[]),
        ];
        assert!(in_order.is_sorted_by(|a, b| a.arbitration_field() < b.arbitration_field()));
    }

    #[test]
    fn arbitration_field_golden() {
        assert_eq!(standard(0x7FF, &[]).arbitration_field(), 0xFFE0_0000);
        assert_eq!(remote(0, 0).arbitration_field(), 0x0010_0000);
        assert_eq!(extended(0x1FFF_FFFF, &[]).arbitration_field(), 0xFFFF_FFFE);
        assert_eq!(extended(0, &[]).arbitration_field(), 0x0018_0000);
    }
}
