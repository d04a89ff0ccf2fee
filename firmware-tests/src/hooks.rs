//! What is done before each straight run of code, and at the few instructions that Unicorn does not know.

use unicorn_engine::{RegisterARM, uc_error};

use crate::cpu::{self, Engine, takeable};
use crate::image::Image;
use crate::instructions;
use crate::profile::Run;

/// Why the processor stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Leave {
    /// It waits for an event.
    WaitForEvent,
    /// It waits for an interrupt.
    WaitForInterrupt,
    /// It returns from an exception.
    Return,
    /// It calls the supervisor.
    SupervisorCall,
    /// It met a breakpoint.
    Breakpoint,
    /// It has nothing urgent to do: a hint that the hardware ignores.
    Yield,
    /// It reads flash that is being programmed or erased, at this address.
    FlashBusy(u32),
    /// It met something else; the number is Unicorn's.
    Fault(u32),
}

const YIELD: u16 = 0xBF10;
const WFE: u16 = 0xBF20;
const WFI: u16 = 0xBF30;
const SEV: u16 = 0xBF40;
/// Unicorn's numbers.
const SUPERVISOR_CALL: u32 = 2;
const BREAKPOINT: u32 = 7;
const EXCEPTION_RETURN: u32 = 8;

/// Puts the hooks in place.
///
/// # Errors
/// When Unicorn refuses one.
pub fn install(engine: &mut Engine<'_>, image: &Image) -> Result<(), uc_error> {
    engine.add_block_hook(1, 0, before_run)?;
    engine.add_intr_hook(|engine, number| {
        stop(
            engine,
            match number {
                EXCEPTION_RETURN => Leave::Return,
                SUPERVISOR_CALL => Leave::SupervisorCall,
                BREAKPOINT => Leave::Breakpoint,
                other => Leave::Fault(other),
            },
        );
    })?;
    for (code, leave) in [
        (YIELD, Leave::Yield),
        (WFE, Leave::WaitForEvent),
        (WFI, Leave::WaitForInterrupt),
    ] {
        for address in image.halfwords(code).map(u64::from) {
            engine.add_code_hook(address, address, move |engine, _, _| stop(engine, leave))?;
        }
    }
    for address in image.halfwords(SEV).map(u64::from) {
        engine.add_code_hook(address, address, |engine, _, _| {
            engine.get_data_mut().event = true;
        })?;
    }
    Ok(())
}

fn stop(engine: &mut Engine<'_>, leave: Leave) {
    engine.get_data_mut().leave = Some(leave);
    // It can only fail when nothing runs.
    let _ = engine.emu_stop();
}

/// Time moves by whole runs: one instruction is one cycle. A stop asked for here takes effect before the run's first instruction.
fn before_run(engine: &mut Engine<'_>, address: u64, bytes: u32) {
    let soc = engine.get_data();
    if soc.now >= soc.deadline
        || soc.flash.is_busy(address as u32)
        || soc.nvic.first_pending().is_some() && takeable(engine).is_some()
    {
        let _ = engine.emu_stop();
        return;
    }
    let known = engine.get_data().runs.known(address, bytes);
    let instructions = known.unwrap_or_else(|| count(engine, address, bytes));
    let is_masked = cpu::get(engine, RegisterARM::PRIMASK) & 1 != 0;
    let soc = engine.get_data_mut();
    soc.instructions += u64::from(instructions);
    soc.now += u64::from(instructions);
    soc.masked
        .note(address as u32, u64::from(instructions), is_masked);
    let exception = soc.nvic.innermost();
    if let Some(profile) = &mut soc.profile {
        profile.note(Run {
            address: address as u32,
            bytes,
            instructions,
            exception,
        });
    }
}

fn count(engine: &mut Engine<'_>, address: u64, bytes: u32) -> u32 {
    let mut code = vec![0; bytes as usize];
    // The engine has just translated this code, so it can be read.
    let _ = engine.mem_read(address, &mut code);
    let instructions = instructions::count(&code);
    engine
        .get_data_mut()
        .runs
        .note(address, bytes, instructions);
    instructions
}
