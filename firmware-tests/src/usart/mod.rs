//! The serial port at register level: the USART of the STM32F4 (RM0090, section 30) and the LPUART of the STM32G4 (RM0440, section 38).
//!
//! Flags and enables have the same places in both; what differs is in `classic` and `low_power`. The wire is the [`SerialLine`]'s.

mod classic;
mod line;
mod low_power;
mod traffic;

use std::collections::VecDeque;

pub use line::{Received, SerialLine, Symbol};
use traffic::Shift;

/// Flags of the status register.
const FRAMING_ERROR: u32 = 1 << 1;
const NOISE: u32 = 1 << 2;
const OVERRUN: u32 = 1 << 3;
const IDLE: u32 = 1 << 4;
const RECEIVED: u32 = 1 << 5;
const COMPLETE: u32 = 1 << 6;
const EMPTY: u32 = 1 << 7;
/// Bits of CR1; the enables of the interrupts of IDLE, RXNE, TC and TXE are at the places of the flags.
const CR1_RECEIVE: u32 = 1 << 2;
const CR1_TRANSMIT: u32 = 1 << 3;
const CR1_RECEIVED_ENABLE: u32 = 1 << 5;
/// Bits of CR3.
const CR3_ERROR_ENABLE: u32 = 1;
const CR3_DMA_RECEIVE: u32 = 1 << 6;
const CR3_DMA_TRANSMIT: u32 = 1 << 7;
/// Half bits of a byte with start and stop bit, and until the middle of the stop bit, when the receiver has it.
const FRAME: u64 = 20;
const SAMPLED: u64 = 19;
/// Depth of the FIFOs of the LPUART (RM0440, section 38.4.4).
const FIFO_DEPTH: usize = 8;

/// The kind of registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Registers {
    /// USART of the STM32F4.
    Classic,
    /// LPUART of the STM32G4.
    LowPower,
}

/// What the chip around the port gives it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Surroundings {
    /// Its clock.
    pub kernel_hz: u64,
    /// Whether the RX and the TX pin have its alternate function.
    pub wired: [bool; 2],
}

/// Length of a bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct BitTime {
    /// 256ths of a clock.
    clocks: u64,
    hz: u64,
}

impl BitTime {
    fn ns(self, half_bits: u64) -> u64 {
        let ns = u128::from(half_bits * self.clocks) * 1_000_000_000;
        (ns / u128::from(512 * self.hz)) as u64
    }
}

/// The port.
#[derive(Debug, Clone)]
pub struct Usart {
    registers: Registers,
    cr1: u32,
    cr2: u32,
    cr3: u32,
    baud: u32,
    prescaler: u32,
    guard_time: u32,
    status: u32,
    /// Flags that were in the latest read of SR; what a read or write of DR does depends on it.
    seen: u32,
    received: VecDeque<u8>,
    last_received: u8,
    to_send: VecDeque<u8>,
    shift: Option<Shift>,
    /// Since when the receiver listens.
    listens_ns: Option<u64>,
    /// When the line has been idle for a frame; `None` when that was noted.
    idle_ns: Option<u64>,
    overruns: u64,
}

impl Usart {
    /// The port after a reset.
    #[must_use]
    pub fn new(registers: Registers) -> Self {
        Self {
            registers,
            cr1: 0,
            cr2: 0,
            cr3: 0,
            baud: 0,
            prescaler: 0,
            guard_time: 0,
            status: COMPLETE,
            seen: 0,
            received: VecDeque::new(),
            last_received: 0,
            to_send: VecDeque::new(),
            shift: None,
            listens_ns: None,
            idle_ns: None,
            overruns: 0,
        }
    }

    /// Bytes lost so far because the firmware did not fetch them.
    #[must_use]
    pub fn overruns(&self) -> u64 {
        self.overruns
    }

    /// A reset; the count of lost bytes goes on.
    pub fn reset(&mut self) {
        *self = Self {
            overruns: self.overruns,
            ..Self::new(self.registers)
        };
    }

    fn depth(&self) -> usize {
        match self.registers {
            Registers::LowPower if self.cr1 & low_power::CR1_FIFO != 0 => FIFO_DEPTH,
            _ => 1,
        }
    }

    fn is_enabled(&self) -> bool {
        let bit = match self.registers {
            Registers::Classic => classic::CR1_ENABLE,
            Registers::LowPower => low_power::CR1_ENABLE,
        };
        self.cr1 & bit != 0
    }

    fn receives(&self) -> bool {
        self.is_enabled() && self.cr1 & CR1_RECEIVE != 0
    }

    fn transmits(&self) -> bool {
        self.is_enabled() && self.cr1 & CR1_TRANSMIT != 0
    }

    /// Length of a bit; `None` when the divider makes none.
    fn bit_time(&self, around: &Surroundings) -> Option<BitTime> {
        let clocks = match self.registers {
            Registers::Classic => classic::bit_clocks(self.cr1, self.baud),
            Registers::LowPower => low_power::bit_clocks(self.baud, self.prescaler),
        };
        let hz = around.kernel_hz;
        (clocks > 0 && hz > 0).then_some(BitTime { clocks, hz })
    }

