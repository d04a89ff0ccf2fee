//! The TWAI controller of an ESP32-C3, over `esp-hal`: it implements `embedded_can::nb::Can`, so `service` is all that is needed.
#![no_std]
#![forbid(unsafe_code)]

use can_motion::plan::TxOrder;
use can_motion::{Instant, service};
use esp_hal::DriverMode;
use esp_hal::time::Instant as Clock;
use esp_hal::twai::Twai;
use one_axis::{CYCLE_US, Refused, cycle, master};

fn now() -> Instant {
    Instant::from_us(Clock::now().duration_since_epoch().as_micros())
}

/// Runs for ever. The controller has its bit rate and is started.
///
/// # Errors
/// When the settings of the axis cannot work.
pub fn run<M: DriverMode>(mut can: Twai<'_, M>) -> Result<(), Refused> {
    let mut master = master(TxOrder::Fifo)?;
    let mut next = now();
    for count in 0.. {
        cycle(&mut master, next, count);
        next = next + CYCLE_US;
        while now() < next {
            let _ = service(&mut master, &mut can, now());
        }
    }
    Ok(())
}
