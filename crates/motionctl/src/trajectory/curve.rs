//! A curve through the points of one axis.

use clap::ValueEnum;
use trajectory::Position;
use trajectory::curve::{Chord, Piece, Share};

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
/// A piece of a curve is divided into so many steps of time: a nanosecond in an hour.
const STEPS: u64 = 1 << 42;

/// A function of time through given points, constant before the first and after the last.
#[derive(Debug)]
pub(crate) struct Curve {
    times_s: Vec<f64>,
    points: Vec<Position>,
    /// From each point to the next.
    pieces: Vec<Piece>,
}

impl Curve {
    /// A curve through points whose times increase; values in counts.
    pub(crate) fn new(times_s: Vec<f64>, values: Vec<f64>, interpolation: Interpolation) -> Self {
        let points: Vec<Position> = values.into_iter().map(position).collect();
        let pieces = match interpolation {
            Interpolation::Monotone => monotone(&times_s, &points),
            Interpolation::Linear => points
                .windows(2)
                .map(|ends| Piece::line(ends[0], ends[1]))
                .collect(),
        };
        Self {
            times_s,
            points,
            pieces,
        }
    }

    /// The index of the point at or before a time, and the value then.
    pub(crate) fn at(&self, time_s: f64) -> (usize, f64) {
        let after = self.times_s.partition_point(|&point_s| point_s <= time_s);
        if after == 0 {
            return (0, counts(self.points[0]));
        }
        let before = after - 1;
        if after == self.times_s.len() {
            return (before, counts(self.points[before]));
        }
        let width_s = self.times_s[after] - self.times_s[before];
        let share = (time_s - self.times_s[before]) / width_s;
        let share = Share::of((share * STEPS as f64) as u64, STEPS);
        (before, counts(self.pieces[before].at(share)))
    }
}

fn position(counts: f64) -> Position {
    let counts = counts.clamp(-FARTHEST_COUNTS, FARTHEST_COUNTS);
    Position::from_units((counts * UNITS).round() as i64)
}

fn counts(position: Position) -> f64 {
    position.units() as f64 / UNITS
}

/// Cubics with the slopes of [`Chord::velocity_before`], and at rest at both ends of the curve.
fn monotone(times_s: &[f64], points: &[Position]) -> Vec<Piece> {
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
        .zip(points.windows(2).zip(slopes.windows(2)))
        .map(|(width_s, (point, slope))| {
            let [leaving, arriving] =
                [slope[0], slope[1]].map(|slope| position(f64::from(slope) * width_s));
            Piece::cubic(point[0], point[1], leaving, arriving)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(interpolation: Interpolation) -> Curve {
        Curve::new(
            vec![0.0, 1.0, 2.0, 4.0],
            vec![0.0, 10.0, 10.0, -6.0],
            interpolation,
        )
    }

    #[test]
    fn goes_through_its_points_and_stays_at_its_ends() {
        for interpolation in [Interpolation::Monotone, Interpolation::Linear] {
            let curve = curve(interpolation);
            for (time_s, value) in [
                (-1.0, 0.0),
                (0.0, 0.0),
                (1.0, 10.0),
                (2.0, 10.0),
                (4.0, -6.0),
                (9.0, -6.0),
            ] {
                assert!(
                    (curve.at(time_s).1 - value).abs() < 1e-12,
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
            let (_, value) = curve.at(f64::from(step) / 1000.0);
            assert!(value >= before && value <= 10.0);
            before = value;
        }
        assert_eq!(curve.at(1.5).1, 10.0);
    }

    #[test]
    fn linear_is_half_way_in_the_middle() {
        assert_eq!(curve(Interpolation::Linear).at(3.0), (2, 2.0));
    }
}
