//! What is measured while a simulation runs.

use can_motion::{
    AxisSnapshot, AxisState, Event, EventKind, Fault, Instant, PollKind, ServoMaster,
};
use drive_sim::{Bus, DynDrive, FaultModel, LoadMark, NodeId, Outcome, Record};
use dyn_can::FunctionCode;
use embedded_can::{Frame as _, Id};

use super::axis_summary::AxisSummary;
use super::setup::MOST_AXES;
use crate::station::fault_text;

#[derive(Debug, Clone, Copy, Default)]
struct AxisWatch {
    largest_backlog_counts: u32,
    status: WorstAge,
    position: WorstAge,
}

/// Measurements of the motion, from `start` to `stop`.
#[derive(Debug)]
pub(crate) struct Watch {
    master: NodeId,
    axes: Vec<AxisWatch>,
    running: bool,
    whole: Option<LoadMark>,
    this_cycle: Option<LoadMark>,
    /// Axes that owe a set-point in this cycle.
    owed: usize,
    /// Set-points that have ended on the wire in this cycle.
    ended: usize,
    faults: u32,
    pub(crate) cycles: u32,
    /// Cycles in which a set-point had not ended on the wire when the next cycle began.
    pub(crate) late_cycles: u32,
    pub(crate) mean_load: f64,
    pub(crate) peak_load: f64,
}

impl Watch {
    pub(crate) fn new(master: NodeId, axes: usize) -> Self {
        Self {
            master,
            axes: vec![AxisWatch::default(); axes],
            running: false,
            whole: None,
            this_cycle: None,
            owed: 0,
            ended: 0,
            faults: 0,
            cycles: 0,
            late_cycles: 0,
            mean_load: 0.0,
            peak_load: 0.0,
        }
    }

    pub(crate) fn start(&mut self, mark: LoadMark) {
        self.running = true;
        self.whole = Some(mark);
        self.this_cycle = Some(mark);
    }

    pub(crate) fn stop<F: FaultModel>(&mut self, bus: &Bus<F>) {
        self.running = false;
        if let Some(mark) = &self.whole {
            self.mean_load = bus.load_since(mark);
        }
    }

    pub(crate) fn saw_fault(&self) -> bool {
        self.faults > 0
    }

    pub(crate) fn faults(&self) -> u32 {
        self.faults
    }

    pub(crate) fn event(&mut self, event: &Event<EventKind>) {
        if let EventKind::Fault(_) = event.kind {
            self.faults += 1;
        }
    }

    pub(crate) fn cycle_begins(&mut self, master: &ServoMaster<MOST_AXES>, places: &[usize]) {
        if !self.running {
            return;
        }
        (self.owed, self.ended) = (0, 0);
        for &place in places {
            let axis = master.snapshot(place);
            self.owed += usize::from(axis.is_some_and(|axis| axis.state.sends_set_points()));
        }
    }

    /// Notes what the recording samples too, at the same moment: the table must agree with the plots.
    pub(crate) fn note(&mut self, now: Instant, master: &ServoMaster<MOST_AXES>, places: &[usize]) {
        if !self.running {
            return;
        }
        for (watch, &place) in self.axes.iter_mut().zip(places) {
            let Some(axis) = master.snapshot(place) else {
                continue;
            };
            watch.largest_backlog_counts = watch
                .largest_backlog_counts
                .max(axis.backlog_counts.unsigned_abs());
            watch
                .status
                .note(axis.feedback.polled_at(PollKind::Status), now);
            watch
                .position
                .note(axis.feedback.polled_at(PollKind::Position), now);
        }
    }

    pub(crate) fn record(&mut self, record: &Record) {
        let Id::Standard(id) = record.frame.id() else {
            return;
        };
        let is_set_point = FunctionCode::from_can_id(id.as_raw()) == FunctionCode::GoRelativePosPd;
        if is_set_point && record.node == self.master && record.outcome == Outcome::Delivered {
            self.ended += 1;
        }
    }

    /// Returns whether a set-point had not ended on the wire.
    pub(crate) fn cycle_ends<F: FaultModel>(&mut self, bus: &Bus<F>) -> bool {
        if !self.running {
            return false;
        }
        let is_late = self.ended < self.owed;
        self.cycles += 1;
        self.late_cycles += u32::from(is_late);
        if let Some(mark) = &self.this_cycle {
            self.peak_load = self.peak_load.max(bus.load_since(mark));
        }
        self.this_cycle = Some(bus.load_mark());
        is_late
    }

    pub(crate) fn axis_summary(
        &self,
        axis: usize,
        snapshot: &AxisSnapshot,
        drive: &DynDrive,
        now_ns: u64,
        anchor_counts: i32,
        target_counts: i32,
    ) -> AxisSummary {
        let watch = &self.axes[axis];
        let fault = snapshot.fault.map(|fault| named(fault, snapshot));
        AxisSummary {
            axis,
            drive: snapshot.drive.get(),
            state: snapshot.state.to_string(),
            fault: fault.map(|fault| fault.to_string()),
            advice: fault
                .filter(|fault| *fault != Fault::Group)
                .map(|fault| fault_text(snapshot.drive, fault)),
            set_points: snapshot.counters.set_points,
            target_counts: target_counts.wrapping_sub(anchor_counts),
            sent_counts: snapshot.sent_counts.wrapping_sub(anchor_counts),
            received_counts: drive.commanded_counts(),
            position_error_counts: i64::from(snapshot.target_counts)
                - drive.position_counts(now_ns),
            largest_backlog_counts: watch.largest_backlog_counts,
            worst_status_age_ms: watch.status.ms(),
            worst_position_age_ms: watch.position.ms(),
            reply_timeouts: snapshot.counters.timeouts,
            streamed: matches!(snapshot.state, AxisState::Streaming | AxisState::Holding),
        }
    }
}

/// The oldest that a value became during the motion.
#[derive(Debug, Clone, Copy, Default)]
struct WorstAge {
    /// `None` while the value was never read.
    us: Option<u64>,
}

impl WorstAge {
    fn note(&mut self, read_at: Option<Instant>, now: Instant) {
        if let Some(at) = read_at {
            let age_us = now.us_since(at);
            self.us = Some(self.us.map_or(age_us, |worst_us| worst_us.max(age_us)));
        }
    }

    fn ms(self) -> Option<f64> {
        self.us.map(|us| us as f64 / 1_000.0)
    }
}

/// An alarm by its name, once the status has told it.
fn named(fault: Fault, axis: &AxisSnapshot) -> Fault {
    let alarm = axis.feedback.status.map(|status| status.value.alarm());
    match (fault, alarm) {
        (Fault::AlarmFrame, Some(alarm)) if alarm.is_alarm() => Fault::AlarmStatus(alarm),
        (fault, _) => fault,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_that_was_never_read_has_no_age() {
        let at = Instant::from_us;
        let mut age = WorstAge::default();
        age.note(None, at(5_000));
        assert_eq!(age.ms(), None);
        age.note(Some(at(6_000)), at(8_500));
        age.note(Some(at(9_000)), at(9_500));
        assert_eq!(age.ms(), Some(2.5));
    }
}
