//! A curve through the points of one axis.

use clap::ValueEnum;

/// How to go from point to point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum Interpolation {
    /// Monotone cubic: smooth velocity, and never beyond the points.
    #[default]
    Monotone,
    /// Straight lines: constant velocity between points.
    Linear,
}

/// A function of time through given points, constant before the first and after the last.
#[derive(Debug)]
pub(crate) struct Curve {
    times_s: Vec<f64>,
    values: Vec<f64>,
    /// Slope at each point; empty for straight lines.
    slopes: Vec<f64>,
}

impl Curve {
    /// A curve through points whose times increase.
    pub(crate) fn new(times_s: Vec<f64>, values: Vec<f64>, interpolation: Interpolation) -> Self {
        let slopes = match interpolation {
            Interpolation::Monotone => monotone_slopes(&times_s, &values),
            Interpolation::Linear => Vec::new(),
        };
        Self {
            times_s,
            values,
            slopes,
        }
    }

    /// The index of the point at or before a time, and the value then.
    pub(crate) fn at(&self, time_s: f64) -> (usize, f64) {
        let after = self.times_s.partition_point(|&point_s| point_s <= time_s);
        if after == 0 {
            return (0, self.values[0]);
        }
        let before = after - 1;
        if after == self.times_s.len() {
            return (before, self.values[before]);
        }
        let width_s = self.times_s[after] - self.times_s[before];
        let share = (time_s - self.times_s[before]) / width_s;
        let (from, to) = (self.values[before], self.values[after]);
        let Some((&leaving, &arriving)) = self.slopes.get(before).zip(self.slopes.get(after))
        else {
            return (before, from + (to - from) * share);
        };
        (
            before,
            hermite(share, from, to, leaving * width_s, arriving * width_s),
        )
    }
}

/// Cubic Hermite polynomial on 0 ..= 1.
fn hermite(x: f64, from: f64, to: f64, leaving: f64, arriving: f64) -> f64 {
    let rest = 1.0 - x;
    from * rest * rest * (1.0 + 2.0 * x) + to * x * x * (3.0 - 2.0 * x) + leaving * x * rest * rest
        - arriving * x * x * rest
}

/// Slopes after Fritsch and Butland (1984): the weighted harmonic mean of the neighbouring chords, 0 at a turning point
/// and at both ends, so that the curve starts and ends at rest and stays between its points.
fn monotone_slopes(times_s: &[f64], values: &[f64]) -> Vec<f64> {
    let chords: Vec<(f64, f64)> = times_s
        .windows(2)
        .zip(values.windows(2))
        .map(|(t, v)| (t[1] - t[0], (v[1] - v[0]) / (t[1] - t[0])))
        .collect();
    let inner = chords.windows(2).map(|pair| {
        let ((before_s, before), (after_s, after)) = (pair[0], pair[1]);
        if before * after <= 0.0 {
            return 0.0;
        }
        let (weight_before, weight_after) = (2.0 * after_s + before_s, after_s + 2.0 * before_s);
        (weight_before + weight_after) / (weight_before / before + weight_after / after)
    });
    core::iter::once(0.0)
        .chain(inner)
        .chain(core::iter::once(0.0))
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
