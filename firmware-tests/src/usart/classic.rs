//! The registers of the STM32F4's USART (RM0090, section 30.6).

use super::{COMPLETE, FRAMING_ERROR, IDLE, NOISE, OVERRUN, RECEIVED, Usart};

pub(super) const CR1_ENABLE: u32 = 1 << 13;
const CR1_OVERSAMPLING_8: u32 = 1 << 15;
/// Break, mute mode, parity, nine bits.
const CR1_NOT_MODELLED: u32 = 1 | 1 << 1 | 1 << 10 | 1 << 12;
/// Clock output, other stop bits, LIN.
const CR2_NOT_MODELLED: u32 = 1 << 11 | 0b11 << 12 | 1 << 14;
/// Infrared, single wire, smart card, flow control.
const CR3_NOT_MODELLED: u32 = 1 << 1 | 1 << 3 | 1 << 5 | 1 << 8 | 1 << 9;
/// Flags that go by a read of SR and a read of DR after it; parity is not modelled.
const READ_CLEARS: u32 = FRAMING_ERROR | NOISE | OVERRUN | IDLE;

/// 256ths of a clock in a bit; 0 for a divider below one (RM0090, section 30.3.4).
pub(super) fn bit_clocks(cr1: u32, baud: u32) -> u64 {
    let (mantissa, fraction) = (u64::from(baud >> 4 & 0xFFF), u64::from(baud & 0xF));
    if mantissa == 0 {
        0
    } else if cr1 & CR1_OVERSAMPLING_8 != 0 {
        256 * (8 * mantissa + (fraction & 7))
    } else {
        256 * (16 * mantissa + fraction)
    }
}

pub(super) fn not_modelled(cr1: u32, cr2: u32, cr3: u32) -> [u32; 3] {
    [
        cr1 & CR1_NOT_MODELLED,
        cr2 & CR2_NOT_MODELLED,
        cr3 & CR3_NOT_MODELLED,
    ]
}

impl Usart {
    pub(super) fn read_classic(&mut self, offset: u32) -> u32 {
        match offset {
            0x00 => {
                self.seen = self.flags();
                self.seen
            }
            0x04 => {
                self.status &= !(self.seen & READ_CLEARS);
                self.seen &= COMPLETE;
                self.fetch()
            }
            0x08 => self.baud,
            0x0C => self.cr1,
            0x10 => self.cr2,
            0x14 => self.cr3,
            0x18 => self.guard_time,
            _ => 0,
        }
    }

    pub(super) fn write_classic(&mut self, offset: u32, value: u32) {
        match offset {
            // Of the flags modelled these two are cleared by a 0.
            0x00 => {
                self.status &= value | !COMPLETE;
                if value & RECEIVED == 0 {
                    self.received.clear();
                }
            }
            0x04 => {
                // TC goes by a read of SR and a write of DR after it, not by the write alone.
                self.status &= !(self.seen & COMPLETE);
                self.seen &= !COMPLETE;
                self.put(value as u8);
            }
            0x08 => self.baud = value & 0xFFFF,
            0x0C => self.cr1 = value & 0xFFFF,
            0x10 => self.cr2 = value,
            0x14 => self.cr3 = value,
            0x18 => self.guard_time = value,
            _ => {}
        }
    }
}
