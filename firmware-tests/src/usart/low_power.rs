//! The registers of the STM32G4's LPUART (RM0440, section 38.7).

use super::{COMPLETE, CR1_RECEIVE, CR1_TRANSMIT, FRAMING_ERROR, IDLE, NOISE, OVERRUN, Usart};

pub(super) const CR1_ENABLE: u32 = 1;
pub(super) const CR1_FIFO: u32 = 1 << 29;
/// Parity, other lengths, mute mode, character match, interrupts of FIFO levels.
const CR1_NOT_MODELLED: u32 = 1 << 10 | 1 << 12 | 1 << 13 | 1 << 14 | 1 << 28 | 1 << 30 | 1 << 31;
/// Other stop bits, swapped or inverted pins, inverted data, most significant bit first.
const CR2_NOT_MODELLED: u32 = 0b11 << 12 | 0b1_1111 << 15;
/// Single wire, flow control, no overrun, DMA off by an error, driver enable, FIFO thresholds.
const CR3_NOT_MODELLED: u32 =
    1 << 3 | 1 << 8 | 1 << 9 | 1 << 12 | 1 << 13 | 1 << 14 | 1 << 23 | 1 << 28;
/// Flags that ICR clears.
const ICR: u32 = FRAMING_ERROR | NOISE | OVERRUN | IDLE | COMPLETE;
const RQR_BREAK_OR_MUTE: u32 = 1 << 1 | 1 << 2;
const RQR_FLUSH_RECEIVED: u32 = 1 << 3;
const RQR_FLUSH_TO_SEND: u32 = 1 << 4;
const ISR_TRANSMITS: u32 = 1 << 21;
const ISR_RECEIVES: u32 = 1 << 22;
const ISR_FIFO_EMPTY: u32 = 1 << 23;
const ISR_FIFO_FULL: u32 = 1 << 24;
/// The smallest divider (RM0440, section 38.4.7).
const BRR_LEAST: u32 = 0x300;

/// 256ths of a clock in a bit; 0 for a divider that is not allowed.
pub(super) fn bit_clocks(baud: u32, prescaler: u32) -> u64 {
    let prescaler: u64 = match prescaler {
        0 => 1,
        1..=6 => 2 * u64::from(prescaler),
        7..=11 => 16 << (prescaler - 7),
        _ => 256,
    };
    if baud < BRR_LEAST {
        0
    } else {
        u64::from(baud) * prescaler
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
    pub(super) fn read_low_power(&mut self, offset: u32) -> u32 {
        match offset {
            0x00 => self.cr1,
            0x04 => self.cr2,
            0x08 => self.cr3,
            0x0C => self.baud,
            0x1C => self.interrupt_status(),
            0x24 => self.fetch(),
            0x28 => self.to_send.back().copied().map_or(0, u32::from),
            0x2C => self.prescaler,
            _ => 0,
        }
    }

    fn interrupt_status(&self) -> u32 {
        let bit = |set: bool, flag: u32| if set { flag } else { 0 };
        let fifo = self.cr1 & CR1_FIFO != 0;
        let on = |enable: u32| self.is_enabled() && self.cr1 & enable != 0;
        self.flags()
            | bit(on(CR1_TRANSMIT), ISR_TRANSMITS)
            | bit(on(CR1_RECEIVE), ISR_RECEIVES)
            | bit(fifo && self.to_send.is_empty(), ISR_FIFO_EMPTY)
            | bit(fifo && self.received.len() == self.depth(), ISR_FIFO_FULL)
    }

    pub(super) fn write_low_power(&mut self, offset: u32, value: u32) {
        match offset {
            0x00 => {
                let changes = (self.cr1 ^ value) & CR1_FIFO != 0;
                assert!(
                    !changes || self.cr1 & CR1_ENABLE == 0,
                    "FIFOEN can only be written while the port is disabled (RM0440, section 38.7.1)"
                );
                self.cr1 = value;
            }
            0x04 => self.cr2 = value,
            0x08 => self.cr3 = value,
            0x0C => self.baud = value & 0xF_FFFF,
            0x18 => self.request(value),
            0x20 => self.status &= !(value & ICR),
            0x28 => {
                self.status &= !COMPLETE;
                self.put(value as u8);
            }
            0x2C => self.prescaler = value & 0xF,
            _ => {}
        }
    }

    fn request(&mut self, value: u32) {
        assert_eq!(
            value & RQR_BREAK_OR_MUTE,
            0,
            "the serial port is modelled without breaks and mute mode"
        );
        if value & RQR_FLUSH_RECEIVED != 0 {
            self.received.clear();
        }
        if value & RQR_FLUSH_TO_SEND != 0 {
            self.to_send.clear();
        }
    }
}
