//! What is kept and told of a cycle, and what the spectator makes of it.

use can_motion::Instant;
use can_motion::wheel::WheelEventKind;
use embedded_can::{Frame as _, Id};
use zlac8030l::{PdoNumber, Service};

use super::Bench;
use crate::control::Wish;
use crate::recording::{AxisSample, Kind, Sample, WheelReadings, wheel_words};
use crate::set_points::Order as MotionOrder;
use crate::sim::bench::wire_frame;
use crate::sim::error::SimError;
use crate::sim::spectator::Order;
use crate::sim::wheels::faults::Fault;

impl Bench<'_> {
    /// Counts the set-points that ended on the wire, and records every frame.
    pub(super) fn drain_log(&mut self) {
        self.set_points_of_cycle = 0;
        let bit_ns = self.setup.bit_rate.bit_ns();
        let is_idle = self.recorder.is_idle();
        for record in self.bench.bus_mut().log_mut().drain() {
            let id = match record.frame.id() {
                Id::Standard(id) => Service::of(id.as_raw()).ok(),
                Id::Extended(_) => None,
            };
            let is_set_point = matches!(id, Some(Service::Rpdo(PdoNumber::Pdo1, _)));
            let is_received = record.outcome.is_received();
            self.set_points_of_cycle += usize::from(is_set_point && is_received);
            let is_from_master = record.node == self.node;
            if let Some(frame) = wire_frame(&record, is_from_master, bit_ns).filter(|_| !is_idle) {
                self.recorder.frame(frame);
            }
        }
    }

    pub(super) fn collect_events(&mut self) {
        while let Some(event) = self.master.next_event() {
            self.faults += u32::from(matches!(event.kind, WheelEventKind::Fault(_)));
            let wheel = event.axis.and_then(|place| {
                let mut wheels = self.wheels.iter();
                wheels.position(|watch| watch.place == usize::from(place))
            });
            let (kind, text) = wheel_words(event.kind);
            self.recorder.happened(event.at.as_us(), wheel, kind, text);
        }
    }

    /// A phase of the run begins.
    pub(super) fn phase(&mut self, text: &str) {
        let at_us = self.now().as_us();
        self.recorder.happened(at_us, None, Kind::Phase, text);
    }

    /// Commands a fault, and says so.
    pub(super) fn apply(&mut self, fault: Fault) {
        if let Fault::MissCycles { cycles } = fault {
            self.cycles_to_miss += cycles;
        }
        fault.apply(&mut self.bench, &self.setup.nodes, &self.devices);
        let at_us = self.now().as_us();
        let mut nodes = self.setup.nodes.iter();
        let wheel = fault.node();
        let wheel = wheel.and_then(|node| nodes.position(|other| *other == node));
        self.recorder
            .happened(at_us, wheel, Kind::Cause, fault.to_string());
    }

    pub(super) fn record_cycle(&mut self) {
        if self.recorder.is_idle() {
            return;
        }
        let now_ns = self.bench.now_ns();
        let now = Instant::from_us(now_ns / 1_000);
        let load = self.bench.bus().load_since(&self.cycle_mark);
        self.cycle_mark = self.bench.bus().load_mark();
        let has_begun = self.motion_start_ns.is_some();
        let (axes, wheels) = self.samples(now_ns);
        self.recorder.cycle(Sample {
            at_us: now.as_us(),
            number: self.cycle - 1,
            load,
            is_late: has_begun && self.set_points_of_cycle < self.wheels.len(),
            axes,
            wheels,
        });
    }

    fn samples(&self, now_ns: u64) -> (Vec<AxisSample>, Vec<WheelReadings>) {
        let (resolution, now) = (
            self.setup.speed_resolution,
            Instant::from_us(now_ns / 1_000),
        );
        let wheels = self.wheels.iter().zip(&self.devices);
        let sample = wheels.filter_map(|(watch, device)| {
            let snapshot = self.master.snapshot(watch.place)?;
            let drive = self.bench.device(*device);
            let speed_rpm = Some(drive.speed_rpm(now_ns));
            let travel_counts = Some(drive.travel_counts(now_ns));
            Some((
                AxisSample::of_wheel(&snapshot, resolution, speed_rpm, now),
                WheelReadings::new(&snapshot.feedback, travel_counts),
            ))
        });
        sample.unzip()
    }

    pub(super) fn obey_spectator(&mut self) -> Result<(), SimError> {
        let Some(recording) = self.recorder.model() else {
            return Ok(());
        };
        for order in self.spectator.after_cycle(recording)? {
            match order {
                Order::Stop | Order::Motion(Wish::Order(MotionOrder::Stop)) => self.stopped = true,
                // Speeds have no path on which they could be paused.
                Order::Motion(_) => {}
                // An over-current, as with other drives.
                Order::Alarm(wheel) => {
                    self.apply_to(wheel, |node| Fault::Trip { node, bits: 0x0004 });
                }
                Order::Unplug(wheel) => self.apply_to(wheel, |node| Fault::Unplug { node }),
                Order::PlugIn(wheel) => self.apply_to(wheel, |node| Fault::PlugIn { node }),
            }
        }
        Ok(())
    }

    fn apply_to(&mut self, wheel: usize, fault: impl Fn(zlac8030l::NodeId) -> Fault) {
        if let Some(&node) = self.setup.nodes.get(wheel) {
            self.apply(fault(node));
        }
    }
}
