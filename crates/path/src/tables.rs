//! Tables: a cam, a gear with a phase, positions over the time. All of them are checked when they are made, against the limits of the axis
//! that follows.
//!
//! ```
//! use path::tables::{Cam, CamPoint};
//! use trajectory::{Limits, Position};
//!
//! const POINTS: [CamPoint; 4] = [
//!     CamPoint { master: 0, follower: 0 },
//!     CamPoint { master: 4_000, follower: 1_000 },
//!     CamPoint { master: 8_000, follower: 1_000 },
//!     CamPoint { master: 16_384, follower: 0 },
//! ];
//! let limits = Limits::new(20.0, 1.0, 1.0)?;
//! // The master turns at up to 20 counts in a cycle.
//! let cam = Cam::new(&POINTS, 20.0, &limits)?;
//! assert_eq!(cam.follower(Position::from_counts(4_000)).counts(), 1_000);
//! // It repeats.
//! assert_eq!(cam.follower(Position::from_counts(4_000 + 16_384)).counts(), 1_000);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

use core::fmt;

use trajectory::curve::{Chord, Piece, Share};
use trajectory::units::Ratio;
use trajectory::{Limits, PlanError, Position, State};

/// A point of a cam, in counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CamPoint {
    /// Position of the master, from 0.
    pub master: i32,
    /// Position of the follower.
    pub follower: i32,
}

/// A point of a time table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TimePoint {
    /// In cycles, from 0.
    pub cycle: u32,
    /// Position in counts.
    pub position: i32,
}

/// Why a table is refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum TableError {
    /// Fewer than two points.
    Points {
        /// What was given.
        actual: usize,
    },
    /// The first point is not at 0.
    Start {
        /// Where it is.
        actual: i64,
    },
    /// A point that is not behind the one before it.
    Order {
        /// The point, counted from 0.
        point: usize,
        /// Where the one before it is.
        before: i64,
        /// Where it is.
        actual: i64,
    },
    /// Between this point and the next one the follower would be faster than its limit.
    Velocity {
        /// The point, counted from 0.
        point: usize,
        /// The limit in counts per cycle.
        most: f32,
        /// What it would need.
        actual: f32,
    },
    /// The same with its acceleration, in counts per cycle².
    Acceleration {
        /// The point, counted from 0.
        point: usize,
        /// The limit.
        most: f32,
        /// What it would need.
        actual: f32,
    },
    /// Between this point and the next one the way is too long for exact positions.
    LongWay {
        /// The point, counted from 0.
        point: usize,
        /// The longest, in counts.
        most: f32,
        /// The steepest slope times the distance between them.
        actual: f32,
    },
    /// A velocity of the master that is no positive number.
    Master {
        /// What was given.
        actual: f32,
    },
}

impl fmt::Display for TableError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Points { actual } => {
                write!(f, "a table has at least 2 points, this one {actual}")
            }
            Self::Start { actual } => write!(f, "a table starts at 0, this one at {actual}"),
            Self::Order {
                point,
                before,
                actual,
            } => write!(
                f,
                "point {point} must be behind {before}, it is at {actual}"
            ),
            Self::Velocity {
                point,
                most,
                actual,
            } => write!(
                f,
                "behind point {point} the velocity would be {actual} counts per cycle, the limit is {most}"
            ),
            Self::Acceleration {
                point,
                most,
                actual,
            } => write!(
                f,
                "behind point {point} the acceleration would be {actual} counts per cycle², the limit is {most}"
            ),
            Self::LongWay {
                point,
                most,
                actual,
            } => write!(
                f,
                "behind point {point} the way would be as of {actual} counts at its fastest, at most {most} are exact: put points between"
            ),
            Self::Master { actual } => write!(
                f,
                "the velocity of a master must be a positive number, got {actual}"
            ),
        }
    }
}

impl core::error::Error for TableError {}

/// The longest way between two points of a table, in counts, as it would be at its largest velocity. A share has steps of 2^-32: they are
/// a 16th of a count then.
const MOST_WAY: f32 = 268_435_456.0;

