//! The bounded buffer of timed set-points.

use heapless::Deque;
use trajectory::curve::Piece;
use trajectory::{Position, Time};

use crate::config::{AxisLimits, Config, ramp};
use crate::rate::{ONE, Rate};
use crate::refusal::Refusal;
use crate::stretch::{Point, Slope, Stretch};

/// Free places that are offered while nobody knows yet how close the set-points are.
const FIRST_CREDIT: usize = 8;

/// A set-point of every axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Knot<const AXES: usize> {
    pub(crate) time: Time,
    pub(crate) positions: [Position; AXES],
    /// Every axis is at rest here: where motion starts, and where it ends.
    pub(crate) rests: bool,
    /// The highest rate from here to the next one.
    pub(crate) highest_rate: i64,
}

/// What a buffer does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// The axes stand, because there are not enough set-points to start.
    Waiting,
    /// The axes are on their way, or paused on it.
    Moving,
    /// The set-points ran out, the axes stand at the last one, and wait for more.
    Dry,
    /// The motion is complete: the axes stand where its end was announced.
    Complete,
    /// The set-points ran out, the axes stand at the last one, and that is the end.
    DriedUp,
    /// The axes were told to stop, and stand on the way.
    Stopped,
}

/// What came in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counters {
    /// Set-points that were taken.
    pub taken: u32,
    /// Set-points that were refused, by the number of the refusal; place 0 is not used.
    pub refused: [u32; Refusal::KINDS + 1],
    /// How often the set-points ran out.
    pub dry: u32,
}

impl Counters {
    /// Counts what became of a set-point.
    pub fn count(&mut self, taken: &Result<(), Refusal>) {
        match taken {
            Ok(()) => self.taken = self.taken.saturating_add(1),
            Err(refusal) => {
                if let Some(count) = self.refused.get_mut(refusal.number()) {
                    *count = count.saturating_add(1);
                }
            }
        }
    }

    /// Set-points that were refused.
    #[must_use]
    pub fn refused_in_all(&self) -> u32 {
        self.refused
            .iter()
            .fold(0, |sum, &one| sum.saturating_add(one))
    }
}

/// Set-points with times, in order, and the curve through them; see the crate.
///
/// `AXES` is the largest number of axes, `POINTS` the largest number of set-points that are kept, some of them behind the motion: 64 is a
/// useful minimum.
#[derive(Debug, Clone)]
pub struct SetPointBuffer<const AXES: usize, const POINTS: usize> {
    pub(crate) axes: usize,
    pub(crate) limits: [AxisLimits; AXES],
    pub(crate) config: Config,
    pub(crate) knots: Deque<Knot<AXES>, POINTS>,
    /// The knot behind which the motion is.
    pub(crate) place: usize,
    /// Where it is on the clock of the sender.
    pub(crate) time: Time,
    pub(crate) rate: Rate,
    /// From the knot at `place` to the next one.
    pub(crate) pieces: [Piece; AXES],
    pub(crate) stand: [Position; AXES],
    pub(crate) phase: Phase,
    pub(crate) override_rate: i64,
    pub(crate) is_paused: bool,
    pub(crate) is_stopping: bool,
    /// The end was announced.
    pub(crate) is_ended: bool,
    /// The set-points ran out and that is the end.
    pub(crate) is_late: bool,
    /// It slows down, because there may be nothing more.
    pub(crate) is_short: bool,
    /// The highest rate between the motion and the last set-points.
    pub(crate) highest_rate: i64,
    /// The highest rate to the last set-point, as long as that may be the end.
    pub(crate) last_rate: i64,
    pub(crate) counters: Counters,
}

