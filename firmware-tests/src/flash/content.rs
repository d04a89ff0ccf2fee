//! What the cells of the flash hold, and what an operation that is cut off leaves in them.

use core::ops::Range;
use std::collections::BTreeSet;

use drive_sim::SplitMix64;

use crate::soc::FLASH;

/// Bytes that share one error correction code on the STM32G4.
pub(crate) const DOUBLE_WORD: u32 = 8;

/// The content of the flash. It outlives the supply: take it out of a board and put it into another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FlashContent {
    bytes: Vec<u8>,
    /// Addresses of the double words whose error correction code does not fit.
    damaged: BTreeSet<u32>,
}

impl FlashContent {
    /// A flash of so many bytes as it comes from the factory.
    #[must_use]
    pub fn erased(bytes: usize) -> Self {
        Self {
            bytes: vec![0xFF; bytes],
            damaged: BTreeSet::new(),
        }
    }

    fn places(&self, range: &Range<u32>) -> Option<Range<usize>> {
        let [start, end] = [range.start, range.end].map(|at| at.checked_sub(FLASH));
        let places = start? as usize..end? as usize;
        (places.start <= places.end && places.end <= self.bytes.len()).then_some(places)
    }

    /// The bytes at these addresses; `None` where there is no flash.
    #[must_use]
    pub fn read(&self, range: Range<u32>) -> Option<&[u8]> {
        self.bytes.get(self.places(&range)?)
    }

    /// Sets bytes as a programmer does, the old ones erased before; false where there is no flash.
    #[must_use]
    pub fn write(&mut self, address: u32, bytes: &[u8]) -> bool {
        let range = address..address + bytes.len() as u32;
        let Some(places) = self.places(&range) else {
            return false;
        };
        self.bytes[places].copy_from_slice(bytes);
        self.mend(&range);
        true
    }

    /// Double words whose error correction code does not fit.
    pub fn damaged(&self) -> impl Iterator<Item = u32> + '_ {
        self.damaged.iter().copied()
    }

    /// The damaged double word that an address is in.
    pub(super) fn damaged_at(&self, address: u32) -> Option<u32> {
        let word = address & !(DOUBLE_WORD - 1);
        self.damaged.contains(&word).then_some(word)
    }

    fn mend(&mut self, range: &Range<u32>) {
        self.damaged
            .retain(|word| word + DOUBLE_WORD <= range.start || *word >= range.end);
    }

    pub(super) fn value(&self, address: u32, size: u32) -> u64 {
        let bytes = self.read(address..address + size).unwrap_or(&[]);
        let mut value = [0; 8];
        value[..bytes.len()].copy_from_slice(bytes);
        u64::from_le_bytes(value)
    }

    fn set_value(&mut self, address: u32, size: u32, value: u64) {
        if let Some(places) = self.places(&(address..address + size)) {
            self.bytes[places].copy_from_slice(&value.to_le_bytes()[..size as usize]);
        }
    }

    pub(super) fn erase(&mut self, range: &Range<u32>) {
        if let Some(places) = self.places(range) {
            self.bytes[places].fill(0xFF);
        }
        self.mend(range);
    }

    /// Bits go from 1 to 0 only.
    pub(super) fn program(&mut self, address: u32, size: u32, value: u64) {
        self.set_value(address, size, self.value(address, size) & value);
        self.mend(&(address..address + size));
    }

    /// An erase was cut off: each double word holds the old value, the erased one, or anything; with error correction, its code fits or
    /// does not.
    pub(super) fn half_erase(&mut self, range: &Range<u32>, random: &mut SplitMix64, codes: bool) {
        self.mend(range);
        for address in range.clone().step_by(DOUBLE_WORD as usize) {
            let old = self.value(address, DOUBLE_WORD);
            let left = [old, u64::MAX, random.next_u64()][random.up_to(2) as usize];
            self.set_value(address, DOUBLE_WORD, left);
            if codes && random.up_to(1) == 0 {
                self.damaged.insert(address);
            }
        }
    }

    /// A program was cut off: some of the bits have changed; with error correction, the code fits or does not.
    pub(super) fn half_program(
        &mut self,
        address: u32,
        size: u32,
        value: u64,
        random: &mut SplitMix64,
        codes: bool,
    ) {
        let old = self.value(address, size);
        self.set_value(address, size, old & (value | random.next_u64()));
        if codes && random.up_to(1) == 0 {
            self.damaged.insert(address);
        }
    }
}
