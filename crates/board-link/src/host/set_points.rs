//! Segments of set-points that come one by one: the curve of [`SetPointBuffer`](crate::SetPointBuffer), for a board to play.

use heapless::Deque;
use trajectory::{Position, Time};

use crate::admission::{check_chord, check_gap, check_start, inside};
use crate::reason::Reason;
use crate::refusal::Refusal;
use crate::refused::Refused;
use crate::segment::{AxisSegment, OfAxes, Segment, SegmentPreview, Shape};
use crate::stretch::{Point, Slope, Stretch};

/// The last way may take so many quarters of its time, so that it ends at rest within the limits.
const QUARTERS_OF_LAST: [u64; 6] = [4, 5, 6, 8, 10, 12];
/// Most segments of the memory of a board that are counted.
const MOST_KEPT: usize = 64;

/// What a maker of segments keeps to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SegmentMakerConfig {
    /// Longest time from one set-point to the next: at most that of the board's segments.
    pub longest_gap: Time,
    /// Segments that the board keeps; more than 64 are taken for 64.
    pub kept: usize,
    /// So many segments take at least this time. A board slows down where too little time fits its memory.
    pub least_kept: Time,
}

/// A set-point of every axis.
#[derive(Debug, Clone, Copy)]
struct Knot<const AXES: usize> {
    time: Time,
    positions: [Position; AXES],
}

/// Makes segments of set-points: curves of fifth degree, at rest at the first and at the last one. Velocity and acceleration in between are
/// those of the parabola through a set-point and its neighbours. A segment is complete when the set-point behind its end is there.
///
/// A set-point is refused where it, or the segment that it completes, would be: with [`Refusal`], and with the checks of the board.
#[derive(Debug, Clone)]
pub struct SegmentMaker<const AXES: usize> {
    config: SegmentMakerConfig,
    preview: SegmentPreview<AXES>,
    stand: [Position; AXES],
    from: Option<Knot<AXES>>,
    to: Option<Knot<AXES>>,
    /// At `from`.
    leaving: [Slope; AXES],
    /// The latest ones, as many as the board keeps.
    times: Deque<Time, MOST_KEPT>,
    is_ended: bool,
}

impl<const AXES: usize> SegmentMaker<AXES> {
    /// For axes that stand at these positions. `preview` has the limits, and nothing was pushed to it; `None` for another number of
    /// positions.
    #[must_use]
    pub fn new(
        preview: SegmentPreview<AXES>,
        stand: &[Position],
        config: SegmentMakerConfig,
    ) -> Option<Self> {
        if stand.len() != preview.axes() {
            return None;
        }
        let mut at = [Position::ZERO; AXES];
        at.iter_mut().zip(stand).for_each(|(at, one)| *at = *one);
        Some(Self {
            config,
            preview,
            stand: at,
            from: None,
            to: None,
            leaving: [Slope::default(); AXES],
            times: Deque::new(),
            is_ended: false,
        })
    }

    /// The latest set-point that was taken.
    #[must_use]
    pub fn latest(&self) -> Option<(Time, &[Position])> {
        let knot = self.to.as_ref().or(self.from.as_ref())?;
        let positions = knot.positions.get(..self.preview.axes());
        Some((knot.time, positions.unwrap_or_default()))
    }

    /// Mean time between the latest set-points, once there are two.
    #[must_use]
    pub fn spacing(&self) -> Option<Time> {
        let gaps = self.times.len().checked_sub(1).filter(|gaps| *gaps > 0)?;
        let span = self.times.back()?.since(*self.times.front()?);
        Some(Time::from_ticks(span.ticks() / gaps as u64))
    }

    /// Takes the next set-point; the segment that it completes ends at the one before it.
    ///
    /// # Errors
    /// [`Refusal`]; nothing of the set-point counts.
    pub fn push(&mut self, time: Time, positions: &[Position]) -> Result<Option<Segment>, Refusal> {
        let knot = self.check(time, positions)?;
        let (Some(from), Some(to)) = (self.from, self.to) else {
            let place = if self.from.is_none() {
                &mut self.from
            } else {
                &mut self.to
            };
            *place = Some(knot);
            self.note(time);
            return Ok(None);
        };
        let mut arriving = [Slope::default(); AXES];
        for (axis, slope) in arriving.iter_mut().enumerate().take(self.preview.axes()) {
            *slope = Slope::between(from.point(axis), to.point(axis), knot.point(axis));
        }
        let segment = self.segment(&from, &to, &arriving);
        let pushed = self.preview.push(&segment);
        pushed.map_err(|refused| self.as_refusal(&refused))?;
        (self.from, self.to, self.leaving) = (Some(to), Some(knot), arriving);
        self.note(time);
        Ok(Some(segment))
    }

    /// No set-point follows: the last segment, which ends at rest at the last set-point; none where there is no way. Where its time is too
    /// short for that it takes up to three times as long.
    ///
    /// # Errors
    /// [`Refusal`] where that does not suffice: the way ends in motion.
    pub fn finish(&mut self) -> Result<Option<Segment>, Refusal> {
        self.is_ended = true;
        let (Some(from), Some(to)) = (self.from, self.to.take()) else {
            return Ok(None);
        };
        // It stays the latest.
        self.from = Some(to);
        let mut first = None;
        for quarters in QUARTERS_OF_LAST {
            let ticks = to.time.since(from.time).ticks() / 4 * quarters;
            let time = from.time.after(Time::from_ticks(ticks));
            if time.since(from.time) > self.config.longest_gap {
                break;
            }
            let end = Knot { time, ..to };
            let segment = self.segment(&from, &end, &[Slope::default(); AXES]);
            match self.preview.push(&segment) {
                Ok(()) => return Ok(Some(segment)),
                Err(refused) => first = first.or(Some(refused)),
            }
        }
        first.map_or(Ok(None), |refused| Err(self.as_refusal(&refused)))
    }

