//! Firmware of the motion board: streams set-points to DYN servo drives on CAN.
//!
//! Built for the board (`cargo fw`) this is the image; built for the host it is one line of text, so that `cargo build`,
//! `cargo test` and `cargo clippy --all-targets` at the root need nothing installed. Everything the host can test lives in the
//! crates under `crates/`.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod app;
#[cfg(target_os = "none")]
mod automatic_enable;
#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod bus;
#[cfg(target_os = "none")]
mod config;
#[cfg(target_os = "none")]
mod cycle_clock;
#[cfg(target_os = "none")]
mod playback;
#[cfg(target_os = "none")]
mod telemetry;

#[cfg(target_os = "none")]
use {defmt_rtt as _, panic_probe as _};

/// Thread mode keeps only what may wait; the cycle runs above it, in the interrupt executor of the board.
#[cfg(target_os = "none")]
#[embassy_executor::main]
async fn main(_thread: embassy_executor::Spawner) {
    let board = board::init();
    match app::run(board.bus, board.status_led) {
        Ok(cycle) => board.cycle.spawn(cycle),
        // The pool of the task has one place and this is its only spawn; should it ever be full, a silent board is the safe one.
        Err(error) => defmt::error!("the cycle did not start: {}", error),
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "motion-board is firmware. Build it for the board: cargo fw. Try it without a board: cargo sim."
    );
}
