//! The application loop: the cycle of the master, and reading in between.

use embassy_futures::select::{Either, select};
use embassy_time::{Duration, Ticker, Timer, with_timeout};
use embedded_can::nb::Can as _;

use crate::board::StatusLed;
use crate::bus::{Bus, FaultState};

/// Period of the cycle.
const CYCLE: Duration = Duration::from_millis(1);
/// The drives answer only after their own start; measured from our start, because both share one supply.
const DRIVE_POWER_ON: Duration = Duration::from_millis(150);
/// How long joining the bus may take before it is reported, and again after each report.
const JOIN_REPORT: Duration = Duration::from_secs(1);
/// Cycles between two changes of the status LED.
const LED_CYCLES: u32 = 500;

/// Runs for ever: every millisecond a cycle; whenever a frame arrives, it is read at once, for the receive FIFO holds only three.
#[embassy_executor::task]
pub(crate) async fn run(mut bus: Bus, mut status_led: StatusLed) {
    Timer::after(DRIVE_POWER_ON).await;
    while with_timeout(JOIN_REPORT, bus.joined()).await.is_err() {
        defmt::warn!("the bus is never idle: check transceiver, wiring and termination");
    }
    defmt::info!("on the bus");

    let mut ticker = Ticker::every(CYCLE);
    let mut state = FaultState::ErrorActive;
    let mut cycles: u32 = 0;
    loop {
        match select(ticker.next(), bus.frame_arrived()).await {
            Either::First(()) => {
                drain(&mut bus);
                state = watch(&mut bus, state);
                cycles = cycles.wrapping_add(1);
                if cycles.is_multiple_of(LED_CYCLES) {
                    status_led.toggle();
                }
            }
            Either::Second(()) => drain(&mut bus),
        }
    }
}

/// Reads everything that has arrived.
fn drain(bus: &mut Bus) {
    loop {
        match bus.receive() {
            Ok(frame) => defmt::trace!("received {}", frame),
            Err(nb::Error::Other(error)) => defmt::warn!("bus: {}", error),
            Err(nb::Error::WouldBlock) => return,
        }
    }
}

/// Reports a change of the fault state and takes the controller's way back from bus-off one step further; the state is returned.
fn watch(bus: &mut Bus, before: FaultState) -> FaultState {
    let now = bus.fault_state();
    if now != before {
        defmt::warn!("bus: {} after {}", now, before);
    }
    if now == FaultState::BusOff && bus.recover().is_ok() {
        defmt::warn!("bus: recovered");
    }
    now
}