/// A knot of a curve: where, what, and the slope there.
#[derive(Debug, Clone, Copy)]
struct Knot {
    at: i64,
    value: i64,
}

/// The follower as a curve over the master, which repeats. It is smooth, rises only where its points do, and is flat where they turn.
#[derive(Debug, Clone, Copy)]
pub struct Cam<'a> {
    points: &'a [CamPoint],
    period: i64,
    /// What the follower gains in a period.
    gain: i64,
}

impl<'a> Cam<'a> {
    /// A cam for a master of at most so many counts per cycle. The last point is where it repeats; the follower may be elsewhere then, as
    /// for a feed, and goes on from there.
    ///
    /// # Errors
    /// [`TableError`].
    pub fn new(
        points: &'a [CamPoint],
        master_velocity: f32,
        limits: &Limits,
    ) -> Result<Self, TableError> {
        if !(master_velocity > 0.0 && master_velocity.is_finite()) {
            return Err(TableError::Master {
                actual: master_velocity,
            });
        }
        let knot = |point: &CamPoint| Knot {
            at: point.master.into(),
            value: point.follower.into(),
        };
        check_order(points.len(), points.iter().map(knot))?;
        let (Some(first), Some(last)) = (points.first(), points.last()) else {
            return Err(TableError::Points { actual: 0 });
        };
        let cam = Self {
            points,
            period: last.master.into(),
            gain: i64::from(last.follower) - i64::from(first.follower),
        };
        for point in 0..points.len().saturating_sub(1) {
            cam.check(point, master_velocity, limits)?;
        }
        Ok(cam)
    }

    /// The position of the follower.
    #[must_use]
    pub fn follower(&self, master: Position) -> Position {
        let period = self.period * Position::UNITS;
        let (turns, rest) = match (
            master.units().checked_div_euclid(period),
            master.units().checked_rem_euclid(period),
        ) {
            (Some(turns), Some(rest)) => (turns, rest),
            _ => return Position::ZERO,
        };
        let behind = |point: &CamPoint| i64::from(point.master) * Position::UNITS <= rest;
        let place = self.points.partition_point(behind).saturating_sub(1);
        let Some(span) = self.span(place) else {
            return Position::ZERO;
        };
        let from = span.from.at * Position::UNITS;
        let width = (span.to.at - span.from.at) * Position::UNITS;
        let share = Share::of((rest - from).cast_unsigned(), width.cast_unsigned());
        let follower = span.piece().at(share);
        follower.moved_by(Position::from_units(
            turns.wrapping_mul(self.gain * Position::UNITS),
        ))
    }

    fn check(&self, point: usize, velocity: f32, limits: &Limits) -> Result<(), TableError> {
        match self.span(point) {
            Some(span) => span.check(point, velocity, limits),
            None => Ok(()),
        }
    }

    /// The curve behind a point; the neighbours of the ends are those of the next period.
    fn span(&self, point: usize) -> Option<Span> {
        let knots = self.points.len().checked_sub(1)?;
        let knot = |place: isize| {
            let knots = isize::try_from(knots).ok()?;
            let place_in = place.checked_rem_euclid(knots)?;
            let turns = place.checked_div_euclid(knots)? as i64;
            let point = self.points.get(place_in.cast_unsigned())?;
            Some(Knot {
                at: i64::from(point.master) + turns * self.period,
                value: i64::from(point.follower) + turns * self.gain,
            })
        };
        let place = point as isize;
        Span::new(
            [knot(place - 1)?, knot(place)?],
            [knot(place + 1)?, knot(place + 2)?],
        )
    }
}

/// A cubic between two knots, with the slopes that their neighbours make.
struct Span {
    from: Knot,
    to: Knot,
    /// Counts per unit of the table.
    leaving: f32,
    arriving: f32,
}

impl Span {
    fn new([before, from]: [Knot; 2], [to, after]: [Knot; 2]) -> Option<Self> {
        let here = chord(from, to);
        Some(Self {
            from,
            to,
            leaving: chord(before, from).velocity_before(here),
            arriving: here.velocity_before(chord(to, after)),
        })
    }

