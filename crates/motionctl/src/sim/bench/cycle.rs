//! One cycle of master and bus, and the faults that are due before it.

use drive_sim::{ControllerState, ErrorState};

use super::Bench;
use crate::control::Wish;
use crate::recording::Kind;
use crate::sim::error::SimError;
use crate::sim::faults::{Fault, Rig};

impl Bench<'_> {
    /// One cycle: set-points and a request out, replies in, until the next cycle is due.
    pub(super) fn one_cycle(&mut self) -> Result<Vec<Wish>, SimError> {
        self.apply_due_faults();
        let now = self.now();
        let is_missed = self.cycles_to_miss > 0;
        self.cycles_to_miss = self.cycles_to_miss.saturating_sub(1);
        if !is_missed {
            self.master.begin_cycle(now);
        }
        self.watch.cycle_begins(&self.master, &self.places);
        self.cycle += 1;
        let end_ns = self.cycle * u64::from(self.setup.cycle_us) * 1_000;
        if is_missed {
            self.bench.advance_to(end_ns);
        } else {
            self.serve_until(end_ns);
        }
        self.drain_log();
        let is_late = self.watch.cycle_ends(self.bench.bus());
        self.collect_events();
        self.watch.note(self.now(), &self.master, &self.places);
        self.record_sample(is_late);
        self.obey_spectator()
    }

    fn serve_until(&mut self, end_ns: u64) {
        let bus_off = ControllerState::On(ErrorState::BusOff);
        loop {
            let now = self.now();
            if self.bench.bus().controller(self.node).state() == bus_off {
                self.master.on_bus_off(now);
            }
            // Whether it is idle or blocked, the next event on the bus is the next chance.
            let _ = can_motion::service(&mut self.master, &mut self.bench.port(self.node), now);
            if !self.bench.step_to(end_ns) {
                break;
            }
        }
    }

    fn apply_due_faults(&mut self) {
        let Some(start_ns) = self.motion_start_ns else {
            return;
        };
        let at_ns = self.bench.now_ns() - start_ns;
        while let Some(fault) = self.setup.faults.next_due(at_ns) {
            self.apply(fault);
        }
    }

    pub(super) fn apply(&mut self, fault: Fault) {
        if let Fault::MissCycles { cycles } = fault {
            self.cycles_to_miss += cycles;
        }
        fault.apply(&mut Rig {
            bench: &mut self.bench,
            master: self.node,
            drives: &self.setup.drives,
            devices: &self.devices,
        });
        let at_us = self.now().as_us();
        let axis = fault
            .drive()
            .and_then(|drive| self.setup.drives.iter().position(|other| *other == drive));
        self.recorder
            .happened(at_us, axis, Kind::Cause, fault.to_string());
    }
}
