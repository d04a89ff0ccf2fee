//! Where the set-points of a motion come from, cycle by cycle, and the orders that slow it down, pause it and end it.
//!
//! Whoever drives axes, real or simulated, asks a [`SetPointSource`] for one row a cycle and hands orders on to it; it knows
//! neither files nor streams. A motion that is known as a function of time implements [`MotionInTime`] and becomes a source in
//! [`TimedMotion`], which does override, pause and stop on the path. A source whose motion is not known in advance implements
//! [`SetPointSource`] itself.

mod headroom;
#[cfg(test)]
mod tests;
mod timed;

pub(crate) use headroom::{AxisHeadroom, held, most_percent};
pub(crate) use timed::TimedMotion;

use crate::recording::AxisNaming;

/// What a source did in a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Step {
    /// It is on its way, or will be: paused, or waiting for set-points.
    Goes,
    /// The motion is complete, and every axis is at rest where it ends.
    Completed,
    /// An order ended it, and every axis is at rest on the path.
    Stopped,
    /// There were no more set-points, without an end, and every axis is at rest at the last one.
    RanOut,
}

/// What a person or a program asks of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Order {
    /// Slow down to a standstill on the path, and wait.
    Pause,
    /// Go on.
    Resume,
    /// Percent of the speed of the motion, 0 to 200.
    Override(u16),
    /// Slow down to a standstill on the path, and end.
    Stop,
}

/// How fast a motion goes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Speed {
    /// Percent that was asked for.
    pub(crate) asked_percent: u16,
    /// Percent at this moment.
    pub(crate) actual_percent: f32,
    pub(crate) is_paused: bool,
}

/// Set-points, cycle by cycle.
pub(crate) trait SetPointSource {
    /// Number of axes.
    fn axes(&self) -> usize;

    /// One cycle later: writes the position of every axis, in command counts from where it stood at the start. The row of any
    /// other step than [`Step::Goes`] is the last one, and stays the same from then on.
    fn next(&mut self, row: &mut [i32]) -> Step;

    /// Obeys an order from the next cycle on.
    fn order(&mut self, order: Order);

    /// How fast the motion goes.
    fn speed(&self) -> Speed;

    /// Cycles of the motion that have passed, and how many it has where that is known.
    fn progress(&self) -> (u64, Option<u64>);

    /// What the user has to be told, oldest first: an override that is held to the limit, a stream that ran dry.
    fn next_notice(&mut self) -> Option<String>;

    /// What a stream calls its axes, once it has said so; all others are named before they begin.
    fn take_naming(&mut self) -> Option<Vec<AxisNaming>> {
        None
    }
}

/// A motion that is known from its start to its end.
pub(crate) trait MotionInTime {
    /// Number of axes.
    fn axes(&self) -> usize;

    /// Cycles from its start to its end, at 100 %.
    fn duration_cycles(&self) -> f64;

    /// Writes the exact position of every axis, in command counts from the start, at a time in cycles; before the start and behind the
    /// end those of the start and of the end.
    fn at(&self, cycles: f64, counts: &mut [f64]);
}

impl<M: MotionInTime + ?Sized> MotionInTime for &M {
    fn axes(&self) -> usize {
        (**self).axes()
    }

    fn duration_cycles(&self) -> f64 {
        (**self).duration_cycles()
    }

    fn at(&self, cycles: f64, counts: &mut [f64]) {
        (**self).at(cycles, counts);
    }
}
