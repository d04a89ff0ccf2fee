//! What the board says: events as they come, a line of statistics every second.

use can_motion::{Event, EventKind, Master};
use embassy_time::Duration;

use crate::config::{AXES, MASTER};

/// Log lines take time in which no interrupt is served, so a burst of events is spread over cycles.
const EVENTS_PER_CYCLE: usize = 4;
/// Cycles from one line of statistics to the next.
const REPORT_CYCLES: u32 = 1_000_000 / MASTER.cycle_us;

/// Collects and tells.
pub(crate) struct Telemetry {
    cycles: u32,
    bus_errors: u32,
    longest_delay: Duration,
    longest_work: Duration,
}

impl Telemetry {
    /// Nothing measured yet.
    pub(crate) const fn new() -> Self {
        Self {
            cycles: 0,
            bus_errors: 0,
            longest_delay: Duration::MIN,
            longest_work: Duration::MIN,
        }
    }

    /// A cycle began `delay` after its plan and had its first frames with the controller after `work`.
    pub(crate) fn note_cycle(&mut self, delay: Duration, work: Duration) {
        self.cycles += 1;
        self.longest_delay = self.longest_delay.max(delay);
        self.longest_work = self.longest_work.max(work);
    }

    /// Tells what there is to tell in this cycle.
    pub(crate) fn report(&mut self, master: &mut Master<AXES>) {
        for _ in 0..EVENTS_PER_CYCLE {
            let Some(event) = master.next_event() else {
                break;
            };
            self.tell(&event);
        }
        if self.cycles >= REPORT_CYCLES {
            self.report_cycles(master);
            *self = Self::new();
        }
    }

    /// Without an acknowledging drive there is an error in every frame, so only the first of a second gets a line.
    fn tell(&mut self, event: &Event) {
        match event.kind {
            EventKind::Fault(_) | EventKind::BusOff => defmt::error!("{}", event),
            EventKind::State { .. } | EventKind::Revision(_) | EventKind::BusRecovered => {
                defmt::info!("{}", event);
            }
            EventKind::BusError(_) if self.bus_errors > 0 => self.bus_errors += 1,
            EventKind::BusError(_) => {
                self.bus_errors = 1;
                defmt::warn!("{}", event);
            }
            _ => defmt::warn!("{}", event),
        }
    }

    /// Cycles and dropped events since the start; bus errors and longest times of the latest second.
    fn report_cycles(&self, master: &Master<AXES>) {
        let cycle = master.cycle_counters();
        defmt::info!(
            "{=u32} cycles, {=u32} late, {=u32} missed, {=u32} events dropped; {=u32} bus errors, begun up to {=u64} us late, busy up to {=u64} us",
            cycle.cycles,
            cycle.late,
            cycle.missed,
            cycle.events_dropped,
            self.bus_errors,
            self.longest_delay.as_micros(),
            self.longest_work.as_micros()
        );
    }
}