    /// From rest or to rest where there is no neighbour.
    fn ending(before: Option<Knot>, from: Knot, to: Knot, after: Option<Knot>) -> Self {
        let here = chord(from, to);
        Self {
            from,
            to,
            leaving: before.map_or(0.0, |before| chord(before, from).velocity_before(here)),
            arriving: after.map_or(0.0, |after| here.velocity_before(chord(to, after))),
        }
    }

    fn width(&self) -> f32 {
        (self.to.at - self.from.at) as f32
    }

    fn piece(&self) -> Piece {
        let way = |slope: f32| {
            let units = slope * self.width() * Position::UNITS as f32;
            Position::from_units(units as i64)
        };
        Piece::cubic(
            Position::from_units(self.from.value * Position::UNITS),
            Position::from_units(self.to.value * Position::UNITS),
            way(self.leaving),
            way(self.arriving),
        )
    }

    /// The largest slope, and the changes of the slope at both ends, between which the largest one is not.
    fn extremes(&self) -> (f32, [f32; 2]) {
        let width = self.width();
        let mean = (self.to.value - self.from.value) as f32 / width;
        let (v0, v1) = (self.leaving, self.arriving);
        // The second derivative is linear: these are its ends.
        let bends = [
            (6.0 * mean - 4.0 * v0 - 2.0 * v1) / width,
            (-6.0 * mean + 2.0 * v0 + 4.0 * v1) / width,
        ];
        let mut slope = v0.abs().max(v1.abs());
        if bends[0] * bends[1] < 0.0 {
            let share = bends[0] / (bends[0] - bends[1]);
            slope = slope.max((v0 + 0.5 * bends[0] * share * width).abs());
        }
        (slope, bends)
    }

    /// Whether the steps of a share are small parts of a count on the whole way.
    fn check_way(&self, point: usize) -> Result<(), TableError> {
        let (slope, _) = self.extremes();
        let actual = slope * self.width();
        if actual > MOST_WAY {
            return Err(TableError::LongWay {
                point,
                most: MOST_WAY,
                actual,
            });
        }
        Ok(())
    }

    fn check(&self, point: usize, rate: f32, limits: &Limits) -> Result<(), TableError> {
        self.check_way(point)?;
        let (slope, bends) = self.extremes();
        let velocity = slope * rate;
        if velocity.is_nan() || velocity > limits.velocity() {
            return Err(TableError::Velocity {
                point,
                most: limits.velocity(),
                actual: velocity,
            });
        }
        let acceleration = bends[0].abs().max(bends[1].abs()) * rate * rate;
        if acceleration.is_nan() || acceleration > limits.acceleration() {
            return Err(TableError::Acceleration {
                point,
                most: limits.acceleration(),
                actual: acceleration,
            });
        }
        Ok(())
    }
}

fn chord(from: Knot, to: Knot) -> Chord {
    let duration = (to.at - from.at) as f32;
    Chord {
        duration,
        velocity: (to.value - from.value) as f32 / duration,
    }
}

fn check_order(points: usize, knots: impl Iterator<Item = Knot>) -> Result<(), TableError> {
    if points < 2 {
        return Err(TableError::Points { actual: points });
    }
    let mut before: Option<i64> = None;
    for (point, knot) in knots.enumerate() {
        match before {
            None if knot.at != 0 => return Err(TableError::Start { actual: knot.at }),
            Some(before) if knot.at <= before => {
                return Err(TableError::Order {
                    point,
                    before,
                    actual: knot.at,
                });
            }
            _ => before = Some(knot.at),
        }
    }
    Ok(())
}

/// Positions over the time, from rest to rest.
#[derive(Debug, Clone, Copy)]
pub struct TimeTable<'a> {
    points: &'a [TimePoint],
}

impl<'a> TimeTable<'a> {
    /// A table whose curve keeps the limits of velocity and acceleration. Its jerk jumps at the points.
    ///
    /// # Errors
    /// [`TableError`].
    pub fn new(points: &'a [TimePoint], limits: &Limits) -> Result<Self, TableError> {
        let table = Self { points };
        check_order(points.len(), points.iter().map(time_knot))?;
        for point in 0..points.len().saturating_sub(1) {
            if let Some(span) = table.span(point) {
                span.check(point, 1.0, limits)?;
            }
        }
        Ok(table)
    }

