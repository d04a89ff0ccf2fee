//! A curve through the points of one axis, made of the pieces that a motion board plays: a set-point is the same, wherever it is computed.

use board_link::segment::{AxisSegment, Shape};
use clap::ValueEnum;
use trajectory::curve::{Chord, Share};
use trajectory::{Position, Time};

/// How to go from point to point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum Interpolation {
    /// Monotone cubic: smooth velocity, and never beyond the points.
    #[default]
    Monotone,
    /// Straight lines: constant velocity between points.
    Linear,
}

/// Values beyond this many counts are beyond every travel, and refused as such: no need to compute with them.
const FARTHEST_COUNTS: f64 = (1_u64 << 33) as f64;
const UNITS: f64 = Position::UNITS as f64;
const TICKS: f64 = (1_u64 << 32) as f64;
/// Seconds since the start are known to so many ticks of a cycle at least, in a motion of a day: a time that is as near to a whole cycle is one.
const TICKS_OF_ROUNDING: u64 = 256;

/// The times of the points, in seconds and in cycles.
#[derive(Debug)]
pub(crate) struct Times {
    seconds: Vec<f64>,
    cycles: Vec<Time>,
    /// A piece is at most so long: a longer way is several.
    longest: Time,
}

impl Times {
    /// Ascending times; a board takes pieces of up to 10 s.
    pub(crate) fn new(seconds: &[f64], cycle_us: u32) -> Self {
        let mut cycles: Vec<Time> = Vec::with_capacity(seconds.len());
        for seconds in seconds {
            let time = time(seconds * 1e6 / f64::from(cycle_us));
            // However close, one is behind the other.
            let least = cycles.last().map_or(0, |before| before.ticks() + 1);
            cycles.push(time.max(Time::from_ticks(least)));
        }
        Self {
            seconds: seconds.to_vec(),
            cycles,
            longest: Time::from_units(8_000_000, cycle_us),
        }
    }

    /// The end of the last one.
    pub(crate) fn end(&self) -> Time {
        self.cycles.last().copied().unwrap_or_default()
    }
}

/// A time in cycles; one that rounding has brought beside a whole cycle is that cycle.
pub(super) fn time(cycles: f64) -> Time {
    let ticks = (cycles * TICKS).round() as u64;
    let whole = (ticks.saturating_add(1 << 31) >> 32) << 32;
    Time::from_ticks(if ticks.abs_diff(whole) <= TICKS_OF_ROUNDING {
        whole
    } else {
        ticks
    })
}

/// A function of time through given points, constant before the first and after the last.
#[derive(Debug)]
pub(crate) struct Curve {
    start: Position,
    /// When each piece begins, and the end.
    times: Vec<Time>,
    /// The point at or before each piece, and the last one.
    points: Vec<usize>,
    pieces: Vec<AxisSegment>,
}

impl Curve {
    /// A curve through points at these times; values in counts.
    pub(crate) fn new(times: &Times, values: Vec<f64>, interpolation: Interpolation) -> Self {
        let points: Vec<Position> = values.into_iter().map(position).collect();
        let shapes = match interpolation {
            Interpolation::Monotone => monotone(&times.seconds, &points),
            Interpolation::Linear => vec![Shape::Line; points.len().saturating_sub(1)],
        };
        let mut curve = Self {
            start: points.first().copied().unwrap_or_default(),
            times: vec![Time::ZERO],
            points: Vec::new(),
            pieces: Vec::new(),
        };
        let ways = times.cycles.windows(2).zip(points.windows(2)).zip(shapes);
        for (point, ((time, ends), shape)) in ways.enumerate() {
            curve.add(point, time, ends, shape, times.longest);
        }
        curve.points.push(points.len().saturating_sub(1));
        curve
    }

