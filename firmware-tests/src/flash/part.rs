//! What the flash of a chip is made of, as a table.

use core::ops::Range;

use crate::soc::FLASH;

/// The kind of registers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Registers {
    /// Sectors of different sizes, of the STM32F4.
    Sectors,
    /// Pages with error correction, of the STM32G4.
    Pages,
}

/// The flash of a chip.
#[derive(Debug)]
pub struct Part {
    /// Kind of its registers.
    pub registers: Registers,
    /// Its interrupt.
    pub interrupt: u16,
    /// Number of banks, of equal size; while one changes the others can be read.
    pub banks: u32,
    /// What is erased as one: number and bytes, in the order of the addresses.
    pub sectors: &'static [(u32, u32)],
    /// Longest time of programming one item.
    pub program_ns: u64,
    /// Longest time of erasing a sector of so many bytes, with a parallelism of 8, 16 and 32 bits.
    pub erase_ns: &'static [(u32, [u64; 3])],
}

impl Part {
    /// Bytes of the whole.
    #[must_use]
    pub fn bytes(&self) -> u32 {
        let sectors = self.sectors.iter();
        sectors.map(|(number, bytes)| number * bytes).sum()
    }

    /// Addresses of a sector, counted over all banks.
    pub(super) fn sector(&self, number: u32) -> Option<Range<u32>> {
        let sizes = self
            .sectors
            .iter()
            .flat_map(|&(number, bytes)| (0..number).map(move |_| bytes));
        let mut first = FLASH;
        for (at, bytes) in sizes.enumerate() {
            if at == number as usize {
                return Some(first..first + bytes);
            }
            first += bytes;
        }
        None
    }

    /// Number of the sector that an address is in.
    pub(super) fn sector_at(&self, address: u32) -> Option<u32> {
        (0..)
            .map_while(|number| self.sector(number))
            .position(|range| range.contains(&address))
            .map(|number| number as u32)
    }

    pub(super) fn erase_ns(&self, bytes: u32, parallelism: usize) -> u64 {
        let mut times = self.erase_ns.iter();
        let found = times.find(|(of, _)| *of == bytes);
        found.map_or(0, |(_, times)| times[parallelism.min(2)])
    }
}
