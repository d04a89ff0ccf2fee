//! Firmware of the motion board: streams set-points to DYN servo drives, or speeds to ZLAC8030L hub motors, on CAN.
//!
//! Built for the board (`cargo fw`) this is the image; built for the host it is one line of text, so that `cargo build`,
//! `cargo test` and `cargo clippy --all-targets` at the root need nothing installed. What needs no chip is tested on the host, the whole
//! image in `firmware-tests`.
//!
//! | Module | What |
//! |---|---|
//! | `config` | what a user decides |
//! | `board` | clocks, pins, bit timing, interrupts of each board |
//! | `bus`, `frame` | the sink of the master over the registers of each controller |
//! | `recovery` | the controller's way onto the bus, at the start and after a failure |
//! | `duty`, `cycle_clock` | the interrupts of the beat and of the bus, above the thread |
//! | `app` | the cycle |
//! | `drives` | what differs between the families of drives |
//! | `supervisor`, `debounce` | what the inputs mean |
//! | `home` | homing before it |
//! | `machine`, `orders` | what moves, and what says how: the configuration with its built-in motion, or with `link` the settings and a host |
//! | `store` | with `link`: settings and faults in the flash |
//! | `telemetry`, `words`, `statistics`, `led` | what the board says |
//! | `brown_out` | the option bytes, which only the image for commissioning writes |
//! | `last_words`, `start` | what happens after a failure |
//! | `misbehaviour` | failures on command, for the tests |
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(all(any(test, target_os = "none"), not(other_config)))]
#[cfg_attr(all(feature = "link", target_os = "none"), path = "link/config.rs")]
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
#[cfg_attr(
    not(target_os = "none"),
    allow(dead_code, reason = "the bus is not built for the host")
)]
mod frame;
#[cfg(any(test, target_os = "none"))]
#[cfg_attr(
    not(target_os = "none"),
    allow(dead_code, reason = "the application is not built for the host")
)]
mod led;
#[cfg(any(test, target_os = "none"))]
mod misbehaviour;
#[cfg(any(test, target_os = "none"))]
#[cfg_attr(
    not(target_os = "none"),
    allow(dead_code, reason = "the bus is not built for the host")
)]
mod recovery;
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
#[allow(dead_code, reason = "only the image for commissioning writes it")]
mod brown_out;
#[cfg(target_os = "none")]
mod bus;
#[cfg(target_os = "none")]
mod cycle_clock;
#[cfg(target_os = "none")]
mod drives;
#[cfg(target_os = "none")]
mod duty;
#[cfg(target_os = "none")]
mod home;
#[cfg(target_os = "none")]
mod last_words;
#[cfg(all(target_os = "none", feature = "link"))]
mod link;
#[cfg(target_os = "none")]
#[cfg_attr(feature = "link", path = "link/machine.rs")]
mod machine;
#[cfg(all(target_os = "none", feature = "link"))]
use link as orders;
/// Without the chip: the tests of the log of faults.
#[cfg(all(test, not(target_os = "none")))]
#[allow(dead_code, reason = "the store is not built for the host")]
#[path = "store/fault_log.rs"]
mod fault_log;
#[cfg(all(target_os = "none", not(feature = "link")))]
#[path = "playback.rs"]
mod orders;
/// Without the chip: the tests of the packets of USB.
#[cfg(all(test, not(target_os = "none")))]
#[allow(dead_code, reason = "USB is not built for the host")]
#[path = "link/usb/packets.rs"]
mod packets;
#[cfg(any(test, all(target_os = "none", feature = "link")))]
#[cfg_attr(
    not(target_os = "none"),
    allow(dead_code, reason = "the link is not built for the host")
)]
#[path = "link/rules.rs"]
mod rules;
#[cfg(target_os = "none")]
mod start;
#[cfg(target_os = "none")]
mod statistics;
#[cfg(all(target_os = "none", feature = "link"))]
mod store;
#[cfg(target_os = "none")]
mod telemetry;
#[cfg(target_os = "none")]
#[cfg_attr(feature = "link", path = "link/words.rs")]
mod words;

#[cfg(target_os = "none")]
use defmt_rtt as _;

/// Thread mode keeps only what may wait, the log; the cycle runs above it, in interrupts.
#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    let cause = board::take_cause();
    let history = last_words::take(cause);
    let mut start = board::init();
    telemetry::write_start(cause, &history);
    if !brown_out::is_set() {
        defmt::warn!(
            "the chip may run on a supply that is too low for its clock: set its brown-out level once with `cargo fw --commission`"
        );
    }
    #[cfg(feature = "link-usb")]
    let device = start
        .board
        .as_mut()
        .and_then(|board| board.port.take_device());
    let (orders, mut thread) = orders::prepare(cause, &history, &mut start.watchdog);
    duty::start(duty_of(start, orders, &mut thread, history.is_locked));
    #[cfg(feature = "link-usb")]
    {
        use core::task::{Context, Waker};
        // Every interrupt ends the sleep of the thread, so nothing needs to be woken.
        let mut usb = core::pin::pin!(link::usb::run(device));
        telemetry::run(thread, || {
            let _ = usb.as_mut().poll(&mut Context::from_waker(Waker::noop()));
        })
    }
    #[cfg(not(feature = "link-usb"))]
    telemetry::run(thread, || {})
}

/// What can be done in the cycle after this start. The thread stays where it is: it is large.
#[cfg(target_os = "none")]
#[cfg_attr(
    not(feature = "link"),
    allow(unused_variables, reason = "only a link has a port")
)]
fn duty_of(
    start: board::Start,
    orders: Option<orders::Orders>,
    thread: &mut orders::Thread,
    is_locked: bool,
) -> duty::Duty {
    let standstill = |status_led, watchdog, pattern| {
        duty::Duty::Standstill(duty::Standstill {
            status_led,
            watchdog,
            pattern,
            led: led::LedPattern::new(),
        })
    };
    let Some(board) = start.board else {
        defmt::error!("the crystal does not run: nothing is enabled, and the bus is left alone");
        return standstill(start.status_led, start.watchdog, led::NO_CRYSTAL);
    };
    #[cfg(feature = "link")]
    thread.connect(board.port);
    let Some(orders) = orders else {
        defmt::warn!("there are no settings: nothing moves");
        return standstill(start.status_led, start.watchdog, led::REFUSED);
    };
    let parts = app::Parts {
        bus: board.bus,
        inputs: board.inputs,
        status_led: start.status_led,
        watchdog: start.watchdog,
        is_locked,
    };
    match app::place(parts, orders) {
        Ok(app) => duty::Duty::Motion(app),
        Err(refused) => {
            words::unworkable(&refused.error);
            standstill(refused.status_led, refused.watchdog, led::REFUSED)
        }
    }
}

#[cfg(not(target_os = "none"))]
fn main() {
    println!(
        "motion-board is firmware. Build it for the board: cargo fw. Try it without a board: cargo sim."
    );
}
