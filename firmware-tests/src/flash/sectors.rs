//! What the STM32F4 demands (RM0090, section 3.6).

use super::{
    ALIGNMENT, CR_ERASE, CR_MASS_ERASE, CR_PROGRAM, Change, Flash, PROTECTED, SEQUENCE, SIZE,
};

/// Writes must not cross rows of so many bytes.
const ROW: u32 = 16;
/// Sectors that may be written, in the option bytes.
const OPTIONS_WRITABLE: u32 = 16;

impl Flash {
    /// PSIZE: 8, 16 and 32 bits; 64 bits need a supply that the boards do not have.
    fn parallelism(&self) -> usize {
        let size = self.control >> 8 & 3;
        assert_ne!(size, 3, "PSIZE 3 needs an external programming voltage");
        size as usize
    }

    fn is_protected(&self, sector: u32, options: u32) -> bool {
        options >> (OPTIONS_WRITABLE + sector) & 1 == 0
    }

    pub(super) fn store_sectors(
        &mut self,
        address: u32,
        size: u32,
        value: u32,
        options: u32,
        now_ns: u64,
    ) {
        if self.control & CR_PROGRAM == 0 || self.control & (CR_ERASE | CR_MASS_ERASE) != 0 {
            return self.fail(SEQUENCE);
        }
        if address % ROW + size > ROW {
            return self.fail(ALIGNMENT);
        }
        if size != 1 << self.parallelism() {
            return self.fail(SIZE);
        }
        let sector = self.part.sector_at(address);
        if sector.is_none_or(|sector| self.is_protected(sector, options)) {
            return self.fail(PROTECTED);
        }
        let change = Change::Program {
            address,
            size,
            value: u64::from(value),
        };
        self.begin(change, self.part.program_ns, now_ns);
    }

    pub(super) fn start_sectors(&mut self, options: u32, now_ns: u64) {
        assert_ne!(
            self.control & CR_ERASE,
            0,
            "STRT without SER: what the flash does is not in the manual (RM0090, section 3.9.5)"
        );
        let number = self.control >> 3 & 0xF;
        let Some(range) = self.part.sector(number) else {
            panic!("SNB {number}: there is no such sector (RM0090, section 3.9.5)");
        };
        if self.is_protected(number, options) {
            return self.fail(PROTECTED);
        }
        let lasts_ns = self
            .part
            .erase_ns(range.end - range.start, self.parallelism());
        self.begin(Change::Erase(range), lasts_ns, now_ns);
    }
}
