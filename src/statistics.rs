//! How the cycle does, second by second.

use can_motion::{CycleCounters, Instant};
use cortex_m::peripheral::DWT;

// A host asks for the figures that matter; they are for who looks into the firmware.
#[cfg(feature = "link")]
use defmt::debug as tell;
#[cfg(not(feature = "link"))]
use defmt::info as tell;

use crate::board::CORE_HZ;
use crate::config::{AXES, CYCLE_US, Drives};
use crate::drives::{Board as _, BoardMaster};

/// Cycles of a second.
const SECOND_CYCLES: u32 = 1_000_000 / CYCLE_US;
/// A second has too few cycles to tell its figures one after the other.
const IS_SLOW: bool = SECOND_CYCLES < AXES as u32 + Part::ALL.len() as u32;
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
    /// There is a second before this one.
    is_later: bool,
}

/// What one line of the log tells of a second. One of them in a cycle: writing a line takes as long as a good part of the cycle itself.
#[derive(Clone, Copy)]
pub(crate) enum Part {
    /// How often something happened.
    Counts,
    /// How long the cycles took.
    Times,
    /// How old the readings are.
    Ages,
}

impl Part {
    /// All of them.
    pub(crate) const ALL: [Self; 3] = [Self::Counts, Self::Times, Self::Ages];
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
            is_later: false,
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
        let left = SECOND_CYCLES.saturating_sub(self.cycles);
        if IS_SLOW {
            (0..AXES).for_each(|axis| self.note_poll_ages(master, axis, now));
        } else if (left as usize) < AXES {
            self.note_poll_ages(master, left as usize, now);
        }
        if left > 0 {
            return None;
        }
        self.counters = master.cycle_counters();
        let next = Self {
            is_later: true,
            ..Self::new()
        };
        Some(core::mem::replace(self, next))
    }

    /// What is to be told in this cycle of the second before.
    pub(crate) fn parts(&self) -> &'static [Part] {
        let part = self.cycles as usize;
        if part >= Part::ALL.len() || !self.is_later {
            return &[];
        }
        match Part::ALL.get(part..part + 1) {
            _ if IS_SLOW => &Part::ALL,
            part => part.unwrap_or(&[]),
        }
    }

    fn note_poll_ages(&mut self, master: &BoardMaster, axis: usize, now: Instant) {
        if let Some(snapshot) = master.snapshot(axis) {
            let [status, position] = Drives::read_at(&snapshot);
            self.oldest_status_ms = self.oldest_status_ms.max(Age::ms(status, now));
            self.oldest_position_ms = self.oldest_position_ms.max(Age::ms(position, now));
        }
    }

    /// One line of the log.
    pub(crate) fn write(&self, part: Part) {
        let counters = &self.counters;
        match part {
            Part::Counts => tell!(
                "{=u32} cycles, {=u32} late, {=u32} missed, {=u32} events dropped; {=u32} bus errors",
                counters.cycles,
                counters.late,
                counters.missed,
                counters.events_dropped,
                self.bus_errors
            ),
            Part::Times => tell!(
                "begun up to {=u32} us late, up to {=u32} clocks long, load {=u32}/1000",
                self.worst_delay_us,
                self.worst_cycle_clocks,
                self.busy_clocks / CLOCKS_PER_PERMILLE
            ),
            Part::Ages => tell!(
                "oldest status {}, position {}",
                Age(self.oldest_status_ms),
                Age(self.oldest_position_ms)
            ),
        }
    }
}
