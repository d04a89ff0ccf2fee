//! What is kept and told of a cycle, and what the spectator makes of it.

use can_motion::{Event, EventKind, Instant};
use drive_sim::{Outcome, Record};
use dyn_can::{Alarm, DriveId};

use super::{Bench, GROUP};
use crate::control::Wish;
use crate::output::tell;
use crate::recording::{AxisSample, Sample, WireFrame, servo_words};
use crate::sim::error::SimError;
use crate::sim::faults::Fault;
use crate::sim::spectator::Order;

impl Bench<'_> {
    pub(super) fn drain_log(&mut self) {
        let bit_ns = self.setup.bit_rate.bit_ns();
        let is_idle = self.recorder.is_idle();
        for record in self.bench.bus_mut().log_mut().drain() {
            self.watch.record(&record);
            let is_from_master = record.node == self.node;
            if let Some(frame) = wire_frame(&record, is_from_master, bit_ns).filter(|_| !is_idle) {
                self.recorder.frame(frame);
            }
        }
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
            let (kind, text) = servo_words(event.kind);
            self.recorder.happened(event.at.as_us(), axis, kind, text);
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
            let bus = match self.setup.bus.as_str() {
                "" => String::new(),
                name => format!(" bus {name}:"),
            };
            tell(format_args!("{} s:{bus}{drive} {fault}", event.at));
        }
    }

    pub(super) fn record_sample(&mut self, is_late: bool) {
        if self.recorder.is_idle() {
            return;
        }
        let (now, now_ns) = (
            Instant::from_us(self.bench.now_ns() / 1_000),
            self.bench.now_ns(),
        );
        let axes = self.places.iter().zip(&self.devices);
        let sample = Sample {
            at_us: now.as_us(),
            number: self.cycle - 1,
            load: self.bench.bus().load_since(&self.cycle_mark),
            is_late,
            axes: axes
                .filter_map(|(&place, &device)| {
                    let position = self.bench.device(device).position_counts(now_ns);
                    Some(AxisSample::new(
                        &self.master.snapshot(place)?,
                        Some(position),
                        now,
                    ))
                })
                .collect(),
            wheels: Vec::new(),
        };
        self.recorder.cycle(sample);
        self.cycle_mark = self.bench.bus().load_mark();
    }

    /// Returns what is asked of the motion.
    pub(super) fn obey_spectator(&mut self) -> Result<Vec<Wish>, SimError> {
        let mut wishes = Vec::new();
        let Some(recording) = self.recorder.model() else {
            return Ok(wishes);
        };
        for order in self.spectator.after_cycle(recording)? {
            match order {
                Order::Stop => {
                    self.master.stop(self.now(), GROUP);
                    self.stopped = true;
                }
                Order::Motion(wish) => wishes.push(wish),
                Order::Alarm(axis) => self.apply_to(axis, |drive| Fault::Alarm {
                    drive,
                    alarm: Alarm::OverCurrent,
                    repeat_ns: None,
                }),
                Order::Unplug(axis) => self.apply_to(axis, |drive| Fault::Unplug { drive }),
                Order::PlugIn(axis) => self.apply_to(axis, |drive| Fault::PlugIn { drive }),
            }
        }
        Ok(wishes)
    }

    fn apply_to(&mut self, axis: usize, fault: impl Fn(DriveId) -> Fault) {
        if let Some(&drive) = self.setup.drives.get(axis) {
            self.apply(fault(drive));
        }
    }
}

/// An attempt of the virtual bus, for the recording.
pub(crate) fn wire_frame(record: &Record, is_from_master: bool, bit_ns: u64) -> Option<WireFrame> {
    Some(WireFrame {
        start_ns: record.start_ns,
        end_ns: record.end_ns,
        bits: ((record.end_ns - record.start_ns) / bit_ns) as u32,
        frame: can_decode::Frame::from_can(&record.frame)?,
        from_master: Some(is_from_master),
        failure: failure(record.outcome),
        is_received: record.outcome.is_received(),
    })
}

/// How an attempt failed.
const fn failure(outcome: Outcome) -> Option<&'static str> {
    match outcome {
        Outcome::Delivered => None,
        Outcome::EofError => {
            Some("received, but repeated by its sender after an error in its last bit")
        }
        Outcome::BitError => Some("destroyed by a bit error"),
        Outcome::Collision => Some("destroyed by a frame with the same identifier"),
        Outcome::AckError => Some("acknowledged by nobody"),
        Outcome::Interrupted => Some("cut off: its sender left the bus"),
        _ => Some("not received"),
    }
}
