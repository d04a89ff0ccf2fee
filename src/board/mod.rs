//! The boards. Each is one file with its clocks, pins, bit timing and interrupts; the application sees what `init` returns.
//!
//! A board of your own: copy one of the files, add a feature of its name to Cargo.toml and a line here, and give `build.rs` its memory map.

#[cfg(feature = "stm32f405")]
mod stm32f405;
#[cfg(feature = "stm32g474")]
mod stm32g474;

use cortex_m::peripheral::DWT;
use embassy_stm32::gpio::{Input, Output};
use embassy_stm32::pac;
use embassy_stm32::pac::iwdg::vals::{Key, Pr};

use crate::bus::Bus;
use crate::misbehaviour::{self, Fault};

#[cfg(feature = "stm32f405")]
use stm32f405 as chosen;
#[cfg(feature = "stm32g474")]
use stm32g474 as chosen;

#[cfg(feature = "link-usb")]
pub(crate) use chosen::CYCLE_PRIORITY;
#[cfg(feature = "link")]
pub(crate) use chosen::prescaler;
pub(crate) use chosen::{
    CORE_HZ, LAST_SWITCH_PIN, enable_interrupts, has_lost_clock, init, take_cause,
};

/// Clock of the processor before the board has set its own: the internal oscillator of both chips.
const START_HZ: u32 = 16_000_000;
/// A crystal starts within some milliseconds (STM32F405 data sheet, table 40: 2 ms; STM32G474 data sheet, table 43: 2 ms), or not at all.
const CRYSTAL_CLOCKS: u32 = START_HZ / 10;

/// What a board hands to the application.
pub(crate) struct Board {
    /// The drives' bus: filters set, joining the traffic.
    pub(crate) bus: Bus,
    /// The inputs.
    pub(crate) inputs: InputPins,
    /// The serial port to the host.
    #[cfg(feature = "link")]
    pub(crate) port: crate::link::Port,
}

/// What a start leads to.
pub(crate) struct Start {
    /// The status LED, dark.
    pub(crate) status_led: StatusLed,
    /// The watchdog, running.
    pub(crate) watchdog: Watchdog,
    /// The rest; `None` when the crystal does not run. The internal oscillator is too inaccurate for the bus, so nothing is connected to
    /// it and no drive can be reached.
    pub(crate) board: Option<Board>,
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
    /// As it was set last: it changes seldom, and is set in every cycle.
    lit: Option<bool>,
}

impl StatusLed {
    /// Lights or darkens it.
    #[inline(always)]
    pub(crate) fn set(&mut self, lit: bool) {
        if self.lit != Some(lit) {
            self.lit = Some(lit);
            self.pin.set_level((lit != self.active_low).into());
        }
    }
}

/// The longest period of the watchdog.
#[cfg(all(feature = "link", feature = "stm32f405"))]
const MOST_TICKS: u16 = 4_096;

/// The independent watchdog: resets the chip when it is not fed in time. It cannot be stopped.
pub(crate) struct Watchdog(());

const _: () = assert!(
    crate::config::CYCLE_US <= 10_000,
    "the watchdog may bite after 14 ms, and a cycle feeds it: the cycle must be 10 ms at most"
);

impl Watchdog {
    /// Prescaler and ticks: 20 ms at the nominal 32 kHz of its oscillator; a real one makes it 14 to 38 ms.
    const PRESCALER: Pr = Pr::DIVIDE_BY4;
    const TICKS: u16 = 160;

    /// Starts it. Its period is the longest, half a second, until the first feeding: the oscillator takes the settings over only when it
    /// runs (RM0090, section 21.3.1; RM0440, section 42.3.2).
    fn start() -> Self {
        let registers = pac::IWDG;
        registers.kr().write(|key| key.set_key(Key::START));
        registers.kr().write(|key| key.set_key(Key::ENABLE));
        registers.pr().write(|to| to.set_pr(Self::PRESCALER));
        registers.rlr().write(|to| to.set_rl(Self::TICKS - 1));
        Self(())
    }

    /// Gives it a period of 8 s, or 5 s with the fastest oscillator, while `act` keeps the processor from everything.
    #[cfg(all(feature = "link", feature = "stm32f405"))]
    pub(crate) fn be_patient<R>(act: impl FnOnce() -> R) -> R {
        Self::set_period(Pr::DIVIDE_BY64, MOST_TICKS);
        let result = act();
        Self::set_period(Self::PRESCALER, Self::TICKS);
        result
    }

    /// The settings are taken over at a feeding, and only when the oscillator has seen them (RM0090, section 21.3.1), within five of its
    /// clocks at the prescaler. No feeding of the cycle comes between: it would lock the registers.
    #[cfg(all(feature = "link", feature = "stm32f405"))]
    fn set_period(prescaler: Pr, ticks: u16) {
        let registers = pac::IWDG;
        cortex_m::interrupt::free(|_| {
            registers.kr().write(|key| key.set_key(Key::ENABLE));
            registers.pr().write(|to| to.set_pr(prescaler));
            registers.rlr().write(|to| to.set_rl(ticks - 1));
        });
        let from = DWT::cycle_count();
        let is_seen = || {
            let status = registers.sr().read();
            !status.pvu() && !status.rvu()
        };
        // 5 / (17 kHz / 64) are 19 ms; the cycle feeds meanwhile.
        while !is_seen() && DWT::cycle_count().wrapping_sub(from) < CORE_HZ / 10 {}
        registers.kr().write(|key| key.set_key(Key::RESET));
    }

    /// Feeds it.
    pub(crate) fn feed(&mut self) {
        pac::IWDG.kr().write(|key| key.set_key(Key::RESET));
    }
}

/// Starts the crystal, feeding the watchdog meanwhile; false when it does not run in time. `start` and `is_ready` are the board's.
fn start_crystal(
    watchdog: &mut Watchdog,
    start: impl FnOnce(),
    is_ready: impl Fn() -> bool,
) -> bool {
    start();
    let from = DWT::cycle_count();
    while !is_ready() {
        let is_late = DWT::cycle_count().wrapping_sub(from) > CRYSTAL_CLOCKS;
        if misbehaviour::has(Fault::WaitForTheCrystal) {
            continue;
        }
        if is_late {
            return false;
        }
        watchdog.feed();
    }
    true
}

/// Lets the chip count its clocks; off after a reset.
fn count_clocks() {
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.DCB.enable_trace();
        core.DWT.enable_cycle_counter();
    }
}
