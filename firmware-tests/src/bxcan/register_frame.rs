//! Frames as the registers hold them (RM0090, sections 32.9.3 and 32.9.4).

use drive_sim::Frame;
use embedded_can::{ExtendedId, Frame as _, Id, StandardId};

const EXTENDED: u32 = 1 << 2;
const REMOTE: u32 = 1 << 1;

/// Identifier, length and data registers.
pub(super) type Registers = [u32; 4];

/// The identifier register of a frame, without the transmission request.
#[must_use]
pub(super) fn identifier_register(frame: &Frame) -> u32 {
    let id = match frame.id() {
        Id::Standard(id) => u32::from(id.as_raw()) << 21,
        Id::Extended(id) => id.as_raw() << 3 | EXTENDED,
    };
    id | if frame.is_remote_frame() { REMOTE } else { 0 }
}

/// The bits of a frame that a 16-bit filter sees: base identifier, RTR, IDE, three bits of the extension.
#[must_use]
pub(super) fn filter16(frame: &Frame) -> u32 {
    let (base, extension, extended) = match frame.id() {
        Id::Standard(id) => (u32::from(id.as_raw()), 0, 0),
        Id::Extended(id) => (id.as_raw() >> 18, id.as_raw() >> 15 & 7, 1),
    };
    base << 5 | u32::from(frame.is_remote_frame()) << 4 | extended << 3 | extension
}

/// The registers of a received frame.
#[must_use]
pub(super) fn to_registers(frame: &Frame) -> Registers {
    let mut data = [0; 8];
    data[..frame.data().len()].copy_from_slice(frame.data());
    let [low, high] =
        [0, 4].map(|at| u32::from_le_bytes([data[at], data[at + 1], data[at + 2], data[at + 3]]));
    [identifier_register(frame), frame.dlc() as u32, low, high]
}

/// The frame that a mailbox sends. A length code of 9 to 15 sends eight bytes.
#[must_use]
pub(super) fn from_registers(registers: &Registers) -> Frame {
    let [identifier, length, low, high] = *registers;
    let length = (length as usize & 0xF).min(8);
    let id = if identifier & EXTENDED != 0 {
        Id::Extended(ExtendedId::new(identifier >> 3).unwrap_or(ExtendedId::MAX))
    } else {
        Id::Standard(StandardId::new((identifier >> 21) as u16).unwrap_or(StandardId::MAX))
    };
    let data = (u64::from(high) << 32 | u64::from(low)).to_le_bytes();
    let frame = if identifier & REMOTE != 0 {
        Frame::new_remote(id, length)
    } else {
        Frame::new(id, &data[..length])
    };
    frame.expect("identifier and length were masked")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_survives_the_registers() {
        let id = StandardId::new(0x03C).unwrap();
        let frame = Frame::new(id, &[0xFF, 0x88]).unwrap();
        assert_eq!(to_registers(&frame), [0x0780_0000, 2, 0x88FF, 0]);
        assert_eq!(from_registers(&to_registers(&frame)), frame);
        let id = ExtendedId::new(0x1234_5678).unwrap();
        for frame in [
            Frame::new(id, &[7; 8]).unwrap(),
            Frame::new_remote(id, 3).unwrap(),
        ] {
            assert_eq!(from_registers(&to_registers(&frame)), frame);
        }
    }
}
