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

impl Bench<'_> {
    /// Runs a motion from power-on to rest.
    pub(crate) fn run(
        mut self,
        plan: &Plan,
        show_progress: bool,
    ) -> Result<(Summary, Recorded), SimError> {
        let ready = self
            .wait_until(|state| matches!(state, AxisState::Ready | AxisState::FoundOn))?
            && self.enable()?
            && self.wait_until(|state| state == AxisState::Streaming)?;
        let anchors = self.targets();
        if ready {
            self.begin_motion();
            self.watch.start(self.bench.bus().load_mark());
            self.follow(plan, &anchors, show_progress)?;
            self.phase(if self.stopped {
                "stopped by the user"
            } else {
                "the motion ends"
            });
            self.settle()?;
            self.watch.stop(self.bench.bus());
        }
        let summary = self.summary(plan, &anchors);
        if let Some(recording) = self.recorder.model() {
            let is_good = summary.promises_kept();
            self.spectator.end(recording, summary.verdict(), is_good)?;
        }
        Ok((summary, self.recorder.finish()))
    }

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

    /// Simulated drives come up with their servo on: those are taken over, the others are enabled.
    fn enable(&mut self) -> Result<bool, SimError> {
        // Refused when no drive was found on.
        let _ = self.master.adopt(self.now(), GROUP);
        let ready = |state| matches!(state, AxisState::Ready | AxisState::Holding);
        Ok(self.wait_until(ready)? && self.master.enable(self.now(), GROUP).is_ok())
    }

    fn wait_until(&mut self, is_so: impl Fn(AxisState) -> bool) -> Result<bool, SimError> {
        let deadline_us = self.now().as_us() + START_UP_LIMIT_US;
        while self.now().as_us() < deadline_us && !self.watch.saw_fault() && !self.stopped {
            self.one_cycle()?;
            let mut axes = self.places.iter();
            if axes.all(|&place| {
                self.master
                    .snapshot(place)
                    .is_some_and(|axis| is_so(axis.state))
            }) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    fn follow(
        &mut self,
        plan: &Plan,
        anchors: &[i32],
        show_progress: bool,
    ) -> Result<(), SimError> {
        let bar = progress_bar(plan.cycles(), show_progress);
        let mut source = TimedMotion::new(plan, self.headroom(plan), self.setup.cycle_us);
        let mut row = vec![0; anchors.len()];
        let (mut cycle, mut step) = (0, Step::Goes);
        loop {
            for (axis, (&place, &offset)) in self.places.iter().zip(&row).enumerate() {
                // A refusal is an axis that stopped by a fault, which the watch has seen.
                let _ = self
                    .master
                    .set_target(place, anchors[axis].wrapping_add(offset));
            }
            for wish in self.one_cycle()? {
                let order = wish.as_order(&source);
                source.order(order);
            }
            self.happens(&mut source);
            if cycle % PROGRESS_STEP == 0 {
                bar.set_position(cycle);
            }
            cycle += 1;
            self.stopped |= step == Step::Stopped;
            if self.watch.saw_fault() || self.stopped || step != Step::Goes {
                break;
            }
            step = source.next(&mut row);
        }
        bar.finish_and_clear();
        Ok(())
    }

    /// What the motion has to say of itself goes into the record.
    fn happens(&mut self, source: &mut dyn SetPointSource) {
        self.spectator.speed(source.speed());
        while let Some(notice) = source.next_notice() {
            self.phase(&notice);
        }
    }

    /// No axis does larger steps than it may; accelerations have no limit here.
    fn headroom(&self, plan: &Plan) -> Vec<AxisHeadroom> {
        let steps = plan.largest_steps().into_iter();
        steps
            .map(|step| AxisHeadroom {
                velocity: f64::from(self.setup.max_step.get()),
                acceleration: f64::INFINITY,
                needed_velocity: f64::from(step),
                needed_acceleration: 0.0,
            })
            .collect()
    }

    fn settle(&mut self) -> Result<(), SimError> {
        for _ in 0..SETTLE_US.div_ceil(u64::from(self.setup.cycle_us)) {
            self.one_cycle()?;
        }
        Ok(())
    }

    fn summary(&self, plan: &Plan, anchors: &[i32]) -> Summary {
        let last = plan.last();
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
