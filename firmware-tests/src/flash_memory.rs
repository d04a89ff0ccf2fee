//! The flash as memory of the emulated processor: its content, and waiting while it changes.
//!
//! The processor's own stores to flash come here because the memory is read-only. What cannot be read now is hidden: an instruction that
//! tries leaves the processor and is executed again when the flash is free.

use core::mem::replace;
use core::ops::Range;

use unicorn_engine::{HookType, Prot, uc_error};

use crate::cpu::Engine;
use crate::flash::DOUBLE_WORD;
use crate::hooks::Leave;
use crate::nvic::NMI;
use crate::soc::{FLASH, Soc};
use crate::transfers;

/// How far the memory of the emulator follows the flash.
#[derive(Debug, Default)]
pub struct FlashMemory {
    version: u64,
    hidden: Vec<Range<u32>>,
}

impl FlashMemory {
    /// Follows what has changed in the flash.
    ///
    /// # Panics
    /// When Unicorn refuses, which it does not for memory that is mapped.
    pub fn follow(&mut self, engine: &mut Engine<'_>) {
        if engine.get_data().flash.version() == self.version {
            return;
        }
        self.version = engine.get_data().flash.version();
        for range in engine.get_data_mut().flash.take_changed() {
            let soc = engine.get_data_mut();
            soc.runs.forget(&range);
            let bytes = soc.flash.content().read(range.clone()).map(<[u8]>::to_vec);
            let bytes = bytes.expect("changes lie in flash");
            let written = engine.mem_write(u64::from(range.start), &bytes);
            written.expect("flash is mapped");
            forget_code(engine, &range).expect("the engine is initialised");
        }
        let hidden = engine.get_data().flash.hidden();
        if hidden != self.hidden {
            self.hide(engine, hidden);
        }
    }

    fn hide(&mut self, engine: &mut Engine<'_>, hidden: Vec<Range<u32>>) {
        for range in replace(&mut self.hidden, hidden) {
            protect(engine, &range, Prot::READ | Prot::EXEC);
        }
        for range in &self.hidden {
            protect(engine, range, Prot::EXEC);
        }
        let flushed = engine.ctl_flush_tlb();
        flushed.expect("the engine is initialised");
    }
}

/// Unicorn keeps translated code, and a write to read-only memory does not tell it.
fn forget_code(engine: &mut Engine<'_>, range: &Range<u32>) -> Result<(), uc_error> {
    if range.len() as u32 > DOUBLE_WORD {
        engine.ctl_flush_tb()
    } else {
        engine.ctl_remove_cache(range.start.into(), range.end.into())
    }
}

fn protect(engine: &mut Engine<'_>, range: &Range<u32>, access: Prot) {
    let (first, bytes) = (u64::from(range.start), range.len() as u64);
    let done = engine.mem_protect(first, bytes, access);
    done.expect("flash is mapped");
}

/// Puts the hooks of loads and stores in place.
///
/// # Errors
/// When Unicorn refuses one.
pub fn install(engine: &mut Engine<'_>, flash_bytes: u64) -> Result<(), uc_error> {
    let (first, last) = (u64::from(FLASH), u64::from(FLASH) + flash_bytes - 1);
    engine.add_mem_hook(
        HookType::MEM_WRITE_PROT,
        first,
        last,
        |engine, _, address, size, value| {
            wait(engine);
            let soc = engine.get_data_mut();
            soc.store_to_flash(address as u32, size as u32, value as u32);
            // Unicorn goes on, and its memory stays as it is.
            true
        },
    )?;
    engine.add_mem_hook(
        HookType::MEM_READ_PROT,
        first,
        last,
        |engine, _, address, _, _| {
            let soc = engine.get_data_mut();
            if soc.flash.is_busy(address as u32) {
                soc.leave = Some(Leave::FlashBusy(address as u32));
                return false;
            }
            if soc.flash.read_data(address as u32) {
                soc.nvic.pend(NMI);
                soc.deadline = 0;
            }
            true
        },
    )?;
    Ok(())
}

/// Waits within an instruction until nothing changes the flash. Time passes, peripherals and DMA go on; interrupts are taken after it.
pub fn wait(engine: &mut Engine<'_>) {
    if !engine.get_data().flash.is_changing() {
        return;
    }
    let limit_ns = replace(&mut engine.get_data_mut().limit_ns, u64::MAX);
    loop {
        engine.get_data_mut().process();
        transfers::carry_out(engine);
        let soc = engine.get_data_mut();
        if ends_waiting(soc) {
            break;
        }
        soc.stall();
    }
    let soc = engine.get_data_mut();
    soc.limit_ns = limit_ns;
    soc.deadline = 0;
}

fn ends_waiting(soc: &Soc) -> bool {
    !soc.flash.is_changing()
        || soc.reset_request.is_some()
        || !soc.flash.has_supply_at_ns(soc.now_ns())
}