impl<const AXES: usize, const POINTS: usize> SetPointBuffer<AXES, POINTS> {
    /// A buffer for axes with these limits that stand at these positions; `None` for no axis, for more than `AXES`, and for another
    /// number of positions than of limits.
    #[must_use]
    pub fn new(limits: &[AxisLimits], stand: &[Position], config: Config) -> Option<Self> {
        let axes = limits.len();
        let first = limits.first()?;
        if axes > AXES || stand.len() != axes {
            return None;
        }
        let mut all = [*first; AXES];
        let mut at = [Position::ZERO; AXES];
        all.iter_mut()
            .zip(limits)
            .for_each(|(all, one)| *all = *one);
        at.iter_mut().zip(stand).for_each(|(all, one)| *all = *one);
        let (most, change) = ramp(limits);
        Some(Self {
            axes,
            limits: all,
            config,
            knots: Deque::new(),
            place: 0,
            time: Time::ZERO,
            rate: Rate::standing(most, change),
            pieces: at.map(|stand| Piece::line(stand, stand)),
            stand: at,
            phase: Phase::Waiting,
            override_rate: ONE,
            is_paused: false,
            is_stopping: false,
            is_ended: false,
            is_late: false,
            is_short: false,
            highest_rate: ONE,
            last_rate: ONE,
            counters: Counters::default(),
        })
    }

    /// Number of axes.
    #[must_use]
    pub const fn axes(&self) -> usize {
        self.axes
    }

    /// What it does.
    #[must_use]
    pub const fn phase(&self) -> Phase {
        self.phase
    }

    /// What came in.
    #[must_use]
    pub const fn counters(&self) -> &Counters {
        &self.counters
    }

    /// Where the motion is on the clock of the sender.
    #[must_use]
    pub const fn time(&self) -> Time {
        self.time
    }

    /// The time of the last set-point that was taken.
    #[must_use]
    pub fn last_time(&self) -> Option<Time> {
        self.knots.back().map(|knot| knot.time)
    }

    /// Time that is buffered ahead of the motion.
    #[must_use]
    pub fn buffered(&self) -> Time {
        self.last_time().unwrap_or(self.time).since(self.time)
    }

    /// Whether set-points are taken: no end was announced or ordered, and they have not run out for good.
    #[must_use]
    pub const fn is_open(&self) -> bool {
        !(self.is_ended || self.is_late || self.is_stopping)
    }

    /// So many set-points more fit.
    #[must_use]
    pub fn free(&self) -> usize {
        POINTS.saturating_sub(self.knots.len())
    }

    /// So many set-points the sender may send now: what fits, and what keeps [`Config::ahead`] buffered.
    #[must_use]
    pub fn credit(&self) -> usize {
        if !self.is_open() {
            return 0;
        }
        let (Some(first), Some(last)) = (self.knots.front(), self.knots.back()) else {
            return self.free().min(FIRST_CREDIT);
        };
        let behind = self.knots.len().saturating_sub(1);
        let ahead = behind.saturating_sub(self.place);
        if behind < FIRST_CREDIT {
            return self.free().min(FIRST_CREDIT.saturating_sub(ahead));
        }
        let spacing = last.time.since(first.time).cycles() / behind as f32;
        let room = self.config.ahead.since(self.buffered()).cycles() / spacing;
        // Two more are always needed to go on, however far apart they are.
        let least = 3_usize.saturating_sub(ahead);
        self.free().min((room as usize).max(least))
    }

    pub(crate) fn knot(&self, place: usize) -> Option<&Knot<AXES>> {
        self.knots.get(place)
    }

    pub(crate) fn last_place(&self) -> usize {
        self.knots.len().saturating_sub(1)
    }

    pub(crate) fn point(&self, place: usize, axis: usize) -> Option<Point> {
        let knot = self.knot(place)?;
        Some(Point {
            time: knot.time,
            position: *knot.positions.get(axis)?,
        })
    }

    /// Velocity and acceleration of an axis at a knot; at the last one, at rest.
    pub(crate) fn slope(&self, place: usize, axis: usize) -> Slope {
        let rests = self.knot(place).is_none_or(|knot| knot.rests);
        let before = place
            .checked_sub(1)
            .and_then(|place| self.point(place, axis));
        let (Some(before), Some(here), Some(after), false) = (
            before,
            self.point(place, axis),
            self.point(place.saturating_add(1), axis),
            rests,
        ) else {
            return Slope::default();
        };
        Slope::between(before, here, after)
    }

    /// The curve of an axis from a knot to the next one.
    pub(crate) fn stretch(&self, place: usize, axis: usize) -> Option<Stretch> {
        let next = place.saturating_add(1);
        Some(Stretch {
            from: self.point(place, axis)?,
            to: self.point(next, axis)?,
            leaving: self.slope(place, axis),
            arriving: self.slope(next, axis),
        })
    }
}
