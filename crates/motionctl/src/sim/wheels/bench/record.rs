//! What is kept and told of a cycle, and what the spectator makes of it.

use can_motion::Instant;
use can_motion::wheel::{WheelEventKind, WheelSnapshot};
use drive_sim::DeviceId;
use embedded_can::{Frame as _, Id};
use zlac8030l::{PdoNumber, Service};

use super::{Bench, WheelWatch};
use crate::control::Wish;
use crate::recording::{AxisSample, COUNTS_PER_RPM, Kind, Sample};
use crate::set_points::Order as MotionOrder;
use crate::sim::bench::wire_frame;
use crate::sim::error::SimError;
use crate::sim::spectator::Order;
use crate::sim::wheels::csv::WheelRow;
use crate::sim::wheels::faults::Fault;
use crate::sim::wheels::words::words;

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
            let (kind, text) = words(event.kind);
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

    pub(super) fn record_cycle(&mut self) -> Result<(), SimError> {
        if self.table.is_none() && self.recorder.is_idle() {
            return Ok(());
        }
        let now_ns = self.bench.now_ns();
        let now = Instant::from_us(now_ns / 1_000);
        let load = self.bench.bus().load_since(&self.cycle_mark);
        self.cycle_mark = self.bench.bus().load_mark();
        let rows = self.rows(now_ns);
        let is_late = self.motion_start_ns.is_some() && self.set_points_of_cycle < rows.len();
        if let Some(table) = &mut self.table {
            table
                .row(now, load, is_late, &rows)
                .map_err(SimError::Log)?;
        }
        let resolution = f64::from(self.setup.speed_resolution);
        self.recorder.cycle(Sample {
            at_us: now.as_us(),
            number: self.cycle - 1,
            load,
            is_late,
            axes: rows
                .iter()
                .map(|row| sample(row, resolution, now))
                .collect(),
        });
        Ok(())
    }

    fn rows(&self, now_ns: u64) -> Vec<WheelRow> {
        let wheels = self.wheels.iter().zip(&self.devices);
        let row = |(watch, device): (&WheelWatch, &DeviceId)| {
            let drive = self.bench.device(*device);
            Some(WheelRow {
                snapshot: self.master.snapshot(watch.place)?,
                shaft_rpm: drive.speed_rpm(now_ns),
                travel_counts: drive.travel_counts(now_ns),
            })
        };
        wheels.filter_map(row).collect()
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

/// Speeds in thousandths of an r/min.
fn sample(row: &WheelRow, resolution: f64, now: Instant) -> AxisSample {
    let WheelRow {
        snapshot,
        shaft_rpm,
        ..
    } = row;
    let speed = |number: i32| (f64::from(number) / resolution * COUNTS_PER_RPM).round() as i32;
    let age = |at: Instant| u32::try_from(now.us_since(at)).ok();
    let (target, sent) = (speed(snapshot.target), speed(snapshot.sent));
    let WheelSnapshot { feedback, .. } = snapshot;
    AxisSample {
        target,
        sent,
        position: Some((shaft_rpm * COUNTS_PER_RPM).round() as i64),
        backlog: target - sent,
        status_age_us: feedback.status.and_then(|read| age(read.at)),
        position_age_us: feedback.position_counts.and_then(|read| age(read.at)),
        state: Some(snapshot.state),
    }
}
