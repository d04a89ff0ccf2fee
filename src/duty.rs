//! What runs at the priority of the cycle: the beat of the cycle and the interrupts of the bus.
//!
//! The cycle is no task: its timer and the controller interrupt at one priority, the handlers share what they work with, and a frame that
//! has gone out is followed by the next one from the interrupt that reports it. None of them interrupts another, so each has everything for
//! itself while it runs; that is how RTIC shares resources among tasks of one priority, too. The thread below has the log alone.

use core::cell::UnsafeCell;

use embassy_stm32::interrupt;

use crate::app::App;
use crate::board::{self, StatusLed, Watchdog};
use crate::cycle_clock;
use crate::led::LedPattern;

/// What the board does in every cycle.
pub(crate) enum Duty {
    /// It moves the machine.
    Motion(&'static mut App),
    /// It shows why it cannot.
    Standstill(Standstill),
}

/// Shows why nothing can be done, for ever.
pub(crate) struct Standstill {
    /// The status LED.
    pub(crate) status_led: StatusLed,
    /// The watchdog, running.
    pub(crate) watchdog: Watchdog,
    /// What the LED shows.
    pub(crate) pattern: u16,
    /// How far it is.
    pub(crate) led: LedPattern,
}

struct OfTheCycle(UnsafeCell<Option<Duty>>);

// SAFETY: only the handlers of one priority touch it, see `with`, and before them `start` on the same core.
unsafe impl Sync for OfTheCycle {}

static DUTY: OfTheCycle = OfTheCycle(UnsafeCell::new(None));

/// Begins with the duty. To be called once.
pub(crate) fn start(duty: Duty) {
    // SAFETY: the interrupts whose handlers touch it are enabled below, and nowhere else.
    unsafe { *DUTY.0.get() = Some(duty) };
    cycle_clock::start();
    board::enable_interrupts();
}

/// # Safety
/// To be called by handlers of the priority of the cycle alone, and not within `act`.
#[inline(always)]
unsafe fn with(act: impl FnOnce(&mut Duty)) {
    // SAFETY: the handlers do not interrupt each other, so there is one reference at a time.
    if let Some(duty) = unsafe { &mut *DUTY.0.get() } {
        act(duty);
    }
}

#[interrupt]
fn TIM2() {
    // SAFETY: the boards give this interrupt the priority of the cycle.
    unsafe {
        with(|duty| match duty {
            Duty::Motion(app) => app.cycle(),
            Duty::Standstill(standstill) => standstill.cycle(),
        });
    }
}

/// A frame has come in, or there is room for one.
///
/// # Safety
/// For handlers of the priority of the cycle alone.
pub(crate) unsafe fn on_traffic() {
    // SAFETY: as the caller promises.
    unsafe {
        with(|duty| {
            if let Duty::Motion(app) = duty {
                app.on_traffic();
            }
        });
    }
}

impl Standstill {
    fn cycle(&mut self) {
        cycle_clock::acknowledge();
        self.watchdog.feed();
        self.status_led.set(self.led.play(self.pattern));
    }
}
