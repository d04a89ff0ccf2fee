//! The DMA controllers at register level: streams of the STM32F4 (RM0090, section 10) and channels of the STM32G4 with their request
//! multiplexer (RM0440, sections 12 and 13).
//!
//! A served request moves one item between memory and a peripheral. Memory belongs to the processor's side, so the transfer is told here
//! and carried out by [`crate::transfers`].

mod channels;
mod mux;
mod stream;
mod streams;

use core::ops::Range;

pub use mux::Mux;
pub use stream::{Direction, Transfer};

use stream::Stream;

/// Streams or channels of a controller.
pub const STREAMS: usize = 8;

/// The kind of registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Registers {
    /// Streams with channel selection, of the STM32F4.
    Streams,
    /// Channels behind a request multiplexer, of the STM32G4.
    Channels,
}

/// Where a controller is and what it reaches.
#[derive(Debug)]
pub struct Wiring {
    /// Number of the controller in the manual.
    pub number: usize,
    /// Kind of its registers.
    pub registers: Registers,
    /// First address.
    pub base: u32,
    /// Its bit in the clock enable and the reset register of AHB1.
    pub bit: u32,
    /// Interrupts of its streams or channels.
    pub interrupts: [u16; STREAMS],
    /// Flash, which it can read.
    pub flash: Range<u32>,
    /// Memory that it reaches.
    pub memory: [Range<u32>; 2],
    /// Peripherals that it reaches.
    pub peripherals: Range<u32>,
}

/// A controller.
#[derive(Debug, Clone)]
pub struct Dma {
    wiring: &'static Wiring,
    streams: [Stream; STREAMS],
    /// Written since the reset; before that nothing can happen.
    used: bool,
}

impl Dma {
    /// A controller after a reset.
    #[must_use]
    pub fn new(wiring: &'static Wiring) -> Self {
        Self {
            wiring,
            streams: core::array::from_fn(|_| Stream::new()),
            used: false,
        }
    }

    /// Where it is and what it reaches.
    #[must_use]
    pub fn wiring(&self) -> &'static Wiring {
        self.wiring
    }

    /// Back to the state after a reset.
    pub fn reset(&mut self) {
        *self = Self::new(self.wiring);
    }

    /// Numbers and levels of the interrupt lines; nothing before the first use.
    pub fn lines(&self) -> impl Iterator<Item = (u16, bool)> + '_ {
        let numbers = self.wiring.interrupts.iter().copied();
        let levels = self.streams.iter().map(Stream::line);
        numbers.zip(levels).filter(|_| self.used)
    }

    /// The transfer that goes next: of the streams that are requested the one with the highest priority, of equals the first. `requested`
    /// tells whether the peripheral behind a stream, by its index and its channel selection, asks for one, `free` whether memory at an address
    /// can be accessed at once.
    pub fn next_transfer(
        &self,
        free: impl Fn(u32) -> bool,
        requested: impl Fn(usize, u32) -> bool,
    ) -> Option<Transfer> {
        if !self.used {
            return None;
        }
        let ready = self.streams.iter().enumerate().filter(|(index, stream)| {
            stream.is_ready()
                && requested(*index, stream.channel)
                && free(stream.transfer(*index).memory)
        });
        let (index, stream) =
            ready.max_by_key(|(index, stream)| (stream.priority, STREAMS - index))?;
        Some(stream.transfer(index))
    }

    /// Whether the memory of a transfer and its peripheral are within reach.
    #[must_use]
    pub fn reaches(&self, transfer: &Transfer) -> bool {
        let mut ranges = self.wiring.memory.iter();
        let in_memory = ranges.any(|range| range.contains(&transfer.memory));
        let in_flash = transfer.direction == Direction::FromMemory
            && self.wiring.flash.contains(&transfer.memory);
        let peripheral = self.wiring.peripherals.contains(&transfer.peripheral);
        (in_memory || in_flash) && peripheral
    }

    /// A transfer is done.
    pub fn finish(&mut self, transfer: &Transfer) {
        let keeps_enabled = self.wiring.registers == Registers::Channels;
        self.streams[transfer.stream].finish(keeps_enabled);
    }

    /// A transfer met an address without memory or peripheral: the stream is disabled.
    pub fn fail(&mut self, transfer: &Transfer) {
        self.streams[transfer.stream].fail();
    }

    /// Reads a register.
    #[must_use]
    pub fn read(&self, offset: u32) -> u32 {
        match self.wiring.registers {
            Registers::Streams => self.read_streams(offset),
            Registers::Channels => self.read_channels(offset),
        }
    }

    /// Writes a register. `served` tells whether the peripheral behind a stream with a channel selection is modelled.
    ///
    /// # Panics
    /// When a stream is enabled in a way that is not modelled, or that the manual forbids.
    pub fn write(&mut self, offset: u32, value: u32, served: impl Fn(usize, u32) -> bool) {
        self.used = true;
        match self.wiring.registers {
            Registers::Streams => self.write_streams(offset, value, served),
            Registers::Channels => self.write_channels(offset, value, served),
        }
    }
}

#[cfg(test)]
mod tests;
