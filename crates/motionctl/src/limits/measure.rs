//! What is measured of the frames on the wire.

use can_motion::plan::BusPlan;
use drive_sim::{Outcome, Record};
use dyn_can::FunctionCode;
use embedded_can::{Frame as _, Id};
use schemars::JsonSchema;
use serde::Serialize;

/// One bit at 1 Mbit/s.
pub(crate) const BIT_NS: u64 = 1_000;

/// Longest time that frames of one kind took, and the bound of the plan, in bit times.
#[derive(Debug, Clone, Copy, Default, Serialize, JsonSchema)]
pub(crate) struct Observed {
    pub(crate) observed_bits: u64,
    /// The largest bound of the kind.
    pub(crate) bound_bits: u64,
}

/// Observed against bound, by kind of frame.
#[derive(Debug, Clone, Copy, Default, Serialize, JsonSchema)]
pub(crate) struct Bounds {
    pub(crate) set_points: Observed,
    pub(crate) requests: Observed,
    pub(crate) replies: Observed,
}

/// Measurements of one run.
#[derive(Debug, Clone)]
pub(crate) struct Measurements {
    cycle_bits: u64,
    /// Bounds of each set-point, of requests and of replies.
    set_point_bounds: Vec<u64>,
    request_bound: u64,
    reply_bound: u64,
    /// Cycle of the latest request of each identifier.
    asked_in: Vec<u64>,
    /// Set-points that went out after the end of the cycle in which they were made.
    pub(crate) late_set_points: u64,
    pub(crate) own_collisions: u64,
    pub(crate) bound_violations: u64,
    pub(crate) bounds: Bounds,
    set_points_bits: u64,
    /// Earliest and latest end of each axis' set-point, from the start of its cycle.
    ends: Vec<Option<(u64, u64)>>,
    skew: Skew,
}

/// Time from the first to the last set-point of a cycle, against the shortest that is possible with these frames.
#[derive(Debug, Clone, Copy, Default)]
struct Skew {
    first_end_bits: u64,
    /// Frames behind the first one.
    frames_bits: u64,
    worst_ratio: f64,
}

impl Measurements {
    pub(crate) fn new(plan: &BusPlan<'_>, axes: usize) -> Self {
        let bits = |response: Option<can_motion::plan::analysis::Response>| {
            response
                .and_then(|response| response.bits)
                .map_or(0, u64::from)
        };
        Self {
            cycle_bits: plan.cycle().cycle_bits(),
            set_point_bounds: (0..axes).map(|axis| bits(plan.set_point(axis))).collect(),
            request_bound: bits(plan.cycle().requests()),
            reply_bound: bits(plan.cycle().replies()),
            asked_in: vec![0; 2_048],
            late_set_points: 0,
            own_collisions: 0,
            bound_violations: 0,
            bounds: Bounds::default(),
            set_points_bits: 0,
            ends: vec![None; axes],
            skew: Skew::default(),
        }
    }

    /// Forgets what was measured, but not which replies are still to come.
    pub(crate) fn restart(&mut self, plan: &BusPlan<'_>, axes: usize) {
        let asked_in = core::mem::take(&mut self.asked_in);
        *self = Self {
            asked_in,
            ..Self::new(plan, axes)
        };
    }

    /// A frame of the master went out, handed over in this cycle.
    pub(crate) fn sent(&mut self, record: &Record, cycle: u64) {
        let id = id(record);
        if FunctionCode::from_can_id(id) == FunctionCode::GoRelativePosPd {
            self.set_point(record, cycle, usize::from(id >> 5) - 1);
        } else {
            self.asked_in[usize::from(id)] = cycle;
            let took_bits = self.took_bits(record, cycle);
            let bound = self.request_bound;
            judge(
                &mut self.bounds.requests,
                took_bits,
                bound,
                &mut self.bound_violations,
            );
        }
    }

    /// A frame of a drive.
    pub(crate) fn replied(&mut self, record: &Record) {
        let asked_in = self.asked_in[usize::from(id(record))];
        let took_bits = self.took_bits(record, asked_in);
        let bound = self.reply_bound;
        judge(
            &mut self.bounds.replies,
            took_bits,
            bound,
            &mut self.bound_violations,
        );
    }

    /// An attempt that was no success.
    pub(crate) fn failed(&mut self, record: &Record) {
        self.own_collisions += u64::from(record.outcome == Outcome::Collision);
    }

    fn set_point(&mut self, record: &Record, cycle: u64, axis: usize) {
        let frame_bits = (record.free_ns - record.start_ns) / BIT_NS;
        let end_bits = record.end_ns / BIT_NS - cycle * self.cycle_bits;
        self.set_points_bits += frame_bits;
        self.late_set_points += u64::from(end_bits > self.cycle_bits);
        let took_bits = self.took_bits(record, cycle);
        let bound = self.set_point_bounds[axis];
        judge(
            &mut self.bounds.set_points,
            took_bits,
            bound,
            &mut self.bound_violations,
        );
        let (earliest, latest) = self.ends[axis].unwrap_or((end_bits, end_bits));
        self.ends[axis] = Some((earliest.min(end_bits), latest.max(end_bits)));
        if axis == 0 {
            (self.skew.first_end_bits, self.skew.frames_bits) = (end_bits, 0);
            return;
        }
        self.skew.frames_bits += frame_bits;
        if axis + 1 == self.ends.len() {
            let took_bits = end_bits.saturating_sub(self.skew.first_end_bits);
            let ratio = took_bits as f64 / self.skew.frames_bits as f64;
            self.skew.worst_ratio = self.skew.worst_ratio.max(ratio);
        }
    }

    /// From the start of a cycle to the end of the interframe space.
    fn took_bits(&self, record: &Record, cycle: u64) -> u64 {
        record.free_ns / BIT_NS - cycle * self.cycle_bits
    }

    /// Peak to peak of the end of a set-point in its cycle, of the worst axis.
    pub(crate) fn jitter_bits(&self) -> u64 {
        let spans = self.ends.iter().flatten();
        spans
            .map(|(earliest, latest)| latest - earliest)
            .max()
            .unwrap_or(0)
    }

    /// The worst cycle's time from first to last set-point over the shortest possible one.
    pub(crate) fn skew_ratio(&self) -> f64 {
        self.skew.worst_ratio
    }

    /// Share of the time in which set-points were on the wire.
    pub(crate) fn wire_share(&self, cycles: u64) -> f64 {
        self.set_points_bits as f64 / (cycles * self.cycle_bits) as f64
    }
}

fn judge(observed: &mut Observed, took_bits: u64, bound_bits: u64, violations: &mut u64) {
    observed.observed_bits = observed.observed_bits.max(took_bits);
    observed.bound_bits = observed.bound_bits.max(bound_bits);
    *violations += u64::from(took_bits > bound_bits);
}

fn id(record: &Record) -> u16 {
    match record.frame.id() {
        Id::Standard(id) => id.as_raw(),
        // Nobody on the bus sends extended frames.
        Id::Extended(_) => 0,
    }
}