    /// Adds the way from a point to the next, in as many pieces of the same length as it takes.
    fn add(&mut self, point: usize, time: &[Time], ends: &[Position], shape: Shape, longest: Time) {
        let duration = time[1].since(time[0]).ticks();
        let count = duration.div_ceil(longest.ticks().max(1)).max(1);
        for number in 1..=count {
            // Times and counts of pieces are far from 64 bits together.
            let passed = |number: u64| {
                (u128::from(duration) * u128::from(number) / u128::from(count)) as u64
            };
            let shares = [number - 1, number].map(|number| passed(number) as f64 / duration as f64);
            let piece = if count == 1 {
                AxisSegment {
                    end: ends[1].units(),
                    shape,
                }
            } else {
                part(ends, shape, shares)
            };
            let end = Time::from_ticks(time[0].ticks() + passed(number));
            self.points.push(point);
            self.pieces.push(piece);
            self.times.push(end);
        }
    }

    /// The index of the point at or before a time, and the position then.
    pub(crate) fn at(&self, time: Time) -> (usize, Position) {
        let after = self.times.partition_point(|begin| *begin <= time);
        let piece = after.saturating_sub(1);
        let point = self.points.get(piece).copied().unwrap_or_default();
        let Some(way) = self.pieces.get(piece) else {
            let end = self
                .pieces
                .last()
                .map(|last| Position::from_units(last.end));
            return (point, end.unwrap_or(self.start));
        };
        let share = Share::of(
            time.since(self.times[piece]).ticks(),
            self.times[after].since(self.times[piece]).ticks(),
        );
        (point, way.piece(self.begin_of(piece)).at(share))
    }

    fn begin_of(&self, piece: usize) -> Position {
        let before = piece.checked_sub(1).map(|before| self.pieces[before].end);
        before.map_or(self.start, Position::from_units)
    }

    /// How long each piece lasts.
    pub(crate) fn durations(&self) -> impl Iterator<Item = Time> + '_ {
        self.times.windows(2).map(|time| time[1].since(time[0]))
    }

    /// The pieces, from the first point on.
    pub(crate) fn pieces(&self) -> &[AxisSegment] {
        &self.pieces
    }
}

pub(super) fn position(counts: f64) -> Position {
    let counts = counts.clamp(-FARTHEST_COUNTS, FARTHEST_COUNTS);
    Position::from_units((counts * UNITS).round() as i64)
}

pub(super) fn counts(position: Position) -> f64 {
    position.units() as f64 / UNITS
}

/// A part of a way, from one share of its time to another.
fn part(ends: &[Position], shape: Shape, [from, to]: [f64; 2]) -> AxisSegment {
    let (start, way) = (counts(ends[0]), counts(ends[1].distance_from(ends[0])));
    let (leaving, arriving) = match shape {
        Shape::Cubic { leaving, arriving } => (leaving as f64 / UNITS, arriving as f64 / UNITS),
        // A straight line is a cubic with the mean velocity at both ends.
        _ => (way, way),
    };
    let (square, cube) = (
        3.0 * way - 2.0 * leaving - arriving,
        leaving + arriving - 2.0 * way,
    );
    let velocity =
        |share: f64| (leaving + (2.0 * square + 3.0 * cube * share) * share) * (to - from);
    let end = if to >= 1.0 {
        ends[1]
    } else {
        position(start + (leaving + (square + cube * to) * to) * to)
    };
    AxisSegment {
        end: end.units(),
        shape: match shape {
            Shape::Cubic { .. } => Shape::Cubic {
                leaving: position(velocity(from)).units(),
                arriving: position(velocity(to)).units(),
            },
            other => other,
        },
    }
}

