//! What the STM32G4 demands (RM0440, section 3.3), and its error correction.

use super::content::DOUBLE_WORD;
use super::{
    ALIGNMENT, CR_ERASE, CR_MASS_ERASE, CR_PROGRAM, Change, Flash, PROTECTED, SEQUENCE, SIZE,
};
use crate::soc::FLASH;

pub(super) const CR_OPTION_LOCK: u32 = 1 << 30;
const CR_MASS_ERASE_2: u32 = 1 << 15;
const CR_BANK: u32 = 1 << 11;
const CR_FAST: u32 = 1 << 18;
const PROGRAM_ERROR: u32 = 1 << 3;
const MISS: u32 = 1 << 8;
const FAST: u32 = 1 << 9;
/// Errors that must be cleared before the next operation.
const ERRORS: u32 = PROGRAM_ERROR | PROTECTED | ALIGNMENT | SIZE | SEQUENCE | MISS | FAST;
/// Two banks, in the option bytes.
const OPTIONS_DUAL_BANK: u32 = 1 << 22;
const LAST_OPTION_KEY: u32 = 0x4C5D_6E7F;
/// ECCR: two errors in a double word, its bank; the low bits are its address there.
const ECC_DETECTED: u32 = 1 << 31;
const ECC_BANK: u32 = 1 << 21;
/// Flags of ECCR that are cleared by a 1.
const ECC_FLAGS: u32 = 0b1111 << 28;
const ECC_ENABLE: u32 = 1 << 24;

impl Flash {
    pub(super) fn store_pages(&mut self, address: u32, size: u32, value: u32, now_ns: u64) {
        let lower = self.lower.take();
        if self.control & CR_PROGRAM == 0
            || self.control & (CR_ERASE | CR_MASS_ERASE | CR_MASS_ERASE_2) != 0
            || self.status & ERRORS != 0
        {
            return self.fail(SEQUENCE);
        }
        if size != 4 {
            return self.fail(SIZE);
        }
        let Some((first, low)) = lower else {
            if address.is_multiple_of(DOUBLE_WORD) {
                self.lower = Some((address, value));
            } else {
                self.fail(ALIGNMENT);
            }
            return;
        };
        if address != first + 4 {
            return self.fail(ALIGNMENT);
        }
        let value = u64::from(low) | u64::from(value) << 32;
        let is_erased = self.content.value(first, DOUBLE_WORD) == u64::MAX
            && self.content.damaged_at(first).is_none();
        // Only zeros may go over what was programmed.
        if !is_erased && value != 0 {
            return self.fail(PROGRAM_ERROR);
        }
        let change = Change::Program {
            address: first,
            size: DOUBLE_WORD,
            value,
        };
        self.begin(change, self.part.program_ns, now_ns);
    }

    pub(super) fn start_pages(&mut self, options: u32, now_ns: u64) {
        let control = self.control;
        assert_eq!(
            control & (CR_MASS_ERASE_2 | CR_FAST),
            0,
            "mass erase and fast programming of the flash are not modelled"
        );
        assert_ne!(
            options & OPTIONS_DUAL_BANK,
            0,
            "a flash of a single bank is not modelled"
        );
        if control & CR_ERASE == 0 || control & CR_PROGRAM != 0 || self.status & ERRORS != 0 {
            return self.fail(SEQUENCE);
        }
        let bank = if control & CR_BANK != 0 { 128 } else { 0 };
        let page = control >> 3 & 0x7F;
        if let Some(range) = self.part.sector(bank + page) {
            let lasts_ns = self.part.erase_ns(range.end - range.start, 0);
            self.begin(Change::Erase(range), lasts_ns, now_ns);
        }
    }

    /// The keys of the option bytes are not checked: the last one opens.
    pub(super) fn take_option_key(&mut self, key: u32) {
        if key == LAST_OPTION_KEY {
            self.control &= !CR_OPTION_LOCK;
        }
    }

    pub(super) fn write_errors(&mut self, value: u32) {
        let kept = self.errors & !(value & ECC_FLAGS) & !ECC_ENABLE;
        self.errors = kept | value & ECC_ENABLE;
    }

    /// The processor reads data: true when it meets a double word with two errors that was not told before, which raises the NMI.
    pub fn read_data(&mut self, address: u32) -> bool {
        let Some(word) = self.content.damaged_at(address) else {
            return false;
        };
        if self.errors & ECC_DETECTED != 0 {
            return false;
        }
        let bank_bytes = self.part.bytes() / self.part.banks;
        let offset = word - FLASH;
        let bank = if offset < bank_bytes { 0 } else { ECC_BANK };
        let place = bank | (offset % bank_bytes);
        self.errors = self.errors & ECC_ENABLE | ECC_DETECTED | place;
        true
    }
}
