//! What a set-point must keep before it moves anything.

use trajectory::{Position, Time};

use crate::buffer::{Knot, Phase, SetPointBuffer};
use crate::config::{AxisLimits, WhenDry};
use crate::rate::ONE;
use crate::refusal::Refusal;
use crate::stretch::{Point, Slope, Stretch, check_mean_acceleration};

/// The first set-point may be so far from where an axis stands: one count.
const START_TOLERANCE: i64 = Position::UNITS;
/// Set-points are at least half a cycle apart.
const LEAST_GAP: Time = Time::from_ticks(1 << 31);

/// The highest rates of the two stretches that a new set-point changes.
struct Rates {
    /// The one before it, which is now complete; `None` when it was already, or there is none.
    before: Option<i64>,
    /// The one to the set-point.
    last: i64,
    /// That of the mean acceleration.
    mean: Option<MeanRate>,
}

/// The highest rate at which the mean acceleration is kept, from a place on.
#[derive(Clone, Copy)]
struct MeanRate {
    from: usize,
    rate: f32,
}

impl MeanRate {
    /// That of both.
    fn with(self, other: Option<Self>) -> Self {
        other.map_or(self, |other| Self {
            from: self.from.min(other.from),
            rate: self.rate.min(other.rate),
        })
    }
}

impl<const AXES: usize, const POINTS: usize> SetPointBuffer<AXES, POINTS> {
    /// Takes a set-point: the time on the clock of the sender, and the position of every axis.
    ///
    /// # Errors
    /// [`Refusal`]; the set-point is counted, and nothing of it moves anything.
    pub fn push(&mut self, time: Time, positions: &[Position]) -> Result<(), Refusal> {
        let taken = self.take(time, positions);
        self.counters.count(&taken);
        taken
    }

    /// No set-point comes any more: the motion is complete at the last one.
    pub fn end(&mut self) {
        self.is_ended = true;
        if self.knots.is_empty() && self.phase == Phase::Waiting {
            self.phase = Phase::Complete;
        }
        if self.phase == Phase::Dry && self.place == self.last_place() {
            self.phase = Phase::Complete;
        }
    }

    fn take(&mut self, time: Time, positions: &[Position]) -> Result<(), Refusal> {
        if positions.len() != self.axes {
            return Err(Refusal::Axes {
                expected: self.axes,
                actual: positions.len(),
            });
        }
        self.check_open(time)?;
        self.check_travel(positions)?;
        let rates = if self.knots.is_empty() {
            self.check_start(positions)?;
            None
        } else {
            self.check_time(time)?;
            Some(self.check_motion(time, positions)?)
        };
        self.add(time, positions, rates)
    }

    fn check_open(&self, time: Time) -> Result<(), Refusal> {
        if self.is_late {
            return Err(Refusal::Late {
                expected: self.last_time().unwrap_or(self.time),
                actual: time,
            });
        }
        if self.is_ended || self.is_stopping {
            return Err(Refusal::Ended);
        }
        if self.free() == 0 {
            return Err(Refusal::Full { expected: POINTS });
        }
        Ok(())
    }

    fn check_travel(&self, positions: &[Position]) -> Result<(), Refusal> {
        for (axis, (&position, limits)) in positions.iter().zip(&self.limits).enumerate() {
            inside(axis, position, limits)?;
        }
        Ok(())
    }

    fn check_start(&self, positions: &[Position]) -> Result<(), Refusal> {
        let axes = positions.iter().zip(&self.stand).enumerate();
        axes.into_iter()
            .try_for_each(|(axis, (&actual, &expected))| check_start(axis, expected, actual))
    }

    fn check_time(&self, actual: Time) -> Result<(), Refusal> {
        if actual <= self.time {
            let expected = self.time;
            return Err(Refusal::Past { expected, actual });
        }
        let last = self.last_time().unwrap_or(self.time);
        check_gap(last, actual, self.config.longest_gap)
    }

    /// The two stretches that a new set-point changes, of every axis.
    fn check_motion(&self, time: Time, positions: &[Position]) -> Result<Rates, Refusal> {
        let last = self.last_place();
        let (mut before, mut to_last) = (2.0_f32, 1.0_f32);
        let mut has_before = false;
        let mut mean = None;
        for (axis, (&position, limits)) in positions.iter().zip(&self.limits).enumerate() {
            let new = Point { time, position };
            let Some(here) = self.point(last, axis) else {
                continue;
            };
            let mut slope = Slope::default();
            if let Some(earlier) = self.unfinished(last, axis) {
                has_before = true;
                slope = Slope::between(earlier, here, new);
                let stretch = Stretch {
                    from: earlier,
                    to: here,
                    leaving: self.slope(last.saturating_sub(1), axis),
                    arriving: slope,
                };
                let from_rest = last
                    .checked_sub(1)
                    .and_then(|place| self.knot(place))
                    .is_none_or(|knot| knot.rests);
                before = before.min(check_stretch(axis, &stretch, limits, from_rest)?);
                let rate = self.check_mean(axis, new, limits)?;
                mean = rate.map(|rate: MeanRate| rate.with(mean)).or(mean);
            }
            let stretch = Stretch {
                from: here,
                to: new,
                leaving: slope,
                arriving: Slope::default(),
            };
            let needs = stretch.needs();
            check_extent(axis, &stretch, limits)?;
            check_chord(axis, here, new, limits)?;
            to_last = to_last.min(stretch.highest_rate(&needs, limits));
        }
        Ok(Rates {
            mean,
            before: has_before.then_some(of_one(before)),
            last: of_one(to_last),
        })
    }

