//! The DMA controllers within the chip: clock, requests, where their registers are.

use super::{BLOCK, Soc};
use crate::chip::DmaRequest;
use crate::dma::{Mux, STREAMS, Transfer};

impl Soc {
    fn has_dma_clock(&self, bit: u32) -> bool {
        self.storage.peek(self.chip.dma.enable) >> bit & 1 != 0
    }

    /// Whether `request` is what a stream or channel with this channel selection listens to.
    fn goes_to(&self, request: DmaRequest, controller: usize, index: usize, selected: u32) -> bool {
        match request {
            DmaRequest::Stream {
                controller: number,
                stream,
                channel,
            } => (number, stream, channel) == (controller + 1, index, selected),
            DmaRequest::Mux(number) => self.mux.request(controller * STREAMS + index) == number,
        }
    }

    /// The transfer that goes next, with the index of its controller.
    pub fn next_transfer(&self) -> Option<(usize, Transfer)> {
        let asked = self.serial.port.requests();
        if asked == [false; 2] {
            return None;
        }
        let requests = self.chip.serial.requests.into_iter().zip(asked);
        let active: Vec<_> = requests.filter(|(_, asked)| *asked).collect();
        self.dma.iter().enumerate().find_map(|(controller, dma)| {
            if !self.has_dma_clock(dma.wiring().bit) {
                return None;
            }
            let free = |memory| !self.flash.is_busy(memory);
            let transfer = dma.next_transfer(free, |index, selected| {
                let mut active = active.iter();
                active.any(|(request, _)| self.goes_to(*request, controller, index, selected))
            });
            Some((controller, transfer?))
        })
    }

    pub(super) fn dma_at(&self, address: u32) -> Option<usize> {
        let block = address & !(BLOCK - 1);
        self.dma.iter().position(|dma| dma.wiring().base == block)
    }

    pub(super) fn is_mux(&self, address: u32) -> bool {
        let mux = self.chip.dma.mux;
        mux.is_some_and(|(base, _)| base == address & !(BLOCK - 1))
    }

    pub(super) fn read_dma(&self, controller: usize, address: u32) -> u32 {
        let dma = &self.dma[controller];
        if self.has_dma_clock(dma.wiring().bit) {
            dma.read(address % BLOCK)
        } else {
            0
        }
    }

    pub(super) fn write_dma(&mut self, controller: usize, address: u32, value: u32) {
        if !self.has_dma_clock(self.dma[controller].wiring().bit) {
            return;
        }
        let mut dma = self.dma[controller].clone();
        dma.write(address % BLOCK, value, |index, selected| {
            let mut requests = self.chip.serial.requests.into_iter();
            requests.any(|request| self.goes_to(request, controller, index, selected))
        });
        self.dma[controller] = dma;
        self.process();
    }

    pub(super) fn read_mux(&self, address: u32) -> u32 {
        self.mux.read(address % BLOCK)
    }

    pub(super) fn write_mux(&mut self, address: u32, value: u32) {
        let clock = self.chip.dma.mux.map(|(_, bit)| bit);
        if clock.is_some_and(|bit| self.has_dma_clock(bit)) {
            self.mux.write(address % BLOCK, value);
        }
    }

    pub(super) fn reset_dma(&mut self, value: u32) {
        for dma in &mut self.dma {
            if value >> dma.wiring().bit & 1 != 0 {
                dma.reset();
            }
        }
        let mux = self.chip.dma.mux;
        if mux.is_some_and(|(_, bit)| value >> bit & 1 != 0) {
            self.mux = Mux::default();
        }
    }
}
