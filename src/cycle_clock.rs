//! The clock of the board, and the beat of the cycle: the two counters of 32 bit that both chips have.

use core::sync::atomic::{AtomicU32, Ordering};

use can_motion::Instant;
use embassy_stm32::pac::timer::TimGp32;
use embassy_stm32::{pac, peripherals, rcc};

use crate::config::CYCLE_US;

/// Beats at the end of each period.
const BEAT: TimGp32 = pac::TIM2;
/// Counts microseconds without an end.
const CLOCK: TimGp32 = pac::TIM5;

/// How often [`CLOCK`] has begun anew; the cycle counts it.
static WRAPS: AtomicU32 = AtomicU32::new(0);

/// Starts both counters; the first beat comes a period from now. To be called once, when the clocks of the chip are set.
pub(crate) fn start() {
    rcc::enable_and_reset::<peripherals::TIM2>();
    rcc::enable_and_reset::<peripherals::TIM5>();
    // Both are on the same bus.
    let prescaler = rcc::frequency::<peripherals::TIM5>().0 / 1_000_000 - 1;
    for (timer, period_us) in [(CLOCK, 0), (BEAT, CYCLE_US)] {
        timer.psc().write_value(prescaler as u16);
        timer.arr().write_value(period_us.wrapping_sub(1));
        // Takes the settings over, which also raises the mark of a new period.
        timer.egr().write(|event| event.set_ug(true));
        timer.sr().write(|_| {});
        timer.cr1().write(|control| control.set_cen(true));
    }
    BEAT.dier().write(|enables| enables.set_uie(true));
}

/// Microseconds since the start of the board.
fn uptime_us() -> u64 {
    loop {
        let wraps = WRAPS.load(Ordering::Relaxed);
        let count = CLOCK.cnt().read();
        // It has begun anew since the cycle looked; what was read before that is not concerned.
        let has_wrapped = CLOCK.sr().read().uif() && count <= u32::MAX / 2;
        if WRAPS.load(Ordering::Relaxed) == wraps {
            return u64::from(wraps.wrapping_add(has_wrapped.into())) << 32 | u64::from(count);
        }
    }
}

/// Cycles since the start of the board.
#[cfg(feature = "link")]
pub(crate) fn cycle() -> u64 {
    uptime_us() / u64::from(CYCLE_US)
}

defmt::timestamp!("{=u64:us}", uptime_us());

/// Takes note of a beat, for its interrupt.
pub(crate) fn acknowledge() {
    // Clears the mark of the update; others are not used.
    BEAT.sr().write(|_| {});
}

/// The beginning of a cycle.
#[derive(Clone, Copy)]
pub(crate) struct Beat {
    /// When it was planned.
    pub(crate) planned: Instant,
    /// How much later it came, in microseconds.
    pub(crate) delay_us: u32,
    /// Now.
    pub(crate) now: Instant,
}

/// Keeps the phase of the beats and leaves out those that the cycle was too late for: made up for at once, they would be a burst of
/// set-points on the bus.
pub(crate) struct Beats {
    planned: Instant,
    /// When the latest beat was taken, and what the counter said.
    taken: Instant,
    count: u32,
}

impl Beats {
    /// No beat has come yet.
    pub(crate) const fn new() -> Self {
        Self {
            planned: Instant::from_us(0),
            taken: Instant::from_us(0),
            count: 0,
        }
    }

    /// The time since the start of the board, after the first beat.
    #[inline]
    pub(crate) fn now(&self) -> Instant {
        self.taken + CLOCK.cnt().read().wrapping_sub(self.count)
    }

    /// Takes the beat that has come, for its interrupt; the latest one when there were several.
    pub(crate) fn take(&mut self) -> Beat {
        acknowledge();
        if CLOCK.sr().read().uif() {
            CLOCK.sr().write(|_| {});
            WRAPS.store(
                WRAPS.load(Ordering::Relaxed).wrapping_add(1),
                Ordering::Relaxed,
            );
        }
        let (delay_us, now) = (BEAT.cnt().read(), Instant::from_us(uptime_us()));
        (self.taken, self.count) = (now, now.as_us() as u32);
        // The counters run in step, but are read one after the other.
        let begun_us = (now.us_since(self.planned) as u32).saturating_sub(delay_us);
        let periods = (begun_us + CYCLE_US / 2) / CYCLE_US;
        self.planned = self.planned + periods * CYCLE_US;
        Beat {
            planned: self.planned,
            delay_us,
            now,
        }
    }
}
