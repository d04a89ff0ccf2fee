//! Exception entry and return (ARMv7-M, sections B1.5.6 to B1.5.8). Unicorn executes instructions and has no interrupt controller.

use unicorn_engine::{RegisterARM, Unicorn};

use crate::nvic::{HARD_FAULT, Pending};
use crate::soc::Soc;

/// The processor with everything around it.
pub type Engine<'a> = Unicorn<'a, Soc>;

/// Cycles of an exception entry, and of a return, without wait states.
const EXCEPTION_CYCLES: u64 = 12;
const BASIC_FRAME: u32 = 32;
/// Frame with the floating-point registers.
const EXTENDED_FRAME: u32 = 104;
const CONTROL_PROCESS_STACK: u32 = 1 << 1;
const CONTROL_FLOATING_POINT: u32 = 1 << 2;
const XPSR_EXCEPTION: u32 = 0x1FF;
const XPSR_THUMB: u32 = 1 << 24;
/// The stack was not aligned to eight bytes; kept in the stacked xPSR.
const XPSR_ALIGNER: u32 = 1 << 9;
const XPSR_FLAGS: u32 = 0xF80F_0000;
const TO_HANDLER: u32 = 0xFFFF_FFF1;
const TO_THREAD: u32 = 0xFFFF_FFF9;
const TO_THREAD_PROCESS_STACK: u32 = 0xFFFF_FFFD;
const WITHOUT_FLOATING_POINT: u32 = 1 << 4;

const STACKED: [RegisterARM; 7] = [
    RegisterARM::R0,
    RegisterARM::R1,
    RegisterARM::R2,
    RegisterARM::R3,
    RegisterARM::R12,
    RegisterARM::LR,
    RegisterARM::PC,
];
const FLOATING_POINT: [RegisterARM; 16] = [
    RegisterARM::S0,
    RegisterARM::S1,
    RegisterARM::S2,
    RegisterARM::S3,
    RegisterARM::S4,
    RegisterARM::S5,
    RegisterARM::S6,
    RegisterARM::S7,
    RegisterARM::S8,
    RegisterARM::S9,
    RegisterARM::S10,
    RegisterARM::S11,
    RegisterARM::S12,
    RegisterARM::S13,
    RegisterARM::S14,
    RegisterARM::S15,
];

/// A register. Reading one that exists never fails.
pub fn get(engine: &Engine<'_>, register: RegisterARM) -> u32 {
    engine.reg_read(register).expect("the register exists") as u32
}

/// Writes a register.
pub fn set(engine: &mut Engine<'_>, register: RegisterARM, value: u32) {
    engine
        .reg_write(register, u64::from(value))
        .expect("the register exists");
}

/// Unicorn keeps "in a handler" in its translation flags and renews them on a write to CPSR only.
fn renew_mode(engine: &mut Engine<'_>) {
    let value = get(engine, RegisterARM::CPSR);
    set(engine, RegisterARM::CPSR, value);
}

/// The pending exception that would be taken now, the masks of the processor applied.
pub fn takeable(engine: &Engine<'_>) -> Option<u16> {
    let nvic = &engine.get_data().nvic;
    let Pending {
        priority,
        exception,
    } = nvic.first_pending()?;
    if priority >= nvic.execution_priority() {
        return None;
    }
    let masked = |register| get(engine, register) & 1 != 0;
    if priority >= 0 && (masked(RegisterARM::PRIMASK) || masked(RegisterARM::FAULTMASK)) {
        return None;
    }
    let base = get(engine, RegisterARM::BASEPRI) & 0xFF;
    (base == 0 || priority < base as i32).then_some(exception)
}

/// Enters the handler of an exception.
///
/// A frame that does not fit the stack is lost: the processor goes on to the handler of the hard fault without it, which can
/// then only reset.
pub fn enter(engine: &mut Engine<'_>, exception: u16) {
    let (control, stack, xpsr) = (
        get(engine, RegisterARM::CONTROL),
        get(engine, RegisterARM::SP),
        get(engine, RegisterARM::XPSR),
    );
    let floating_point =
        control & CONTROL_FLOATING_POINT != 0 && !engine.get_data().skip_floating_point;
    let size = if floating_point {
        EXTENDED_FRAME
    } else {
        BASIC_FRAME
    };
    let frame = stack.wrapping_sub(size) & !7;
    let stacked = stack_frame(
        engine,
        xpsr | if stack & 4 != 0 { XPSR_ALIGNER } else { 0 },
        floating_point,
    );
    let stored = engine.mem_write(u64::from(frame), &stacked).is_ok();
    let exception = if stored { exception } else { HARD_FAULT };

    set(engine, RegisterARM::SP, frame);
    let back = match (
        xpsr & XPSR_EXCEPTION != 0,
        control & CONTROL_PROCESS_STACK != 0,
    ) {
        (true, _) => TO_HANDLER,
        (false, false) => TO_THREAD,
        (false, true) => TO_THREAD_PROCESS_STACK,
    };
    let back = if floating_point {
        back & !WITHOUT_FLOATING_POINT
    } else {
        back
    };
    set(
        engine,
        RegisterARM::CONTROL,
        control & !(CONTROL_PROCESS_STACK | CONTROL_FLOATING_POINT),
    );
    set(
        engine,
        RegisterARM::XPSR_NZCVQG,
        xpsr & XPSR_FLAGS | XPSR_THUMB | u32::from(exception),
    );
    set(engine, RegisterARM::LR, back);
    let vector = engine.get_data().nvic.vector_table() + 4 * u32::from(exception);
    let handler = word(engine, vector);
    set(engine, RegisterARM::PC, handler);
    renew_mode(engine);
    let soc = engine.get_data_mut();
    soc.nvic.activate(exception);
    soc.note_exception(EXCEPTION_CYCLES);
}

