//! Programming and erasing the flash (RM0090, section 3; RM0440, section 3), with the times of the data sheets.
//!
//! The registers of both chips have their common bits at the same places; what they demand of a program or an erase is in `sectors` and
//! `pages`. While an operation lasts, its bank cannot be read: whoever tries waits, see [`crate::flash_memory`].

mod content;
mod operation;
mod pages;
mod part;
mod registers;
mod sectors;

use core::mem::take;
use core::ops::Range;

use drive_sim::SplitMix64;

use crate::soc::FLASH;
pub(crate) use content::DOUBLE_WORD;
pub use content::FlashContent;
pub use operation::{Change, Operation};
pub use part::{Part, Registers};
use registers::Keys;

/// Bits of SR, the same in both chips.
const END: u32 = 1;
const OPERATION_ERROR: u32 = 1 << 1;
const PROTECTED: u32 = 1 << 4;
const ALIGNMENT: u32 = 1 << 5;
/// PGPERR of the STM32F4, SIZERR of the STM32G4: an access of the wrong size.
const SIZE: u32 = 1 << 6;
const SEQUENCE: u32 = 1 << 7;
/// Bits of CR, the same in both chips.
const CR_PROGRAM: u32 = 1;
const CR_ERASE: u32 = 1 << 1;
const CR_MASS_ERASE: u32 = 1 << 2;
const CR_START: u32 = 1 << 16;
const CR_END_ENABLE: u32 = 1 << 24;
const CR_ERROR_ENABLE: u32 = 1 << 25;
const CR_LOCK: u32 = 1 << 31;
/// Memory is protected by whole pages of the emulator.
const PROTECTION: u32 = 0x1000;

/// The flash and its controller.
#[derive(Debug, Clone)]
pub struct Flash {
    /// Seed of what an operation that is cut off leaves.
    pub seed: u64,
    part: &'static Part,
    content: FlashContent,
    keys: Keys,
    control: u32,
    status: u32,
    /// ECCR of the STM32G4.
    errors: u32,
    /// The lower half of a double word that is being written.
    lower: Option<(u32, u32)>,
    operation: Option<Operation>,
    /// First address and bytes of what cannot be read now.
    busy: (u32, u32),
    /// What was done so far.
    history: Vec<Operation>,
    changed: Vec<Range<u32>>,
    /// Changes with everything that the memory of the emulator must follow.
    version: u64,
    /// From then on the supply is gone: nothing ends and nothing begins.
    supply_ends_ns: u64,
}

impl Flash {
    /// An erased flash.
    #[must_use]
    pub fn new(part: &'static Part) -> Self {
        Self {
            seed: 0,
            part,
            content: FlashContent::erased(part.bytes() as usize),
            keys: Keys::None,
            control: 0,
            status: 0,
            errors: 0,
            lower: None,
            operation: None,
            busy: (0, 0),
            history: Vec::new(),
            changed: Vec::new(),
            version: 0,
            supply_ends_ns: u64::MAX,
        }
    }

    /// What it holds.
    #[must_use]
    pub fn content(&self) -> &FlashContent {
        &self.content
    }

    /// Puts another content in: that of another board, or what a programmer wrote.
    ///
    /// # Panics
    /// When its size is that of another chip.
    pub fn set_content(&mut self, content: FlashContent) {
        let all = FLASH..FLASH + self.part.bytes();
        assert_eq!(
            content.read(all.clone()).map(<[u8]>::len),
            Some(all.len()),
            "the content of a flash fits chips of its size"
        );
        self.content = content;
        self.note_changed(all);
    }

    /// Operations so far, in their order, those under way or cut off included: where a test may cut the supply.
    #[must_use]
    pub fn history(&self) -> &[Operation] {
        &self.history
    }

    /// A reset. An operation under way is cut off (RM0090, section 3.6; RM0440, section 3.3.6).
    pub fn reset(&mut self) {
        self.cut_off();
        self.keys = Keys::None;
        self.control = match self.part.registers {
            Registers::Sectors => CR_LOCK,
            Registers::Pages => CR_LOCK | pages::CR_OPTION_LOCK,
        };
        (self.status, self.errors, self.lower) = (0, 0, None);
        self.supply_ends_ns = u64::MAX;
    }

    /// The supply will be gone at `ns`, and nothing ends or begins after it. The next reset takes it back.
    pub(crate) fn lose_supply_at_ns(&mut self, ns: u64) {
        self.supply_ends_ns = ns;
    }

    pub(crate) fn has_supply_at_ns(&self, ns: u64) -> bool {
        ns < self.supply_ends_ns
    }