    fn check(&self, time: Time, positions: &[Position]) -> Result<Knot<AXES>, Refusal> {
        if self.is_ended {
            return Err(Refusal::Ended);
        }
        if positions.len() != self.preview.axes() {
            return Err(Refusal::Axes {
                expected: self.preview.axes(),
                actual: positions.len(),
            });
        }
        // The first one is where the axes stand, to the last bit.
        let mut knot = Knot {
            time,
            positions: self.stand,
        };
        let limits = self.preview.limits();
        for (axis, (&position, limits)) in positions.iter().zip(limits).enumerate() {
            inside(axis, position, limits)?;
        }
        let Some(last) = self.to.as_ref().or(self.from.as_ref()) else {
            for (axis, (&actual, &expected)) in positions.iter().zip(&self.stand).enumerate() {
                check_start(axis, expected, actual)?;
            }
            return Ok(knot);
        };
        check_gap(last.time, time, self.config.longest_gap)?;
        self.check_memory(time)?;
        knot.positions
            .iter_mut()
            .zip(positions)
            .for_each(|(all, one)| *all = *one);
        for (axis, limits) in limits.iter().enumerate() {
            check_chord(axis, last.point(axis), knot.point(axis), limits)?;
        }
        Ok(knot)
    }

    /// As many as the board keeps must take long enough.
    fn check_memory(&self, actual: Time) -> Result<(), Refusal> {
        match self.first_for_memory() {
            Some(expected) if actual < expected => Err(Refusal::Close { expected, actual }),
            _ => Ok(()),
        }
    }

    /// The first time that the next set-point may have for the sake of the memory of the board, once that is full. A sender whose
    /// set-points come before it sends too many of them, whatever it sends.
    #[must_use]
    pub fn first_for_memory(&self) -> Option<Time> {
        let is_full = self.times.len() >= self.kept();
        let first = self.times.front().filter(|_| is_full)?;
        Some(first.after(self.config.least_kept))
    }

    fn kept(&self) -> usize {
        self.config.kept.clamp(1, MOST_KEPT)
    }

    fn note(&mut self, time: Time) {
        while self.times.len() >= self.kept() {
            self.times.pop_front();
        }
        // There is room now.
        let _ = self.times.push_back(time);
    }

    fn segment(&self, from: &Knot<AXES>, to: &Knot<AXES>, arriving: &[Slope; AXES]) -> Segment {
        let slopes = self.leaving.iter().zip(arriving).take(self.preview.axes());
        let axes: OfAxes<AxisSegment> = slopes
            .enumerate()
            .map(|(axis, (&leaving, &arriving))| {
                let stretch = Stretch {
                    from: from.point(axis),
                    to: to.point(axis),
                    leaving,
                    arriving,
                };
                let [leaving, arriving] = stretch.borders();
                AxisSegment {
                    end: stretch.to.position.units(),
                    shape: Shape::Quintic {
                        leaving: leaving.velocity.units(),
                        leaving_acceleration: leaving.acceleration.units(),
                        arriving: arriving.velocity.units(),
                        arriving_acceleration: arriving.acceleration.units(),
                    },
                }
            })
            .collect();
        Segment {
            duration: to.time.since(from.time).ticks(),
            axes,
        }
    }

    /// What the board would say, in the words of set-points. A step of velocity or acceleration is none that set-points can have: it would
    /// be more acceleration or jerk than there may be.
    fn as_refusal(&self, refused: &Refused) -> Refusal {
        let axis = refused.axis.map_or(0, usize::from);
        let Some(limits) = self.preview.limits().get(axis) else {
            return Refusal::Ended;
        };
        let value = |units: i64| units as f32 / Position::UNITS as f32;
        let actual = value(refused.actual);
        let step = (actual - value(refused.expected)).abs();
        match refused.reason() {
            Some(Reason::Travel) => Refusal::Travel {
                axis,
                lowest: limits.lowest,
                highest: limits.highest,
                actual: Position::from_units(refused.actual),
            },
            Some(Reason::Velocity) => Refusal::Velocity {
                axis,
                expected: limits.velocity(),
                actual,
            },
            Some(Reason::Jerk) => Refusal::Jerk {
                axis,
                expected: limits.jerk(),
                actual,
            },
            Some(Reason::AccelerationStep) => Refusal::Jerk {
                axis,
                expected: limits.jerk(),
                actual: limits.jerk() + step,
            },
            Some(Reason::VelocityStep) => Refusal::Acceleration {
                axis,
                expected: limits.acceleration(),
                actual: limits.acceleration() + step,
            },
            _ => Refusal::Acceleration {
                axis,
                expected: limits.acceleration(),
                actual,
            },
        }
    }
}

impl<const AXES: usize> Knot<AXES> {
    fn point(&self, axis: usize) -> Point {
        Point {
            time: self.time,
            position: self.positions.get(axis).copied().unwrap_or_default(),
        }
    }
}