fn stack_frame(engine: &Engine<'_>, xpsr: u32, floating_point: bool) -> Vec<u8> {
    let mut words: Vec<u32> = STACKED.map(|register| get(engine, register)).to_vec();
    words.push(xpsr);
    if floating_point {
        words.extend(FLOATING_POINT.map(|register| get(engine, register)));
        words.extend([get(engine, RegisterARM::FPSCR), 0]);
    }
    words.into_iter().flat_map(u32::to_le_bytes).collect()
}

/// Returns from the handler of an exception by the code that was in its link register; tells which exception it was.
pub fn leave(engine: &mut Engine<'_>, code: u32) -> u16 {
    let exception = (get(engine, RegisterARM::XPSR) & XPSR_EXCEPTION) as u16;
    let process_stack = code & 4 != 0;
    let floating_point = code & WITHOUT_FLOATING_POINT == 0;
    let frame = get(
        engine,
        if process_stack {
            RegisterARM::PSP
        } else {
            RegisterARM::SP
        },
    );
    let size = if floating_point {
        EXTENDED_FRAME
    } else {
        BASIC_FRAME
    };
    let words: Vec<u32> = (0..size)
        .step_by(4)
        .map(|at| word(engine, frame + at))
        .collect();
    for (register, &value) in STACKED.into_iter().zip(&words).take(6) {
        set(engine, register, value);
    }
    if floating_point {
        for (register, &value) in FLOATING_POINT.into_iter().zip(&words[8..]) {
            set(engine, register, value);
        }
        set(engine, RegisterARM::FPSCR, words[24]);
    }
    let (pc, xpsr) = (words[6], words[7]);
    set(engine, RegisterARM::XPSR_NZCVQG, xpsr & !XPSR_ALIGNER);
    let control =
        get(engine, RegisterARM::CONTROL) & !(CONTROL_PROCESS_STACK | CONTROL_FLOATING_POINT);
    let stack_bit = if process_stack {
        CONTROL_PROCESS_STACK
    } else {
        0
    };
    let float_bit = if floating_point {
        CONTROL_FLOATING_POINT
    } else {
        0
    };
    set(
        engine,
        RegisterARM::CONTROL,
        control | stack_bit | float_bit,
    );
    let padding = if xpsr & XPSR_ALIGNER != 0 { 4 } else { 0 };
    set(engine, RegisterARM::SP, frame + size + padding);
    set(engine, RegisterARM::PC, pc | 1);
    renew_mode(engine);
    let soc = engine.get_data_mut();
    soc.nvic.deactivate(exception);
    soc.note_exception(EXCEPTION_CYCLES);
    exception
}

/// A reset: registers, stack and entry from the vector table.
pub fn reset(engine: &mut Engine<'_>) {
    let table = engine.get_data().nvic.vector_table();
    let (stack, entry) = (word(engine, table), word(engine, table + 4));
    for register in [
        RegisterARM::PRIMASK,
        RegisterARM::FAULTMASK,
        RegisterARM::BASEPRI,
        RegisterARM::CONTROL,
    ] {
        set(engine, register, 0);
    }
    set(engine, RegisterARM::XPSR_NZCVQG, XPSR_THUMB);
    set(engine, RegisterARM::SP, stack);
    set(engine, RegisterARM::LR, u32::MAX);
    set(engine, RegisterARM::PC, entry);
    renew_mode(engine);
}

/// A word of memory; 0 where there is none.
pub fn word(engine: &Engine<'_>, address: u32) -> u32 {
    let mut bytes = [0; 4];
    match engine.mem_read(u64::from(address), &mut bytes) {
        Ok(()) => u32::from_le_bytes(bytes),
        Err(_) => 0,
    }
}
