//! The message memory of one controller: filters, receive FIFOs, transmit buffers (RM0440, sections 44.3.7 to 44.3.10).

use drive_sim::Frame;
use embedded_can::{ExtendedId, Frame as _, Id, StandardId};

/// Words of the memory of one controller.
const WORDS: usize = 212;
/// First words of its parts.
const RECEIVE: [usize; 2] = [0xB0 / 4, 0x188 / 4];
const TRANSMIT: usize = 0x278 / 4;
/// Words of an element of a FIFO.
const ELEMENT: usize = 18;
/// Marks of extended and remote frames in the first word of an element.
const EXTENDED: u32 = 1 << 30;
const REMOTE: u32 = 1 << 29;

/// Where a received frame goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Target {
    /// Into this receive FIFO.
    Fifo(usize),
    /// Nowhere.
    Rejected,
}

/// The memory. After power-on it holds anything.
#[derive(Debug, Clone)]
pub(super) struct Memory([u32; WORDS]);

impl Default for Memory {
    fn default() -> Self {
        Self([0xA5A5_A5A5; WORDS])
    }
}

impl Memory {
    /// All of it.
    pub(super) fn words(&mut self) -> &mut [u32] {
        &mut self.0
    }

    /// The frame in a transmit buffer. A length code of 9 to 15 sends eight bytes.
    pub(super) fn to_send(&self, place: usize) -> Frame {
        let first = TRANSMIT + place * ELEMENT;
        let [header, control, low, high] = [0, 1, 2, 3].map(|word| self.0[first + word]);
        let id = if header & EXTENDED != 0 {
            Id::Extended(ExtendedId::new(header & 0x1FFF_FFFF).unwrap_or(ExtendedId::MAX))
        } else {
            Id::Standard(StandardId::new((header >> 18 & 0x7FF) as u16).unwrap_or(StandardId::MAX))
        };
        let length = (control as usize >> 16 & 0xF).min(8);
        let data = (u64::from(high) << 32 | u64::from(low)).to_le_bytes();
        let frame = if header & REMOTE != 0 {
            Frame::new_remote(id, length)
        } else {
            Frame::new(id, &data[..length])
        };
        frame.expect("identifier and length were masked")
    }

    /// Stores a received frame in an element of a FIFO.
    pub(super) fn store(&mut self, fifo: usize, element: usize, frame: &Frame) {
        let id = match frame.id() {
            Id::Standard(id) => u32::from(id.as_raw()) << 18,
            Id::Extended(id) => id.as_raw() | EXTENDED,
        };
        let remote = if frame.is_remote_frame() { REMOTE } else { 0 };
        let mut data = [0; 8];
        data[..frame.data().len()].copy_from_slice(frame.data());
        let [low, high] = [0, 4]
            .map(|at| u32::from_le_bytes([data[at], data[at + 1], data[at + 2], data[at + 3]]));
        let first = RECEIVE[fifo] + element * ELEMENT;
        let words = [id | remote, (frame.dlc() as u32) << 16, low, high];
        self.0[first..first + words.len()].copy_from_slice(&words);
    }

    /// What filters and global filter say of a frame. Filters of extended identifiers are not modelled: such frames match none.
    pub(super) fn target(&self, frame: &Frame, global: u32) -> Target {
        // RXGFC: reject remote frames, what matches no filter, number of standard filters.
        let bits = |at: u32, count: u32| global >> at & ((1 << count) - 1);
        let (id, unmatched) = match frame.id() {
            Id::Extended(_) if frame.is_remote_frame() && bits(0, 1) == 1 => {
                return Target::Rejected;
            }
            Id::Standard(_) if frame.is_remote_frame() && bits(1, 1) == 1 => {
                return Target::Rejected;
            }
            Id::Extended(_) => (None, bits(2, 2)),
            Id::Standard(id) => (Some(u32::from(id.as_raw())), bits(4, 2)),
        };
        let filters = &self.0[..bits(16, 5) as usize];
        let first = id.and_then(|id| filters.iter().find(|&&filter| matches(filter, id)));
        match first.map(|filter| filter >> 27 & 7) {
            Some(1) => Target::Fifo(0),
            Some(2) => Target::Fifo(1),
            Some(_) => Target::Rejected,
            None => match unmatched {
                0 => Target::Fifo(0),
                1 => Target::Fifo(1),
                _ => Target::Rejected,
            },
        }
    }
}

/// Range, two identifiers, or identifier and mask; one that is switched off matches nothing.
fn matches(filter: u32, id: u32) -> bool {
    let (first, second) = (filter >> 16 & 0x7FF, filter & 0x7FF);
    if filter >> 27 & 7 == 0 {
        return false;
    }
    match filter >> 30 {
        0 => (first..=second).contains(&id),
        1 => id == first || id == second,
        2 => (id ^ first) & second == 0,
        _ => false,
    }
}
