//! The flash within the chip: its registers among the option bytes, stores of the processor, waiting.

use super::{BLOCK, Soc};

impl Soc {
    fn options(&self) -> u32 {
        let (option_bytes, ..) = self.chip.option_bytes;
        self.storage.peek(option_bytes)
    }

    pub(super) fn advance_flash(&mut self, now_ns: u64) {
        self.flash.advance(now_ns);
        self.nvic
            .set_line(self.chip.flash.interrupt, self.flash.line());
    }

    pub(super) fn read_flash_register(&mut self, address: u32) -> u32 {
        self.advance_flash(self.now_ns());
        match self.flash.read(address % BLOCK) {
            Some(value) => value,
            None => self.read_storage(address),
        }
    }

    pub(super) fn write_flash_register(&mut self, address: u32, value: u32) {
        let (options, now_ns) = (self.options(), self.now_ns());
        self.advance_flash(now_ns);
        if !self.flash.write(address % BLOCK, value, options, now_ns) {
            return self.write_storage(address, value);
        }
        self.process();
        // An operation that begins stops the processor before its next fetch.
        self.deadline = 0;
    }

    /// Whether a write of this register waits for the end of an operation of the flash.
    #[must_use]
    pub fn waits_for_flash(&self, address: u32) -> bool {
        address & !(BLOCK - 1) == self.chip.flash_access && self.flash.holds_up(address % BLOCK)
    }

    /// The processor stores to an address in flash.
    pub fn store_to_flash(&mut self, address: u32, size: u32, value: u32) {
        let (options, now_ns) = (self.options(), self.now_ns());
        self.flash.store(address, size, value, options, now_ns);
        self.process();
        self.deadline = 0;
    }

    /// The processor waits for the flash: time jumps to what comes next.
    pub fn stall(&mut self) {
        let until = self.deadline.max(self.now + 1);
        self.stalled += until - self.now;
        self.now = until;
    }
}
