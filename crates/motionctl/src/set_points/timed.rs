//! A motion that is known as a function of time, played at another speed: override, pause and stop on the path.

use std::collections::VecDeque;

use trajectory::{Time, TimeScale};

use super::headroom::{AxisHeadroom, held, largest_change, most_percent};
use super::{MotionInTime, Order, SetPointSource, Speed, Step};

/// Shortest time from standstill to full speed and back, in microseconds.
const FULL_CHANGE_US: u32 = 100_000;
/// Acceleration is a mean over so long, as everywhere in this tool.
const WINDOW_US: u32 = 20_000;

/// Full speed within a cycle, where a cycle is that long.
const AT_ONCE: TimeScale = match TimeScale::running(1) {
    Ok(scale) => scale,
    Err(_) => panic!("it is a cycle"),
};

/// A known motion as a source of set-points.
#[derive(Debug)]
pub(crate) struct TimedMotion<M> {
    motion: M,
    axes: Vec<AxisHeadroom>,
    scale: TimeScale,
    window_cycles: f64,
    /// Highest percentage within the limits.
    most_percent: u16,
    asked_percent: u16,
    is_paused: bool,
    is_stopping: bool,
    notices: VecDeque<String>,
    exact: Vec<f64>,
}

impl<M: MotionInTime> TimedMotion<M> {
    /// A motion at 100 %, within the limits of its axes.
    pub(crate) fn new(motion: M, axes: Vec<AxisHeadroom>, cycle_us: u32) -> Self {
        let cycles = (FULL_CHANGE_US / cycle_us).max(1);
        Self {
            exact: vec![0.0; motion.axes()],
            motion,
            most_percent: most_percent(axes.iter().copied()),
            axes,
            scale: TimeScale::running(cycles).unwrap_or(AT_ONCE),
            window_cycles: f64::from(WINDOW_US / cycle_us).max(1.0),
            asked_percent: 100,
            is_paused: false,
            is_stopping: false,
            notices: VecDeque::new(),
        }
    }

    /// The highest rate that an override can reach.
    pub(crate) fn highest_rate(&self) -> f64 {
        f64::from(self.most_percent) / 100.0
    }

    /// No faster than this, whatever the axes could do.
    pub(crate) fn hold_to(&mut self, rate: f64) {
        self.most_percent = self.most_percent.min((rate * 100.0) as u16);
    }

    fn set_override(&mut self, percent: u16) {
        self.asked_percent = percent;
        if percent > self.most_percent {
            self.notices.push_back(held(percent, self.most_percent));
        }
        // It is at most the largest.
        let _ = self.scale.set_override(percent.min(self.most_percent));
    }
}

/// A time in cycles, exact for every motion that this tool plays.
fn cycles(time: Time) -> f64 {
    time.ticks() as f64 / (1_u64 << 32) as f64
}

impl<M: MotionInTime> SetPointSource for TimedMotion<M> {
    fn axes(&self) -> usize {
        self.motion.axes()
    }

    fn next(&mut self, row: &mut [i32]) -> Step {
        let rate = f64::from(self.scale.rate());
        let change = largest_change(
            &self.motion,
            &self.axes,
            self.window_cycles,
            cycles(self.scale.time()),
            rate,
        );
        let time = cycles(self.scale.advance_within(change as f32));
        self.motion.at(time, &mut self.exact);
        for (position, exact) in row.iter_mut().zip(&self.exact) {
            *position = (exact + 0.5).floor() as i32;
        }
        if time >= self.motion.duration_cycles() {
            Step::Completed
        } else if self.is_stopping && self.scale.is_standing() {
            Step::Stopped
        } else {
            Step::Goes
        }
    }

    fn order(&mut self, order: Order) {
        match order {
            Order::Override(percent) => self.set_override(percent),
            Order::Pause => {
                self.is_paused = true;
                self.scale.pause();
            }
            Order::Resume if self.is_stopping => {}
            Order::Resume => {
                self.is_paused = false;
                self.scale.resume();
            }
            Order::Stop => {
                self.is_stopping = true;
                self.scale.pause();
            }
        }
    }

    fn speed(&self) -> Speed {
        Speed {
            asked_percent: self.asked_percent,
            actual_percent: 100.0 * self.scale.rate(),
            is_paused: self.is_paused,
        }
    }

    fn progress(&self) -> (u64, Option<u64>) {
        let duration = self.motion.duration_cycles();
        let passed = cycles(self.scale.time()).min(duration);
        (passed as u64, Some(duration.ceil() as u64))
    }

    fn next_notice(&mut self) -> Option<String> {
        self.notices.pop_front()
    }
}
