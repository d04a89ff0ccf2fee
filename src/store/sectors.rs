//! The flash of the STM32F405 (RM0090, section 3): sectors of different sizes, in one bank. While it is erased or programmed the processor
//! stands still, with every interrupt: up to half a second for 16 KiB and 1.1 s for 64 KiB (STM32F405 data sheet, table 40), 0.1 ms for a
//! word. The bus is silent meanwhile but for what its controller does by itself.

use core::ptr;

use cortex_m::peripheral::DWT;
use embassy_stm32::pac::FLASH;
use embassy_stm32::pac::flash::regs::{Cr, Sr};
use embassy_stm32::pac::flash::vals::Psize;
use record_store::Reading;

use super::areas::ChipError;
use crate::board::{CORE_HZ, Watchdog};

/// A word: what the supply of 3.3 V allows at once.
pub(super) const UNIT: usize = 4;
/// Sectors 1 and 2, of 16 KiB.
pub(super) const SETTINGS: [u32; 2] = [0x0800_4000, 0x0800_8000];
/// Sector 3 of 16 KiB and sector 4 of 64 KiB.
pub(super) const FAULTS: [u32; 2] = [0x0800_C000, 0x0801_0000];
/// What unlocks the control register.
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
/// EOP and every error; written as 1 they are cleared.
const FLAGS: Sr = Sr(0b1111_0011);
const ERRORS: u32 = FLAGS.0 & !1;
/// More than the longest operation: two seconds.
const PATIENCE_CLOCKS: u32 = 3 * CORE_HZ;

/// Reads; this chip knows no damaged words.
pub(super) fn watch(read: impl FnOnce()) -> Reading {
    read();
    Reading::Good
}

/// The control register is unlocked while it exists.
pub(super) struct Operation(());

impl Operation {
    pub(super) fn begin() -> Result<Self, ChipError> {
        // What an operation before has left of errors is cleared below, and says nothing of this one.
        idle()?;
        if FLASH.cr().read().lock() {
            KEYS.iter().for_each(|key| FLASH.keyr().write_value(*key));
        }
        FLASH.sr().write_value(FLAGS);
        Ok(Self(()))
    }

    pub(super) fn program(&self, address: u32, unit: &[u8]) -> Result<(), ChipError> {
        let mut control = Cr(0);
        control.set_psize(Psize::PSIZE32);
        control.set_pg(true);
        FLASH.cr().write_value(control);
        let word = unit
            .first_chunk()
            .map_or(u32::MAX, |unit| u32::from_le_bytes(*unit));
        // SAFETY: a word of the areas, where neither code nor data of the image lies.
        unsafe { ptr::write_volatile(address as *mut u32, word) };
        wait()
    }

    pub(super) fn erase(&self, address: u32) -> Result<(), ChipError> {
        let mut control = Cr(0);
        control.set_psize(Psize::PSIZE32);
        control.set_ser(true);
        control.set_snb(sector_of(address));
        FLASH.cr().write_value(control);
        control.set_strt(true);
        let erased = Watchdog::be_patient(|| {
            FLASH.cr().write_value(control);
            wait()
        });
        forget_cached_data();
        erased
    }
}

impl Drop for Operation {
    fn drop(&mut self) {
        let mut control = Cr(0);
        control.set_lock(true);
        FLASH.cr().write_value(control);
    }
}

/// Sectors 0 to 3 have 16 KiB; the fifth begins after them.
const fn sector_of(address: u32) -> u8 {
    ((address - 0x0800_0000) / 0x4000) as u8
}

const _: () = assert!(
    sector_of(SETTINGS[0]) == 1
        && sector_of(SETTINGS[1]) == 2
        && sector_of(FAULTS[0]) == 3
        && sector_of(FAULTS[1]) == 4
);

/// Until the flash has finished, and whether it went well.
fn wait() -> Result<(), ChipError> {
    match idle()? & ERRORS {
        0 => Ok(()),
        errors => Err(ChipError(errors)),
    }
}

/// Until the flash has finished; its status.
fn idle() -> Result<u32, ChipError> {
    let from = DWT::cycle_count();
    loop {
        let status = FLASH.sr().read();
        if !status.bsy() {
            return Ok(status.0);
        }
        if DWT::cycle_count().wrapping_sub(from) > PATIENCE_CLOCKS {
            return Err(ChipError(status.0));
        }
    }
}

/// What the data cache holds of a sector is old then (RM0090, section 3.5.2).
fn forget_cached_data() {
    let access = FLASH.acr();
    access.modify(|access| access.set_dcen(false));
    access.modify(|access| access.set_dcrst(true));
    access.modify(|access| access.set_dcrst(false));
    access.modify(|access| access.set_dcen(true));
}
