//! The boards. Each is one file with its clocks, pins, bit timing and interrupts; the application sees what `init` returns.
//!
//! A board of your own: copy one of the files, add a feature of its name to Cargo.toml and a line here, and give `build.rs` its memory map.

#[cfg(feature = "stm32f405")]
mod stm32f405;
#[cfg(feature = "stm32g474")]
mod stm32g474;

use embassy_executor::SendSpawner;
use embassy_stm32::gpio::{Input, Output};
use embassy_stm32::peripherals::IWDG;
use embassy_stm32::wdg::IndependentWatchdog;

use crate::bus::Bus;
use crate::start::Cause;

#[cfg(feature = "stm32f405")]
pub(crate) use stm32f405::{CORE_HZ, init};
#[cfg(feature = "stm32g474")]
pub(crate) use stm32g474::{CORE_HZ, init};

/// Bytes of the stack, as in the memory map of every board.
pub(crate) const STACK_BYTES: usize = 48 * 1024;

/// The watchdog's period at the nominal frequency of its oscillator; a real one makes it 14 to 38 ms.
const WATCHDOG_US: u32 = 20_000;

/// What a board hands to the application.
pub(crate) struct Board {
    /// The drives' bus: filters set, joining the traffic.
    pub(crate) bus: Bus,
    /// The inputs.
    pub(crate) inputs: InputPins,
    /// The status LED, dark.
    pub(crate) status_led: StatusLed,
    /// The watchdog, not started.
    pub(crate) watchdog: Watchdog,
    /// Starts the task that runs the cycle.
    pub(crate) cycle: SendSpawner,
    /// Why the board started.
    pub(crate) cause: Cause,
}

/// The inputs. Each has a pull-down: a wire that is broken or not connected permits nothing.
pub(crate) struct InputPins {
    stop: Input<'static>,
    enable: Input<'static>,
    run: Input<'static>,
}

/// Levels of the inputs now, not debounced.
pub(crate) struct InputLevels {
    /// The stop circuit is closed.
    pub(crate) stop_closed: bool,
    /// The drives may be enabled.
    pub(crate) enable: bool,
    /// The motion shall run.
    pub(crate) run: bool,
}

impl InputPins {
    /// Looks at the pins.
    pub(crate) fn read(&self) -> InputLevels {
        InputLevels {
            stop_closed: self.stop.is_high(),
            enable: self.enable.is_high(),
            run: self.run.is_high(),
        }
    }
}

/// The status LED.
pub(crate) struct StatusLed {
    pin: Output<'static>,
    /// The LED hangs between supply and pin, so a low level lights it.
    active_low: bool,
}

impl StatusLed {
    /// Lights or darkens it.
    pub(crate) fn set(&mut self, lit: bool) {
        self.pin.set_level((lit != self.active_low).into());
    }
}

/// The independent watchdog: resets the chip when it is not fed in time. Once started it cannot be stopped.
pub(crate) struct Watchdog(IndependentWatchdog<'static, IWDG>);

impl Watchdog {
    /// Starts it.
    pub(crate) fn start(&mut self) {
        self.0.unleash();
    }

    /// Feeds it.
    pub(crate) fn feed(&mut self) {
        self.0.pet();
    }
}