/// Cubics with the slopes of [`Chord::velocity_before`], and at rest at both ends of the curve.
fn monotone(times_s: &[f64], points: &[Position]) -> Vec<Shape> {
    let chords: Vec<Chord> = times_s
        .windows(2)
        .zip(points.windows(2))
        .map(|(time, point)| {
            let width_s = time[1] - time[0];
            Chord {
                duration: width_s as f32,
                velocity: (counts(point[1].distance_from(point[0])) / width_s) as f32,
            }
        })
        .collect();
    let inner = chords
        .windows(2)
        .map(|pair| pair[0].velocity_before(pair[1]));
    let slopes: Vec<f32> = core::iter::once(0.0)
        .chain(inner)
        .chain(core::iter::once(0.0))
        .collect();
    let widths_s = times_s.windows(2).map(|time| time[1] - time[0]);
    widths_s
        .zip(slopes.windows(2))
        .map(|(width_s, slope)| {
            let [leaving, arriving] =
                [slope[0], slope[1]].map(|slope| position(f64::from(slope) * width_s).units());
            Shape::Cubic { leaving, arriving }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(interpolation: Interpolation) -> Curve {
        let times = Times::new(&[0.0, 1.0, 2.0, 40.0], 1_000);
        Curve::new(&times, vec![0.0, 10.0, 10.0, -6.0], interpolation)
    }

    fn at(curve: &Curve, seconds: f64) -> (usize, f64) {
        let (point, position) = curve.at(time(seconds.max(0.0) * 1_000.0));
        (point, counts(position))
    }

    #[test]
    fn goes_through_its_points_and_stays_at_its_ends() {
        for interpolation in [Interpolation::Monotone, Interpolation::Linear] {
            let curve = curve(interpolation);
            for (time_s, point, value) in [
                (-1.0, 0, 0.0),
                (0.0, 0, 0.0),
                (1.0, 1, 10.0),
                (2.0, 2, 10.0),
                (40.0, 3, -6.0),
                (90.0, 3, -6.0),
            ] {
                assert_eq!(
                    at(&curve, time_s),
                    (point, value),
                    "{interpolation:?} {time_s}"
                );
            }
        }
    }

    #[test]
    fn monotone_never_leaves_the_range_of_its_points() {
        let curve = curve(Interpolation::Monotone);
        let mut before = f64::NEG_INFINITY;
        for step in 0..=1000 {
            let (_, value) = at(&curve, f64::from(step) / 1000.0);
            assert!(value >= before && value <= 10.0);
            before = value;
        }
        assert_eq!(at(&curve, 1.5).1, 10.0);
    }

    #[test]
    fn linear_is_half_way_in_the_middle() {
        assert_eq!(at(&curve(Interpolation::Linear), 21.0), (2, 2.0));
    }

    #[test]
    fn a_long_way_is_several_pieces_of_the_same_curve() {
        for interpolation in [Interpolation::Monotone, Interpolation::Linear] {
            let long = curve(interpolation);
            let longest = long.durations().max().unwrap_or_default();
            assert!(longest <= Time::from_cycles(8_000), "{longest}");
            let whole = Curve::new(
                &Times {
                    longest: Time::MAX,
                    ..Times::new(&[0.0, 1.0, 2.0, 40.0], 1_000)
                },
                vec![0.0, 10.0, 10.0, -6.0],
                interpolation,
            );
            assert_eq!(whole.pieces().len(), 3);
            for ms in 0..40_000 {
                let (one, other) = (
                    long.at(Time::from_cycles(ms)).1,
                    whole.at(Time::from_cycles(ms)).1,
                );
                let apart = one.distance_from(other).units().abs();
                assert!(apart <= 1 << 6, "{interpolation:?} {ms}: {apart}");
            }
        }
    }

    #[test]
    fn whole_milliseconds_of_a_day_are_whole_cycles() {
        for ms in [1_u32, 3, 86_399_999, 3_600_001, 70_000_007] {
            let times = Times::new(&[f64::from(ms) / 1_000.0], 1_000);
            assert_eq!(times.end(), Time::from_cycles(ms));
        }
        // Closer than a cycle has parts, and still apart.
        let times = Times::new(&[0.0, 1e-12, 2e-12], 1_000);
        assert_eq!(times.cycles[2], Time::from_ticks(2));
        assert_eq!(time(10.25), Time::from_ticks((10 << 32) | (1 << 30)));
    }
}
