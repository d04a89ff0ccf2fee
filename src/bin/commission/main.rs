//! Sets the option bytes of a chip, once in the life of a board, in the place of the firmware: `cargo fw --commission`.
//!
//! It touches neither the bus nor the crystal, and has no watchdog: nothing may interrupt the writing. Flash the firmware afterwards.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
#[path = "../../brown_out.rs"]
mod brown_out;

#[cfg(target_os = "none")]
use cortex_m::peripheral::DWT;
#[cfg(target_os = "none")]
use defmt_rtt as _;

/// For so long the supply must have been above 2.9 V without a break before anything is written.
#[cfg(target_os = "none")]
const STEADY_MS: u32 = 1_000;
/// Clocks of a millisecond: the internal oscillator of both chips has 16 MHz.
#[cfg(target_os = "none")]
const MS_CLOCKS: u32 = 16_000;

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    commission();
    loop {
        cortex_m::asm::wfi();
    }
}

#[cfg(target_os = "none")]
fn commission() {
    let _peripherals = embassy_stm32::init(embassy_stm32::Config::default());
    if brown_out::is_set() {
        defmt::info!("the brown-out level is set already: nothing was written");
        return;
    }
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
    }
    brown_out::watch_supply();
    wait_for_steady_supply();
    brown_out::set();
    if brown_out::is_set() {
        defmt::info!(
            "the brown-out level is set: switch the board off and on, then flash the firmware"
        );
    } else {
        defmt::error!("the option bytes did not take the brown-out level: they may be protected");
    }
}

/// By the chip's own counter: what an instruction takes depends on the flash.
#[cfg(target_os = "none")]
fn pass_ms() {
    let from = DWT::cycle_count();
    while DWT::cycle_count().wrapping_sub(from) < MS_CLOCKS {}
}

#[cfg(target_os = "none")]
fn wait_for_steady_supply() {
    let mut steady_ms = 0;
    while steady_ms < STEADY_MS {
        pass_ms();
        steady_ms = if brown_out::is_supply_high() {
            steady_ms + 1
        } else {
            0
        };
    }
}

/// Nothing here panics; should it, the chip stands still.
#[cfg(target_os = "none")]
#[panic_handler]
fn panic(_info: &core::panic::PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    loop {
        cortex_m::asm::wfi();
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!("this is an image for the board: cargo fw --commission");
}
