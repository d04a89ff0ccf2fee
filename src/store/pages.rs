//! The flash of the STM32G474 (RM0440, section 3) with two banks: the records lie in the second one, so the code, in the first one, goes on
//! while they are erased and programmed. Each double word has an error correction and is programmed once; one that a cut of the supply
//! left half programmed may have two errors, which raise the non-maskable interrupt when it is read (section 3.3.1).

use core::ptr;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m::peripheral::DWT;
use embassy_stm32::pac::FLASH;
use embassy_stm32::pac::flash::regs::{Cr, Sr};
use record_store::Reading;

use super::areas::ChipError;
use crate::board::CORE_HZ;

/// A double word.
pub(super) const UNIT: usize = 8;
/// Pages of 2 KiB at the start of the second bank, two for each area.
const BANK: u32 = 0x0804_0000;
const PAGE: u32 = 2_048;
const PAGES_OF_AREA: u32 = 2;
const AREA: u32 = PAGES_OF_AREA * PAGE;
pub(super) const SETTINGS: [u32; 2] = [BANK, BANK + AREA];
pub(super) const FAULTS: [u32; 2] = [BANK + 2 * AREA, BANK + 3 * AREA];
/// What unlocks the control register.
const KEYS: [u32; 2] = [0x4567_0123, 0xCDEF_89AB];
/// EOP and every error but that of protected reading; written as 1 they are cleared.
const FLAGS: Sr = Sr(0b11_1111_1011);
const ERRORS: u32 = FLAGS.0 & !1;
/// More than the longest operation: 25 ms.
const PATIENCE_CLOCKS: u32 = CORE_HZ / 4;

/// The thread reads records.
static IS_READING: AtomicBool = AtomicBool::new(false);
/// A double word among them has two errors.
static IS_DAMAGED: AtomicBool = AtomicBool::new(false);

/// Reads, and tells whether a double word was damaged.
pub(super) fn watch(read: impl FnOnce()) -> Reading {
    // The flash tells an error only when the one before it is forgotten.
    forget_errors();
    IS_DAMAGED.store(false, Ordering::SeqCst);
    IS_READING.store(true, Ordering::SeqCst);
    read();
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    IS_READING.store(false, Ordering::SeqCst);
    if IS_DAMAGED.load(Ordering::SeqCst) {
        Reading::Unreadable
    } else {
        Reading::Good
    }
}

/// For the non-maskable interrupt: whether it is a damaged record, which the thread is told of. Anything else is a failure.
pub(crate) fn has_met_damage() -> bool {
    let is_ours = FLASH.eccr().read().eccd() && IS_READING.load(Ordering::SeqCst);
    if is_ours {
        forget_errors();
        IS_DAMAGED.store(true, Ordering::SeqCst);
    }
    is_ours
}

fn forget_errors() {
    FLASH.eccr().modify(|errors| errors.set_eccd(true));
}

/// The control register is unlocked while it exists.
pub(super) struct Operation(());

impl Operation {
    pub(super) fn begin() -> Result<Self, ChipError> {
        let options = FLASH.optr().read();
        if !options.dbank() {
            // The pages lie elsewhere in a flash of one bank, and the code would stand still.
            return Err(ChipError(options.0));
        }
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
        control.set_pg(true);
        FLASH.cr().write_value(control);
        let (low, high) = unit.split_at(UNIT / 2);
        let word = |half: &[u8]| {
            half.first_chunk()
                .map_or(u32::MAX, |half| u32::from_le_bytes(*half))
        };
        let place = address as *mut u32;
        // SAFETY: a double word of the areas, where neither code nor data of the image lies.
        unsafe {
            ptr::write_volatile(place, word(low));
            ptr::write_volatile(place.add(1), word(high));
        }
        wait()
    }

    pub(super) fn erase(&self, address: u32) -> Result<(), ChipError> {
        let first = (address - BANK) / PAGE;
        for page in first..first + PAGES_OF_AREA {
            let mut control = Cr(0);
            control.set_per(true);
            control.set_bker(true);
            control.set_pnb(page as u8);
            FLASH.cr().write_value(control);
            control.set_strt(true);
            FLASH.cr().write_value(control);
            wait()?;
        }
        forget_cached_data();
        Ok(())
    }
}

impl Drop for Operation {
    fn drop(&mut self) {
        let mut control = Cr(0);
        control.set_lock(true);
        FLASH.cr().write_value(control);
    }
}

/// Until the flash has finished, and whether it went well. Nothing else may be asked of it before: who reads the bank, or writes the
/// control register, waits with every interrupt.
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

/// What the data cache holds of a page is old then (RM0440, section 3.3.4).
fn forget_cached_data() {
    let access = FLASH.acr();
    access.modify(|access| access.set_dcen(false));
    access.modify(|access| access.set_dcrst(true));
    access.modify(|access| access.set_dcrst(false));
    access.modify(|access| access.set_dcen(true));
}