    /// The position at a cycle; behind the last point it stays there.
    #[must_use]
    pub fn position(&self, cycle: u32) -> Position {
        let place = self.points.partition_point(|point| point.cycle <= cycle);
        let Some(span) = self.span(place.saturating_sub(1)) else {
            let last = self.points.last().map_or(0, |point| point.position);
            return Position::from_counts(last);
        };
        let elapsed = i64::from(cycle).saturating_sub(span.from.at);
        let width = span.to.at - span.from.at;
        span.piece()
            .at(Share::of(elapsed.cast_unsigned(), width.cast_unsigned()))
    }

    fn span(&self, point: usize) -> Option<Span> {
        let knot = |place: usize| self.points.get(place).map(time_knot);
        let (from, to) = (knot(point)?, knot(point + 1)?);
        let before = point.checked_sub(1).and_then(knot);
        Some(Span::ending(before, from, to, knot(point + 2)))
    }
}

fn time_knot(point: &TimePoint) -> Knot {
    Knot {
        at: point.cycle.into(),
        value: point.position.into(),
    }
}

/// A follower at a ratio to its master, with a phase that can be shifted on the way.
#[derive(Debug, Clone, Copy)]
pub struct Gear {
    ratio: Ratio,
    phase: trajectory::Tracker,
    target: Position,
}

impl Gear {
    /// Counts of the follower per count of the master. Shifts of the phase keep these limits, on top of what the master asks for.
    ///
    /// # Errors
    /// [`TableError::Velocity`] when a master of `master_velocity` counts per cycle and a shift together exceed `limits`.
    pub fn new(
        ratio: Ratio,
        master_velocity: f32,
        shift: Limits,
        limits: &Limits,
    ) -> Result<Self, TableError> {
        let size = ratio.numerator().unsigned_abs() as f32 / ratio.denominator() as f32;
        let actual = size * master_velocity.abs() + shift.velocity();
        if actual.is_nan() || actual > limits.velocity() {
            return Err(TableError::Velocity {
                point: 0,
                most: limits.velocity(),
                actual,
            });
        }
        Ok(Self {
            ratio,
            phase: trajectory::Tracker::at_rest(0, shift),
            target: Position::ZERO,
        })
    }

    /// Where the phase goes to, in counts of the follower.
    pub const fn shift_to(&mut self, phase: Position) {
        self.target = phase;
    }

    /// The phase and how it moves.
    #[must_use]
    pub fn phase(&self) -> State {
        self.phase.state()
    }

    /// The follower in the next cycle.
    ///
    /// # Errors
    /// [`PlanError`] for a shift of the phase that is too long to be planned; nothing has moved then.
    pub fn follower(&mut self, master: Position) -> Result<Position, PlanError> {
        let phase = self.phase.next(self.target)?;
        let product = i128::from(master.units()) * i128::from(self.ratio.numerator());
        let scaled = product
            .checked_div(i128::from(self.ratio.denominator()))
            .unwrap_or(0);
        Ok(phase.moved_by(Position::from_units(scaled as i64)))
    }
}

#[cfg(test)]
mod tests {
    use std::string::ToString;

    use super::*;

    const fn cam(master: i32, follower: i32) -> CamPoint {
        CamPoint { master, follower }
    }

    fn limits() -> Limits {
        Limits::new(20.0, 1.0, 1.0).unwrap()
    }

    #[test]
    fn a_cam_meets_its_points_and_repeats() {
        let points = [
            cam(0, 0),
            cam(4_000, 1_000),
            cam(9_000, 1_000),
            cam(16_000, 200),
        ];
        let cam = Cam::new(&points, 20.0, &limits()).unwrap();
        for turn in -2..3 {
            for point in &points[..3] {
                let master = Position::from_counts(point.master + turn * 16_000);
                let expected = point.follower + turn * 200;
                assert_eq!(cam.follower(master).counts(), expected, "{turn} {point:?}");
            }
        }
        // Finite differences keep the limits, over the ends too.
        let at = |cycle: i32| {
            let master = Position::from_counts(cycle * 20);
            cam.follower(master).units() as f64 / 16_777_216.0
        };
        for cycle in -900..900 {
            let (a, b, c) = (at(cycle), at(cycle + 1), at(cycle + 2));
            assert!(
                (b - a).abs() <= 20.0 && (c - 2.0 * b + a).abs() <= 1.0,
                "{cycle}"
            );
        }
    }

