//! A run from power-on to rest.

use can_motion::AxisState;
use indicatif::{ProgressBar, ProgressStyle};

use super::{Bench, GROUP};
use crate::recording::{Kind, Recorded};
use crate::set_points::{AxisHeadroom, SetPointSource, Step, TimedMotion};
use crate::sim::error::SimError;
use crate::sim::summary::Summary;
use crate::trajectory::Plan;

/// Time for the drives to become ready, and to be enabled, before the simulation gives up.
const START_UP_LIMIT_US: u64 = 10_000_000;
/// Time after the motion for the drives to arrive and to be read once more.
const SETTLE_US: u64 = 300_000;
/// Cycles between two updates of the progress bar.
const PROGRESS_STEP: u64 = 100;

/// The buses of a motion, in virtual time: they start when all are ready, take their rows from one motion, and what stops one stops all.
pub(crate) struct Run<'a> {
    /// In the order of the columns.
    benches: Vec<Bench<'a>>,
}

impl<'a> Run<'a> {
    /// Each bench has its axes behind those of the ones before it.
    pub(crate) fn new(benches: Vec<Bench<'a>>) -> Self {
        Self { benches }
    }

    /// Runs a motion from power-on to rest.
    pub(crate) fn run(
        mut self,
        plan: &Plan,
        show_progress: bool,
    ) -> Result<Vec<(Summary, Recorded)>, SimError> {
        let ready = self
            .wait_until(|state| matches!(state, AxisState::Ready | AxisState::FoundOn))?
            && self.enable()?
            && self.wait_until(|state| state == AxisState::Streaming)?;
        let anchors: Vec<Vec<i32>> = self.benches.iter().map(Bench::targets).collect();
        if ready {
            for bench in &mut self.benches {
                bench.begin_motion();
                bench.watch.start(bench.bench.bus().load_mark());
            }
            self.follow(plan, &anchors, show_progress)?;
            self.settle()?;
        }
        let last = plan.last();
        let mut from = 0;
        let close = |(bench, anchors): (Bench<'_>, Vec<i32>)| {
            let own = from..from + anchors.len();
            from = own.end;
            bench.close(last.get(own).unwrap_or_default(), &anchors)
        };
        self.benches.into_iter().zip(anchors).map(close).collect()
    }

    /// Simulated drives come up with their servo on: those are taken over, the others are enabled.
    fn enable(&mut self) -> Result<bool, SimError> {
        for bench in &mut self.benches {
            // Refused when no drive was found on.
            let _ = bench.master.adopt(bench.now(), GROUP);
        }
        let ready = |state| matches!(state, AxisState::Ready | AxisState::Holding);
        if !self.wait_until(ready)? {
            return Ok(false);
        }
        let mut benches = self.benches.iter_mut();
        Ok(benches.all(|bench| bench.master.enable(bench.now(), GROUP).is_ok()))
    }

