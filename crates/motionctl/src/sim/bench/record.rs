//! What is kept and told of a cycle, and what the spectator makes of it.

use std::io::Write;

use can_motion::{Event, EventKind, Instant};
use drive_sim::CandumpLine;

use super::{Bench, GROUP};
use crate::control::Wish;
use crate::output::tell;
use crate::sim::error::SimError;
use crate::sim::recording::{AxisSample, Sample};
use crate::sim::spectator::Order;

impl Bench<'_> {
    pub(super) fn drain_log(&mut self) -> Result<(), SimError> {
        for record in self.bench.bus_mut().log_mut().drain() {
            self.watch.record(&record);
            if let Some(recording) = &mut self.recording {
                recording.frame(&record);
            }
            if let (Some(file), Some(line)) = (&mut self.candump, CandumpLine::new(&record, "can0"))
            {
                writeln!(file, "{line}").map_err(SimError::Log)?;
            }
        }
        Ok(())
    }

    pub(super) fn collect_events(&mut self) {
        while let Some(event) = self.master.next_event() {
            self.watch.event(&event);
            self.report(&event);
            let axis = event.axis.and_then(|axis| {
                self.places
                    .iter()
                    .position(|place| *place == usize::from(axis))
            });
            if let Some(recording) = &mut self.recording {
                recording.event(&event, axis);
            }
        }
    }

    fn report(&self, event: &Event<EventKind>) {
        if self.spectator.owns_terminal() {
            return;
        }
        if let EventKind::Fault(fault) = event.kind {
            let mut axes = (0..).zip(&self.places);
            let axis = axes.find(|(_, place)| Some(**place) == event.axis.map(usize::from));
            let drive = axis.and_then(|(axis, _): (usize, _)| self.setup.drives.get(axis));
            let drive = drive.map_or(String::new(), |drive| format!(" drive {drive}:"));
            tell(format_args!("{} s:{drive} {fault}", event.at));
        }
    }

    pub(super) fn record_sample(&mut self, is_late: bool) {
        let Some(recording) = &mut self.recording else {
            return;
        };
        let (now, now_ns) = (
            Instant::from_us(self.bench.now_ns() / 1_000),
            self.bench.now_ns(),
        );
        let axes = self.places.iter().zip(&self.devices);
        recording.samples.push(Sample {
            at_us: now.as_us(),
            load: self.bench.bus().load_since(&self.cycle_mark),
            is_late,
            axes: axes
                .filter_map(|(&place, &device)| {
                    let position = self.bench.device(device).position_counts(now_ns);
                    Some(AxisSample::new(
                        &self.master.snapshot(place)?,
                        position,
                        now,
                    ))
                })
                .collect(),
        });
        self.cycle_mark = self.bench.bus().load_mark();
    }

    /// Returns what is asked of the motion.
    pub(super) fn obey_spectator(&mut self) -> Result<Vec<Wish>, SimError> {
        let mut wishes = Vec::new();
        let Some(recording) = &self.recording else {
            return Ok(wishes);
        };
        for order in self
            .spectator
            .after_cycle(recording, &self.master, &self.places)?
        {
            match order {
                Order::Stop => {
                    self.master.stop(self.now(), GROUP);
                    self.stopped = true;
                }
                Order::Motion(wish) => wishes.push(wish),
                Order::Fault(fault) => self.apply(fault),
            }
        }
        Ok(wishes)
    }
}