    #[test]
    fn a_cam_is_refused_with_what_it_needs() {
        let of = |points: &[CamPoint], velocity| {
            Cam::new(points, velocity, &limits())
                .map(|_| ())
                .unwrap_err()
        };
        assert_eq!(of(&[cam(0, 0)], 1.0), TableError::Points { actual: 1 });
        assert_eq!(
            of(&[cam(5, 0), cam(9, 0)], 1.0),
            TableError::Start { actual: 5 }
        );
        let order = of(&[cam(0, 0), cam(9, 0), cam(9, 1)], 1.0);
        assert_eq!(order.to_string(), "point 2 must be behind 9, it is at 9");
        assert!(matches!(
            of(&[cam(0, 0), cam(100, 0)], f32::NAN),
            TableError::Master { .. }
        ));
        // As of 2^28 counts and one half more: the steps of a share would be too large a part of a count.
        let long = [
            cam(0, 0),
            cam(200_000_000, 0),
            cam(400_000_000, 300_000_000),
        ];
        assert!(matches!(
            of(&long, 1.0),
            TableError::LongWay { point: 0 | 1, .. }
        ));
        let steep = [cam(0, 0), cam(1_000, 5_000), cam(8_000, 0)];
        assert!(matches!(
            of(&steep, 20.0),
            TableError::Velocity { point: 0, .. }
        ));
        let sharp = [cam(0, 0), cam(100, 80), cam(200, 0), cam(8_000, 0)];
        assert!(matches!(
            of(&sharp, 15.0),
            TableError::Acceleration { point: 0, .. }
        ));
    }

    #[test]
    fn a_time_table_goes_from_rest_to_rest() {
        let point = |cycle, position| TimePoint { cycle, position };
        let points = [
            point(0, 0),
            point(300, 1_000),
            point(400, 2_000),
            point(900, 2_500),
        ];
        let table = TimeTable::new(&points, &limits()).unwrap();
        for point in &points {
            assert_eq!(table.position(point.cycle).counts(), point.position);
        }
        assert_eq!(table.position(u32::MAX).counts(), 2_500);
        let at =
            |cycle: i64| table.position(cycle.clamp(0, 2_000) as u32).units() as f64 / 16_777_216.0;
        for cycle in -2..1_000 {
            let (a, b, c) = (at(cycle), at(cycle + 1), at(cycle + 2));
            assert!(
                (b - a).abs() <= 20.0 && (c - 2.0 * b + a).abs() <= 1.0,
                "{cycle}"
            );
        }
        let fast = [point(0, 0), point(10, 1_000)];
        assert!(matches!(
            TimeTable::new(&fast, &limits()),
            Err(TableError::Velocity { .. })
        ));
    }

    #[test]
    fn a_gear_follows_and_shifts_its_phase_within_limits() {
        let ratio = Ratio::new(-3, 2).unwrap();
        let shift = Limits::new(2.0, 0.1, 0.01).unwrap();
        let mut gear = Gear::new(ratio, 10.0, shift, &limits()).unwrap();
        gear.shift_to(Position::from_counts(500));
        let mut before = 0.0;
        for cycle in 1..1_000 {
            let master = Position::from_counts(cycle * 10);
            let follower = gear.follower(master).unwrap().units() as f64 / 16_777_216.0;
            let phase = follower + 15.0 * f64::from(cycle);
            assert!((phase - before).abs() <= 2.0 + 1e-6);
            before = phase;
        }
        assert!((before - 500.0).abs() < 1e-6, "{before}");
        assert!(matches!(
            Gear::new(ratio, 14.0, shift, &limits()),
            Err(TableError::Velocity { .. })
        ));
    }
}
