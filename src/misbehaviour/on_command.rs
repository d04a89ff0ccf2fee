//! Failures on command, for the tests on the emulated board.

use core::hint::black_box;
use core::sync::atomic::{AtomicU8, AtomicU32, Ordering};

use super::Fault;

/// Mistakes that are made, a bit each, when the upper half says that a test wrote it: memory after power-on is anything. The start-up
/// code leaves it alone, so it can be written before the first instruction.
#[unsafe(no_mangle)]
#[unsafe(link_section = ".uninit.FAULTS")]
static FAULTS: AtomicU32 = AtomicU32::new(0);
const MARK: u32 = 0xFA17_0000;
const MARK_BITS: u32 = 0xFFFF_0000;

/// Whether a mistake is made.
pub(crate) fn has(fault: Fault) -> bool {
    let faults = FAULTS.load(Ordering::Relaxed);
    // A write, so that the compiler cannot take the value for a constant.
    FAULTS.store(black_box(faults), Ordering::Relaxed);
    faults & MARK_BITS == MARK && faults & fault as u32 != 0
}

/// What the next cycle shall do; a debug probe writes it.
#[unsafe(no_mangle)]
static MISBEHAVE: AtomicU8 = AtomicU8::new(0);

/// Two milliseconds at 168 MHz, two cycles an instruction in the loop of the delay.
const BLIND_CLOCKS: u32 = 336_000;

/// Fails as told.
pub(crate) fn act() {
    match MISBEHAVE.swap(0, Ordering::Relaxed) {
        1 => stall(),
        2 => panic!("told to"),
        3 => {
            black_box(fill_the_stack(0));
        }
        4 => cortex_m::asm::udf(),
        5 => cortex_m::asm::delay(BLIND_CLOCKS),
        _ => {}
    }
}

/// The cycle does not come to its end.
fn stall() -> ! {
    loop {
        core::hint::spin_loop();
    }
}

fn fill_the_stack(depth: u32) -> u32 {
    let frame = black_box([depth; 64]);
    if depth == u32::MAX {
        return 0;
    }
    fill_the_stack(depth + 1).wrapping_add(frame[(depth % 64) as usize])
}
