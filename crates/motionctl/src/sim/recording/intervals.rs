//! How evenly the set-points of each axis end on the wire: the interval from one to the next, less the cycle.

use drive_sim::{NodeId, Outcome, Record};
use dyn_can::{DriveId, FunctionCode};
use embedded_can::{Frame as _, Id};

/// Deviations of all intervals of a run.
#[derive(Debug)]
pub(crate) struct Intervals {
    master: NodeId,
    /// Identifier of the set-points and end of the latest one, for each axis.
    axes: Vec<(u16, Option<u64>)>,
    deviations_us: Vec<f32>,
}

impl Intervals {
    pub(super) fn new(master: NodeId, drives: &[DriveId]) -> Self {
        let axis = |drive: &DriveId| (drive.can_id(FunctionCode::GoRelativePosPd), None);
        Self {
            master,
            axes: drives.iter().map(axis).collect(),
            deviations_us: Vec::new(),
        }
    }

    pub(super) fn frame(&mut self, record: &Record, cycle_us: u32) {
        let Id::Standard(id) = record.frame.id() else {
            return;
        };
        if record.node != self.master || record.outcome != Outcome::Delivered {
            return;
        }
        let of_axis = self
            .axes
            .iter_mut()
            .find(|(other, _)| *other == id.as_raw());
        let Some((_, latest_ns)) = of_axis else {
            return;
        };
        if let Some(before_ns) = latest_ns.replace(record.end_ns) {
            let interval_us = (record.end_ns - before_ns) as f64 * 1e-3;
            self.deviations_us
                .push((interval_us - f64::from(cycle_us)) as f32);
        }
    }

    /// Interval less cycle of every set-point but the first of each axis, in microseconds.
    pub(crate) fn deviations_us(&self) -> &[f32] {
        &self.deviations_us
    }

    /// The share of intervals, 0 ..= 1, within this many microseconds of the cycle; 1 without any.
    pub(crate) fn share_within(&self, us: f32) -> f64 {
        let all = self.deviations_us.len();
        let inside = self
            .deviations_us
            .iter()
            .filter(|deviation| deviation.abs() <= us);
        if all == 0 {
            1.0
        } else {
            inside.count() as f64 / all as f64
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use drive_sim::{Bench, BitRate, ControllerConfig, DynDriveConfig, Frame, LogMode, TxOrder};
    use embedded_can::{StandardId, nb::Can};

    #[test]
    fn the_interval_of_each_axis_counts() {
        let configs = [1, 2].map(|id| DynDriveConfig::numbered(id).unwrap());
        let (mut bench, _) = Bench::with_drives(BitRate::Kbit1000, configs);
        let master = bench.add_master(ControllerConfig::bxcan(TxOrder::Fifo));
        bench.bus_mut().set_log(LogMode::Full);
        let drives: Vec<DriveId> = DriveId::all().take(2).collect();
        let mut intervals = Intervals::new(master, &drives);
        for (at_us, id) in [(0, 0x03C), (200, 0x05C), (1_000, 0x03C), (1_230, 0x05C)] {
            bench.advance_to(at_us * 1_000);
            let frame = Frame::new(StandardId::new(id).unwrap(), &[1]).unwrap();
            bench.port(master).transmit(&frame).unwrap();
        }
        bench.advance_to(2_000_000);
        for record in bench.bus_mut().log_mut().drain() {
            intervals.frame(&record, 1_000);
        }
        assert_eq!(intervals.deviations_us(), [0.0, 30.0]);
        assert_eq!(intervals.share_within(29.0), 0.5);
    }
}
