//! How much an axis has left of its limits for a change of the speed of the whole motion.
//!
//! At rate `r` of its time a motion of velocity `v` and acceleration `a` has velocity `r v` and acceleration `r² a + r' v`. What
//! the limit leaves of the first term is there for `r'`, the change of the rate.

use trajectory::TimeScale;

use super::MotionInTime;

/// Points of the motion around a moment, half a window apart.
const POINTS: usize = 9;
/// Share of the limit that is used: between the points the motion may need a little more than at them.
const USED: f64 = 0.97;

/// Limits of an axis, and what the motion needs of them at 100 %. All in command counts and cycles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AxisHeadroom {
    /// Largest velocity, and largest mean acceleration over the window.
    pub(crate) velocity: f64,
    pub(crate) acceleration: f64,
    /// The largest of the motion.
    pub(crate) needed_velocity: f64,
    pub(crate) needed_acceleration: f64,
}

impl AxisHeadroom {
    /// The highest rate at which this axis stays within its limits, 1 at least: what is too fast at 100 % is refused elsewhere.
    fn highest_rate(&self) -> f64 {
        let by_velocity = self.velocity / self.needed_velocity;
        let by_acceleration = (self.acceleration / self.needed_acceleration).sqrt();
        // A motion that needs nothing has no limit: the quotient is infinite or no number.
        by_velocity.min(by_acceleration).max(1.0)
    }
}

/// The highest percentage at which every axis stays within its limits: 100 at least, and no more than an override may be.
pub(crate) fn most_percent(axes: impl IntoIterator<Item = AxisHeadroom>) -> u16 {
    let rates = axes.into_iter().map(|axis| axis.highest_rate());
    let highest = rates.fold(f64::INFINITY, f64::min);
    (highest * 100.0).min(f64::from(TimeScale::MOST_PERCENT)) as u16
}

/// What is said of an override beyond it.
pub(crate) fn held(percent: u16, most_percent: u16) -> String {
    format!("speed {percent} % would exceed the limits of an axis: held to {most_percent} %")
}

/// The largest change of the rate in the next cycle with which every axis keeps its acceleration, around a time of the motion.
pub(super) fn largest_change<M: MotionInTime>(
    motion: &M,
    axes: &[AxisHeadroom],
    window_cycles: f64,
    time_cycles: f64,
    rate: f64,
) -> f64 {
    let half = window_cycles / 2.0;
    let mut points = vec![vec![0.0; axes.len()]; POINTS];
    for (place, counts) in points.iter_mut().enumerate() {
        motion.at(
            time_cycles + (place as f64 - (POINTS / 2) as f64) * half,
            counts,
        );
    }
    // A corner of the path is a change of velocity that shrinks with the rate, a curve one that shrinks with its square.
    let share_of_motion = rate.max(rate * rate);
    let change_of = |axis: usize| {
        let at = |place: usize| points[place][axis];
        let velocity = (1..POINTS).map(|place| (at(place) - at(place - 1)).abs() / half);
        let acceleration = (4..POINTS).map(|place| {
            (at(place) - 2.0 * at(place - 2) + at(place - 4)).abs()
                / (window_cycles * window_cycles)
        });
        let left =
            USED * axes[axis].acceleration - share_of_motion * acceleration.fold(0.0, f64::max);
        left / velocity.fold(f64::MIN_POSITIVE, f64::max)
    };
    (0..axes.len())
        .map(change_of)
        .fold(f64::INFINITY, f64::min)
        .max(0.0)
}
