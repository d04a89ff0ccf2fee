//! How the cycle does, second by second.

use can_motion::{CycleCounters, Instant};
use cortex_m::peripheral::DWT;

use crate::board::CORE_HZ;
use crate::config::{AXES, CYCLE_US, Drives};
use crate::drives::{Board as _, BoardMaster};

/// Cycles of a second.
const SECOND_CYCLES: u32 = 1_000_000 / CYCLE_US;
/// Core clocks of a thousandth of a second of work.
const CLOCKS_PER_PERMILLE: u32 = CORE_HZ / 1_000;

/// Figures of one second; the counters of the master count from the start.
#[derive(Clone, Copy)]
pub(crate) struct Statistics {
    counters: CycleCounters,
    cycles: u32,
    bus_errors: u32,
    has_told_bus_error: bool,
    worst_delay_us: u32,
    /// Core clocks, by the chip's own counter.
    worst_cycle_clocks: u32,
    busy_clocks: u32,
    oldest_status_ms: u32,
    oldest_position_ms: u32,
}

/// An age as the log shows it.
struct Age(u32);

impl Age {
    /// Of what was not read yet.
    const NEVER_MS: u32 = u32::MAX;

    /// Of a reading; the master shows none that is older than some minutes.
    fn ms(read: Option<Instant>, now: Instant) -> u32 {
        read.map_or(Self::NEVER_MS, |at| now.us_since(at) as u32 / 1_000)
    }
}

impl defmt::Format for Age {
    fn format(&self, formatter: defmt::Formatter<'_>) {
        if self.0 == Self::NEVER_MS {
            defmt::write!(formatter, "never read");
        } else {
            defmt::write!(formatter, "{=u32} ms", self.0);
        }
    }
}

/// A stretch of work, measured from here.
#[derive(Clone, Copy)]
pub(crate) struct Stretch(u32);

impl Stretch {
    /// Begins now.
    pub(crate) fn begin() -> Self {
        Self(DWT::cycle_count())
    }

    fn clocks(self) -> u32 {
        DWT::cycle_count().wrapping_sub(self.0)
    }
}

impl Statistics {
    /// A second begins.
    pub(crate) const fn new() -> Self {
        Self {
            counters: CycleCounters {
                cycles: 0,
                late: 0,
                missed: 0,
                events_dropped: 0,
            },
            cycles: 0,
            bus_errors: 0,
            has_told_bus_error: false,
            worst_delay_us: 0,
            worst_cycle_clocks: 0,
            busy_clocks: 0,
            oldest_status_ms: 0,
            oldest_position_ms: 0,
        }
    }

    /// There were so many errors on the bus.
    pub(crate) fn note_bus_errors(&mut self, errors: u32) {
        self.bus_errors = self.bus_errors.saturating_add(errors);
    }

    /// Whether an error of the bus is the first one of the second that is told: without an acknowledging drive there is one in every frame.
    pub(crate) fn is_first_bus_error(&mut self) -> bool {
        !core::mem::replace(&mut self.has_told_bus_error, true)
    }

    /// Frames came in between the cycles, or the controller had room again.
    pub(crate) fn note_service(&mut self, stretch: Stretch) {
        self.busy_clocks = self.busy_clocks.wrapping_add(stretch.clocks());
    }

    /// A cycle began `delay_us` after its plan. Returns the figures when a second is over.
    pub(crate) fn note_cycle(
        &mut self,
        delay_us: u32,
        stretch: Stretch,
        master: &BoardMaster,
        now: Instant,
    ) -> Option<Self> {
        let clocks = stretch.clocks();
        self.cycles += 1;
        self.worst_delay_us = self.worst_delay_us.max(delay_us);
        self.worst_cycle_clocks = self.worst_cycle_clocks.max(clocks);
        self.busy_clocks = self.busy_clocks.wrapping_add(clocks);
        if self.cycles < SECOND_CYCLES {
            return None;
        }
        self.counters = master.cycle_counters();
        self.note_poll_ages(master, now);
        Some(core::mem::replace(self, Self::new()))
    }

    fn note_poll_ages(&mut self, master: &BoardMaster, now: Instant) {
        for snapshot in (0..AXES).filter_map(|axis| master.snapshot(axis)) {
            let [status_ms, position_ms] =
                Drives::read_at(&snapshot).map(|read_at| Age::ms(read_at, now));
            self.oldest_status_ms = self.oldest_status_ms.max(status_ms);
            self.oldest_position_ms = self.oldest_position_ms.max(position_ms);
        }
    }

    /// One line of the log.
    pub(crate) fn write(&self) {
        let counters = &self.counters;
        defmt::info!(
            "{=u32} cycles, {=u32} late, {=u32} missed, {=u32} events dropped; {=u32} bus errors; begun up to {=u32} us late, up to {=u32} clocks long, load {=u32}/1000; oldest status {}, position {}",
            counters.cycles,
            counters.late,
            counters.missed,
            counters.events_dropped,
            self.bus_errors,
            self.worst_delay_us,
            self.worst_cycle_clocks,
            self.busy_clocks / CLOCKS_PER_PERMILLE,
            Age(self.oldest_status_ms),
            Age(self.oldest_position_ms)
        );
    }
}