    /// The flags as a read would show them.
    fn flags(&self) -> u32 {
        let bit = |set: bool, flag: u32| if set { flag } else { 0 };
        self.status
            | bit(!self.received.is_empty(), RECEIVED)
            | bit(self.to_send.len() < self.depth(), EMPTY)
    }

    /// Level of its interrupt line.
    #[must_use]
    pub fn line(&self) -> bool {
        let flags = self.flags();
        let own = flags & self.cr1 & (IDLE | RECEIVED | COMPLETE | EMPTY);
        let overrun = flags & OVERRUN != 0 && self.cr1 & CR1_RECEIVED_ENABLE != 0;
        let errors = flags & (FRAMING_ERROR | NOISE | OVERRUN) != 0
            && self.cr3 & CR3_ERROR_ENABLE != 0
            // Without DMA the older port tells errors with RXNE only (RM0090, section 30.6.6, EIE).
            && (self.registers == Registers::LowPower || self.cr3 & CR3_DMA_RECEIVE != 0);
        self.is_enabled() && (own != 0 || overrun || errors)
    }

    /// Whether it requests a DMA transfer: of a received byte, of a byte to send.
    #[must_use]
    pub fn requests(&self) -> [bool; 2] {
        let flags = self.flags();
        let asks = |dma: u32, flag: u32| self.cr3 & dma != 0 && flags & flag != 0;
        [
            self.is_enabled() && asks(CR3_DMA_RECEIVE, RECEIVED),
            self.transmits() && asks(CR3_DMA_TRANSMIT, EMPTY),
        ]
    }

    /// Reads a register.
    pub fn read(&mut self, offset: u32) -> u32 {
        match self.registers {
            Registers::Classic => self.read_classic(offset),
            Registers::LowPower => self.read_low_power(offset),
        }
    }

    /// Writes a register.
    ///
    /// # Panics
    /// When the firmware uses what is not modelled: other frames than 8N1, flow control, breaks, single-wire and other modes.
    pub fn write(&mut self, offset: u32, value: u32, now_ns: u64, around: &Surroundings) {
        let was = (self.receives(), self.transmits(), self.is_enabled());
        match self.registers {
            Registers::Classic => self.write_classic(offset, value),
            Registers::LowPower => self.write_low_power(offset, value),
        }
        if self.is_enabled() {
            self.check(around);
        }
        self.follow_enables(was, now_ns, around);
        if self.shift.is_none() {
            self.start_shift(now_ns, around);
        }
    }

    fn check(&self, around: &Surroundings) {
        let unknown = match self.registers {
            Registers::Classic => classic::not_modelled(self.cr1, self.cr2, self.cr3),
            Registers::LowPower => low_power::not_modelled(self.cr1, self.cr2, self.cr3),
        };
        let [cr1, cr2, cr3] = unknown;
        assert_eq!(
            unknown, [0; 3],
            "the serial port is modelled with 8N1 alone, without flow control and special modes; \
             set were CR1 {cr1:#x}, CR2 {cr2:#x}, CR3 {cr3:#x}"
        );
        assert!(
            self.cr1 & (CR1_RECEIVE | CR1_TRANSMIT) == 0 || self.bit_time(around).is_some(),
            "BRR {:#x} makes no bit rate from {} Hz",
            self.baud,
            around.kernel_hz
        );
    }

    fn follow_enables(
        &mut self,
        (received, transmitted, enabled): (bool, bool, bool),
        now_ns: u64,
        around: &Surroundings,
    ) {
        let bit = self.bit_time(around);
        if received != self.receives() {
            self.listens_ns = self.receives().then_some(now_ns);
            // A receiver that is switched on sees the idle line as any other.
            let idle_ns = bit.map(|bit| now_ns + bit.ns(FRAME));
            self.idle_ns = idle_ns.filter(|_| self.receives());
        }
        if transmitted != self.transmits() {
            // Off: what was on the way is lost. On: an idle frame goes first.
            self.shift = bit.filter(|_| self.transmits()).map(|bit| Shift {
                byte: None,
                ends_ns: now_ns + bit.ns(FRAME),
            });
        }
        if enabled && !self.is_enabled() && self.registers == Registers::LowPower {
            self.status = COMPLETE;
            self.received.clear();
            self.to_send.clear();
        }
    }

    /// A read of the data register.
    fn fetch(&mut self) -> u32 {
        if let Some(byte) = self.received.pop_front() {
            self.last_received = byte;
        }
        u32::from(self.last_received)
    }

    /// A write of the data register: one that does not fit takes the place of the latest.
    fn put(&mut self, byte: u8) {
        if self.to_send.len() >= self.depth() {
            self.to_send.pop_back();
        }
        self.to_send.push_back(byte);
    }
}

#[cfg(test)]
mod tests;