    /// The point before the last one, when the curve between them is not complete yet.
    fn unfinished(&self, last: usize, axis: usize) -> Option<Point> {
        if self.knot(last)?.rests {
            return None;
        }
        self.point(last.checked_sub(1)?, axis)
    }

    /// The mean acceleration over a longer time: what rounding is on a short one is none on a long one.
    fn check_mean(
        &self,
        axis: usize,
        new: Point,
        limits: &AxisLimits,
    ) -> Result<Option<MeanRate>, Refusal> {
        let window = self.config.window;
        let earlier = |than: Time| {
            (0..self.knots.len()).rev().find_map(|place| {
                let point = self.point(place, axis)?;
                (than.since(point.time) >= window).then_some((place, point))
            })
        };
        let Some((_, middle)) = earlier(new.time) else {
            return Ok(None);
        };
        let Some((place, first)) = earlier(middle.time) else {
            return Ok(None);
        };
        // From rest the rate starts at zero: velocities at the set-points are not those of the axes.
        let has_rest =
            (place..self.knots.len()).any(|place| self.knot(place).is_some_and(|knot| knot.rests));
        if has_rest {
            return Ok(None);
        }
        let rate = check_mean_acceleration(axis, [first, middle, new], limits)?;
        Ok(Some(MeanRate { from: place, rate }))
    }

    fn add(
        &mut self,
        time: Time,
        positions: &[Position],
        rates: Option<Rates>,
    ) -> Result<(), Refusal> {
        let is_first = rates.is_none();
        // The first one is where the axes stand, to the last bit.
        let mut all = self.stand;
        if !is_first {
            all.iter_mut()
                .zip(positions)
                .for_each(|(all, one)| *all = *one);
        }
        if is_first {
            self.time = time;
        }
        let knot = Knot {
            time,
            positions: all,
            rests: is_first,
            highest_rate: ONE,
        };
        if self.knots.push_back(knot).is_err() {
            return Err(Refusal::Full { expected: POINTS });
        }
        if let Some(rates) = rates {
            let before = self.knots.len().saturating_sub(3);
            if let (Some(rate), Some(knot)) = (rates.before, self.knots.get_mut(before)) {
                knot.highest_rate = rate;
            }
            if let Some(MeanRate { from, rate }) = rates.mean {
                for knot in self.knots.iter_mut().skip(from) {
                    knot.highest_rate = knot.highest_rate.min(of_one(rate));
                }
            }
            self.last_rate = rates.last;
            self.is_short = false;
        }
        self.forget_old();
        self.find_highest_rate();
        Ok(())
    }

    /// Whether later set-points may go on where this motion ends.
    pub(crate) const fn waits_when_dry(&self) -> bool {
        matches!(self.config.when_dry, WhenDry::Wait)
    }
}

/// The time from the set-point before.
pub(crate) fn check_gap(last: Time, actual: Time, longest: Time) -> Result<(), Refusal> {
    if actual <= last {
        let expected = last;
        return Err(Refusal::Order { expected, actual });
    }
    let expected = last.after(LEAST_GAP);
    if actual < expected {
        return Err(Refusal::Close { expected, actual });
    }
    let expected = last.after(longest);
    if actual > expected {
        return Err(Refusal::Ahead { expected, actual });
    }
    Ok(())
}

/// Where an axis stands, and where the first set-point is.
pub(crate) fn check_start(
    axis: usize,
    expected: Position,
    actual: Position,
) -> Result<(), Refusal> {
    // Both are within the travel.
    if actual.distance_from(expected).units().abs() > START_TOLERANCE {
        return Err(Refusal::Start {
            axis,
            expected,
            actual,
        });
    }
    Ok(())
}

pub(crate) fn inside(axis: usize, actual: Position, limits: &AxisLimits) -> Result<(), Refusal> {
    let (lowest, highest) = (limits.lowest, limits.highest);
    if actual < lowest || actual > highest {
        return Err(Refusal::Travel {
            axis,
            lowest,
            highest,
            actual,
        });
    }
    Ok(())
}

fn check_extent(axis: usize, stretch: &Stretch, limits: &AxisLimits) -> Result<(), Refusal> {
    let (low, high) = stretch.extent();
    [low, high]
        .into_iter()
        .filter(|at| !limits.admit_on_the_way(*at))
        .try_for_each(|at| inside(axis, at, limits))
}

/// The mean velocity to a set-point, before anything is known of the curve.
pub(crate) fn check_chord(
    axis: usize,
    from: Point,
    to: Point,
    limits: &AxisLimits,
) -> Result<(), Refusal> {
    let cycles = to.time.since(from.time).cycles().max(1.0);
    let expected = limits.velocity() + 1.0 / cycles;
    let actual = crate::stretch::chord(from, to).abs();
    if actual > expected {
        return Err(Refusal::Velocity {
            axis,
            expected,
            actual,
        });
    }
    Ok(())
}

/// Returns the highest rate of a stretch that keeps the limits; one from rest may be slower than the set-points say.
fn check_stretch(
    axis: usize,
    stretch: &Stretch,
    limits: &AxisLimits,
    from_rest: bool,
) -> Result<f32, Refusal> {
    let needs = stretch.needs();
    check_extent(axis, stretch, limits)?;
    if !from_rest {
        stretch.check_velocity(axis, &needs, limits)?;
        stretch.check_acceleration(axis, &needs, limits)?;
    }
    Ok(stretch.highest_rate(&needs, limits))
}

/// A rate in units of [`Rate`](crate::rate::Rate), never zero: what was taken is reached, however slowly.
fn of_one(rate: f32) -> i64 {
    ((rate * ONE as f32) as i64).clamp(1 << 10, 2 * ONE)
}
