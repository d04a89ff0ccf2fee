//! Counts of values in bins of equal width.

/// Most bins of a histogram.
const MOST_BINS: f64 = 60.0;

/// Bins from the least value to the most.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Histogram {
    /// Where the first bin begins.
    pub(super) start: f64,
    /// 1, 2 or 5 times a power of ten, at least 1.
    pub(super) width: f64,
    /// Values in each bin.
    pub(super) counts: Vec<u64>,
}

impl Histogram {
    /// Each value is in the bin around its nearest multiple of the width. Without values there is one empty bin.
    pub(super) fn of(values: &[f32]) -> Self {
        let (least, most) = values
            .iter()
            .map(|value| f64::from(*value))
            .fold((0.0_f64, 0.0_f64), |(least, most), value| {
                (least.min(value), most.max(value))
            });
        let width = bin_width((most - least) / MOST_BINS);
        let first = (least / width).round();
        let bins = (most / width).round() - first + 1.0;
        let mut counts = vec![0; bins as usize];
        for value in values {
            let bin = (f64::from(*value) / width).round() - first;
            if let Some(count) = counts.get_mut(bin as usize) {
                *count += 1;
            }
        }
        Self {
            start: (first - 0.5) * width,
            width,
            counts,
        }
    }

    /// Where the last bin ends.
    pub(super) fn end(&self) -> f64 {
        self.start + self.width * self.counts.len() as f64
    }
}

/// The next width that reads well.
fn bin_width(least: f64) -> f64 {
    let power = 10_f64.powf(least.max(1.0).log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0];
    let step = steps.iter().find(|step| *step * power >= least);
    step.map_or(10.0, |step| *step) * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_in_one_bin() {
        let histogram = Histogram::of(&[0.0, 0.4, -3.0, 5.2, 0.0]);
        assert_eq!(
            (histogram.start, histogram.width, histogram.end()),
            (-3.5, 1.0, 5.5)
        );
        assert_eq!(histogram.counts, [1, 0, 0, 3, 0, 0, 0, 0, 1]);
    }

    #[test]
    fn a_wide_range_has_few_bins_of_a_round_width() {
        let histogram = Histogram::of(&[-1_000.0, 1_000.0]);
        assert_eq!((histogram.width, histogram.counts.len()), (50.0, 41));
        assert_eq!(histogram.counts.iter().sum::<u64>(), 2);
        assert_eq!(Histogram::of(&[]).counts, [0]);
    }
}
