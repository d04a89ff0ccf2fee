//! Failures on command, for the tests on the emulated board. Not part of any image that moves a machine.

use core::hint::black_box;
use core::sync::atomic::{AtomicU8, Ordering};

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