    /// What the operation under way leaves when it is cut off.
    fn cut_off(&mut self) {
        let Some(Operation { change, .. }) = self.operation.take() else {
            return;
        };
        let mut random = SplitMix64::new(self.seed);
        self.seed = random.next_u64();
        let codes = self.part.registers == Registers::Pages;
        match change {
            Change::Program {
                address,
                size,
                value,
            } => self
                .content
                .half_program(address, size, value, &mut random, codes),
            Change::Erase(ref range) => self.content.half_erase(range, &mut random, codes),
        }
        self.busy = (0, 0);
        self.note_changed(change.range());
    }

    fn note_changed(&mut self, range: Range<u32>) {
        self.changed.push(range);
        self.version += 1;
    }

    /// A number that changes with everything that the memory of the emulator must follow.
    #[must_use]
    pub(crate) fn version(&self) -> u64 {
        self.version
    }

    /// Takes the ranges whose content has changed.
    pub(crate) fn take_changed(&mut self) -> Vec<Range<u32>> {
        take(&mut self.changed)
    }

    /// Ranges that cannot be read as plain memory: the bank of an operation, and what surrounds a damaged double word.
    pub(crate) fn hidden(&self) -> Vec<Range<u32>> {
        let (first, bytes) = self.busy;
        let pages = self.content.damaged().map(|word| word & !(PROTECTION - 1));
        let mut hidden: Vec<_> = pages
            .filter(|page| !self.is_busy(*page))
            .map(|page| page..page + PROTECTION)
            .collect();
        hidden.dedup();
        hidden.extend((bytes > 0).then_some(first..first + bytes));
        hidden
    }

    /// Whether an address cannot be read now because its bank changes.
    #[must_use]
    pub fn is_busy(&self, address: u32) -> bool {
        let (first, bytes) = self.busy;
        address.wrapping_sub(first) < bytes
    }

    /// Whether an operation is under way.
    #[must_use]
    pub fn is_changing(&self) -> bool {
        self.operation.is_some()
    }

    /// When the operation under way ends.
    #[must_use]
    pub fn next_event_ns(&self) -> Option<u64> {
        let operation = self.operation.as_ref();
        let ends_ns = operation.map(|operation| operation.ends_ns);
        ends_ns.filter(|ends_ns| self.has_supply_at_ns(*ends_ns))
    }

    /// Level of its interrupt line.
    #[must_use]
    pub fn line(&self) -> bool {
        let is = |flag: u32, enable: u32| self.status & flag != 0 && self.control & enable != 0;
        is(END, CR_END_ENABLE) || is(OPERATION_ERROR, CR_ERROR_ENABLE)
    }

    /// Brings it up to `now_ns`.
    pub fn advance(&mut self, now_ns: u64) {
        if self.next_event_ns().is_none_or(|at_ns| at_ns > now_ns) {
            return;
        }
        let Some(Operation { change, .. }) = self.operation.take() else {
            return;
        };
        match &change {
            Change::Program {
                address,
                size,
                value,
            } => self.content.program(*address, *size, *value),
            Change::Erase(range) => self.content.erase(range),
        }
        self.busy = (0, 0);
        self.control &= !CR_START;
        // The end is told only to those who want an interrupt (RM0090, section 3.9.4; RM0440, section 3.7.5, EOP).
        if self.control & CR_END_ENABLE != 0 {
            self.status |= END;
        }
        self.note_changed(change.range());
    }

    fn begin(&mut self, change: Change, lasts_ns: u64, now_ns: u64) {
        if !self.has_supply_at_ns(now_ns) {
            return;
        }
        let bank = self.part.bytes() / self.part.banks;
        let first = FLASH + (change.first() - FLASH) / bank * bank;
        self.busy = (first, bank);
        let operation = Operation {
            change,
            starts_ns: now_ns,
            ends_ns: now_ns + lasts_ns,
        };
        self.history.push(operation.clone());
        self.operation = Some(operation);
        self.version += 1;
    }

    fn fail(&mut self, flag: u32) {
        self.status |= flag;
        // OPERR is set only with its interrupt enabled.
        if self.control & CR_ERROR_ENABLE != 0 {
            self.status |= OPERATION_ERROR;
        }
    }

    /// The processor writes to an address in flash; nothing is under way. `options` are the option bytes.
    pub fn store(&mut self, address: u32, size: u32, value: u32, options: u32, now_ns: u64) {
        match self.part.registers {
            Registers::Sectors => self.store_sectors(address, size, value, options, now_ns),
            Registers::Pages => self.store_pages(address, size, value, now_ns),
        }
    }
}

#[cfg(test)]
mod tests;
