//! See `hot_path::path`.
#![cfg_attr(target_os = "none", no_std, no_main)]
#![forbid(unsafe_code)]

#[cfg(target_os = "none")]
use panic_never as _;

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    // The emulator's processor takes one cycle for an instruction.
    hot_path::path::exercise(cortex_m::peripheral::DWT::cycle_count);
    loop {
        cortex_m::asm::wfi();
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("{}", hot_path::HOST_MESSAGE);
}
