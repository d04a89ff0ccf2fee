//! Fewer points, same picture: in each column of the picture the first, the smallest, the largest and the last point stay.

/// Points of one column.
#[derive(Debug, Clone, Copy)]
struct Column {
    number: u64,
    first: (f64, f64),
    least: (f64, f64),
    most: (f64, f64),
    last: (f64, f64),
}

impl Column {
    fn new(number: u64, point: (f64, f64)) -> Self {
        Self {
            number,
            first: point,
            least: point,
            most: point,
            last: point,
        }
    }

    fn add(&mut self, point: (f64, f64)) {
        if point.1 < self.least.1 {
            self.least = point;
        }
        if point.1 > self.most.1 {
            self.most = point;
        }
        self.last = point;
    }

    /// In the order of time, without repetitions.
    fn points(&self) -> Vec<(f64, f64)> {
        let mut points = vec![self.first, self.least, self.most, self.last];
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup();
        points
    }
}

/// Thins points in the order of their x to at most four in each of `columns` columns of `0 ..= end`.
pub(super) fn thin(
    points: impl Iterator<Item = (f64, f64)>,
    end: f64,
    columns: u32,
) -> Vec<(f64, f64)> {
    let columns = columns_of(points, end, columns);
    columns.iter().flat_map(Column::points).collect()
}

/// The largest value in each column: what matters of a sawtooth, whose teeth would hide everything behind them.
pub(super) fn peaks(
    points: impl Iterator<Item = (f64, f64)>,
    end: f64,
    columns: u32,
) -> Vec<(f64, f64)> {
    let columns = columns_of(points, end, columns);
    columns.iter().map(|column| column.most).collect()
}

fn columns_of(points: impl Iterator<Item = (f64, f64)>, end: f64, columns: u32) -> Vec<Column> {
    let per_x = f64::from(columns) / end.max(f64::MIN_POSITIVE);
    let mut filled: Vec<Column> = Vec::new();
    for point in points {
        let number = (point.0 * per_x) as u64;
        match filled.last_mut() {
            Some(column) if column.number == number => column.add(point),
            _ => filled.push(Column::new(number, point)),
        }
    }
    filled
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn a_spike_of_one_sample_survives() {
        let points = (0..100_000).map(|n| (f64::from(n), if n == 56_789 { 7.0 } else { 0.0 }));
        let thinned = thin(points, 100_000.0, 1_000);
        assert!(thinned.len() <= 4_000);
        assert!(thinned.contains(&(56_789.0, 7.0)));
    }

    #[test]
    fn peaks_are_the_largest_values() {
        let sawtooth = (0..1_000).map(|n| (f64::from(n), f64::from(n % 20)));
        let peaks = peaks(sawtooth, 1_000.0, 10);
        assert_eq!(peaks.len(), 10);
        assert!(peaks.iter().all(|(_, value)| *value == 19.0));
    }

    proptest! {
        #[test]
        fn every_column_keeps_its_extremes(values in prop::collection::vec(-1e6_f64..1e6, 1..500)) {
            let points: Vec<(f64, f64)> = values.iter().enumerate().map(|(n, value)| (n as f64, *value)).collect();
            let thinned = thin(points.iter().copied(), values.len() as f64, 10);
            prop_assert!(thinned.len() <= 40);
            prop_assert!(thinned.is_sorted_by(|a, b| a.0 < b.0));
            let extremes = |points: &[(f64, f64)]| {
                points.iter().fold((f64::MAX, f64::MIN), |(least, most), point| (least.min(point.1), most.max(point.1)))
            };
            prop_assert_eq!(extremes(&thinned), extremes(&points));
        }
    }
}