    fn wait_until(&mut self, is_so: impl Fn(AxisState) -> bool) -> Result<bool, SimError> {
        let now_us = |run: &Self| run.benches.iter().map(|bench| bench.now().as_us()).max();
        let deadline_us = now_us(self).unwrap_or(0) + START_UP_LIMIT_US;
        while now_us(self).unwrap_or(deadline_us) < deadline_us && !self.has_ended() {
            for bench in &mut self.benches {
                bench.one_cycle()?;
            }
            if self.benches.iter().all(|bench| bench.all_are(&is_so)) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// A fault, or somebody who has asked for the end.
    fn has_ended(&self) -> bool {
        let mut benches = self.benches.iter();
        benches.any(|bench| bench.watch.saw_fault() || bench.stopped)
    }

    fn follow(
        &mut self,
        plan: &Plan,
        anchors: &[Vec<i32>],
        show_progress: bool,
    ) -> Result<(), SimError> {
        let bar = progress_bar(plan.cycles(), show_progress);
        let cycle_us = self.benches.first().map_or(1, |bench| bench.setup.cycle_us);
        let mut source = TimedMotion::new(plan, self.headroom(plan), cycle_us);
        let mut row = vec![0; anchors.iter().map(Vec::len).sum()];
        let (mut cycle, mut step) = (0, Step::Goes);
        loop {
            let mut rest = &row[..];
            for (bench, anchors) in self.benches.iter_mut().zip(anchors) {
                let (own, others) = rest.split_at(anchors.len());
                rest = others;
                bench.aim(anchors, own);
                for wish in bench.one_cycle()? {
                    let order = wish.as_order(&source);
                    source.order(order);
                }
            }
            self.happens(&mut source);
            if cycle % PROGRESS_STEP == 0 {
                bar.set_position(cycle);
            }
            cycle += 1;
            if step == Step::Stopped {
                self.benches
                    .iter_mut()
                    .for_each(|bench| bench.stopped = true);
            }
            if self.has_ended() || step != Step::Goes {
                break;
            }
            step = source.next(&mut row);
        }
        bar.finish_and_clear();
        Ok(())
    }

    /// What the motion has to say of itself goes into every record.
    fn happens(&mut self, source: &mut dyn SetPointSource) {
        while let Some(notice) = source.next_notice() {
            for bench in &mut self.benches {
                bench.phase(&notice);
            }
        }
        for bench in &mut self.benches {
            bench.spectator.speed(source.speed());
        }
    }

    /// No axis does larger steps than it may; accelerations have no limit here.
    fn headroom(&self, plan: &Plan) -> Vec<AxisHeadroom> {
        let most = self.benches.iter().map(|bench| bench.setup.max_step.get());
        let most = most.min().unwrap_or_default();
        let steps = plan.largest_steps().into_iter();
        steps
            .map(|step| AxisHeadroom {
                velocity: f64::from(most),
                acceleration: f64::INFINITY,
                needed_velocity: f64::from(step),
                needed_acceleration: 0.0,
            })
            .collect()
    }

    /// What stopped one bus stops the others; then every axis comes to rest.
    fn settle(&mut self) -> Result<(), SimError> {
        let saw_fault = self.benches.iter().any(|bench| bench.watch.saw_fault());
        for bench in &mut self.benches {
            if bench.stopped {
                bench.phase("stopped by the user");
            } else if saw_fault && !bench.watch.saw_fault() {
                bench.stop_with_the_other();
            } else {
                bench.phase("the motion ends");
            }
        }
        let cycle_us = self.benches.first().map_or(1, |bench| bench.setup.cycle_us);
        for _ in 0..SETTLE_US.div_ceil(u64::from(cycle_us)) {
            for bench in &mut self.benches {
                bench.one_cycle()?;
            }
        }
        for bench in &mut self.benches {
            bench.watch.stop(bench.bench.bus());
        }
        Ok(())
    }
}

impl Bench<'_> {
    fn begin_motion(&mut self) {
        self.motion_start_ns = Some(self.bench.now_ns());
        let now_us = self.now().as_us();
        self.recorder.motion_begins(now_us, self.cycle);
    }

    fn phase(&mut self, text: &str) {
        let at_us = self.now().as_us();
        self.recorder.happened(at_us, None, Kind::Phase, text);
    }

    fn targets(&self) -> Vec<i32> {
        let target = |&place| {
            self.master
                .snapshot(place)
                .map_or(0, |axis| axis.target_counts)
        };
        self.places.iter().map(target).collect()
    }

    fn all_are(&self, is_so: impl Fn(AxisState) -> bool) -> bool {
        let axes = self.places.iter().map(|&place| self.master.snapshot(place));
        axes.into_iter()
            .all(|axis| axis.is_some_and(|axis| is_so(axis.state)))
    }

    /// Sets the targets, so many counts from where the axes stood.
    fn aim(&mut self, anchors: &[i32], row: &[i32]) {
        let axes = self.places.iter().zip(anchors).zip(row);
        for ((&place, &anchor), &offset) in axes {
            // A refusal is an axis that stopped by a fault, which the watch has seen.
            let _ = self.master.set_target(place, anchor.wrapping_add(offset));
        }
    }

    /// Ends the motion of this bus, because that of another one has ended.
    fn stop_with_the_other(&mut self) {
        let now = self.now();
        self.master.stop(now, GROUP);
        self.phase("stopped with the other bus");
    }

    /// Shows the result, and closes every file.
    fn close(self, last: &[i32], anchors: &[i32]) -> Result<(Summary, Recorded), SimError> {
        let summary = self.summary(last, anchors);
        if let Some(recording) = self.recorder.model() {
            let is_good = summary.promises_kept();
            self.spectator.end(recording, summary.verdict(), is_good)?;
        }
        Ok((summary, self.recorder.finish()))
    }

    /// `last` is where the motion ends, axis by axis.
    fn summary(&self, last: &[i32], anchors: &[i32]) -> Summary {
        let axes = self.places.iter().enumerate().filter_map(|(axis, &place)| {
            let snapshot = self.master.snapshot(place)?;
            let drive = self.bench.device(self.devices[axis]);
            let planned = anchors[axis].wrapping_add(last.get(axis).copied().unwrap_or(0));
            // Where the ramp of a stop ends is as good as any target.
            let target = if self.stopped {
                snapshot.target_counts
            } else {
                planned
            };
            let now_ns = self.bench.now_ns();
            let (watch, anchor) = (&self.watch, anchors[axis]);
            Some(watch.axis_summary(axis, &snapshot, drive, now_ns, anchor, target))
        });
        Summary::new(
            axes.collect(),
            &self.master.cycle_counters(),
            &self.watch,
            &self.setup,
            self.stopped,
        )
    }
}

fn progress_bar(cycles: usize, show: bool) -> ProgressBar {
    if !show {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:40} {pos}/{len} cycles, {eta} left");
    let bar = ProgressBar::new(cycles as u64);
    match style {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
