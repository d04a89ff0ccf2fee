//! Firmware of the motion board: streams set-points to DYN servo drives on CAN.
//!
//! Built for the board (`cargo fw`) this is the image; built for the host it is one line of text, so that `cargo build`,
//! `cargo test` and `cargo clippy --all-targets` at the root need nothing installed. What needs no chip is tested on the host, the whole
//! image in `firmware-tests`.
//!
//! | Module | What |
//! |---|---|
//! | `config` | what a user decides |
//! | `board` | clocks, pins, bit timing, interrupts of each board |
//! | `bus` | `embedded_can::nb::Can` over each controller |
//! | `app` | the cycle, in an interrupt executor above the thread |
//! | `supervisor`, `debounce` | what the inputs mean |
//! | `playback` | the built-in motion |
//! | `telemetry`, `statistics`, `led` | what the board says |
//! | `last_words`, `start` | what happens after a failure |
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(all(any(test, target_os = "none"), not(other_config)))]
#[cfg_attr(
    not(target_os = "none"),
    allow(dead_code, reason = "the application is not built for the host")
)]
mod config;
/// A file that `cargo fw --config` names, in the place of `src/config.rs`.
#[cfg(all(any(test, target_os = "none"), other_config))]
mod config {
    include!(env!("MOTION_BOARD_CONFIG_FILE"));
}
#[cfg(any(test, target_os = "none"))]
mod debounce;
#[cfg(any(test, target_os = "none"))]
mod led;
#[cfg(any(test, target_os = "none"))]
mod supervisor;
#[cfg(any(test, target_os = "none"))]
#[cfg_attr(
    any(not(target_os = "none"), feature = "stm32g474"),
    allow(
        dead_code,
        reason = "the bus is not built for the host, and FDCAN takes nothing back"
    )
)]
mod transmit_places;

#[cfg(target_os = "none")]
mod app;
#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod bus;
#[cfg(target_os = "none")]
mod cycle_clock;
#[cfg(target_os = "none")]
mod event_words;
#[cfg(target_os = "none")]
mod last_words;
#[cfg(all(target_os = "none", feature = "misbehave"))]
mod misbehaviour;
#[cfg(target_os = "none")]
mod playback;
#[cfg(target_os = "none")]
mod start;
#[cfg(target_os = "none")]
mod statistics;
#[cfg(target_os = "none")]
mod telemetry;

#[cfg(target_os = "none")]
use defmt_rtt as _;

/// Thread mode keeps only what may wait, the log; the cycle runs above it, in the interrupt executor of the board.
#[cfg(target_os = "none")]
#[embassy_executor::main]
async fn main(_thread: embassy_executor::Spawner) {
    let last_words = last_words::take();
    let board = board::init();
    telemetry::write_start(board.cause, last_words.as_ref());
    let parts = app::Parts {
        bus: board.bus,
        inputs: board.inputs,
        status_led: board.status_led,
        watchdog: board.watchdog,
        failed: last_words.is_some() || board.cause == start::Cause::Watchdog,
    };
    match app::place(parts) {
        // Each task's pool has one place and this is its only spawn; should it ever be full, a silent board is the safe one.
        Ok(app) => match (app::run(app), cycle_clock::run()) {
            (Ok(cycle), Ok(clock)) => {
                board.cycle.spawn(cycle);
                board.cycle.spawn(clock);
            }
            (Err(error), _) | (_, Err(error)) => {
                defmt::error!("the cycle did not start: {}", error);
            }
        },
        Err(error) => defmt::error!("the configuration cannot work: {}", error),
    }
    telemetry::run().await
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "motion-board is firmware. Build it for the board: cargo fw. Try it without a board: cargo sim."
    );
}
