//! What an answer is worth, in numbers.

use schemars::JsonSchema;
use serde::Serialize;

use super::measure::Sample;

/// An axis has settled when it stays so near, as a share of the step.
const BAND: f64 = 0.05;
/// The least band, in counts: a position is a whole count.
const LEAST_BAND: f64 = 2.0;

/// The figures of an answer; the worst of its steps.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub(crate) struct Figures {
    /// Positions that were read.
    pub(crate) samples: usize,
    /// Beyond the step, in percent of its height.
    pub(crate) overshoot_percent: f64,
    /// From 10 to 90 % of the step; `None` when a step has no such positions.
    pub(crate) rise_ms: Option<f64>,
    /// Until the axis stays within 5 % of the step, and at least 2 counts; `None` when it does not settle within the hold time.
    pub(crate) settling_ms: Option<f64>,
    /// Root of the mean square, and largest, of the set-point minus the position; a step is its own height at first.
    pub(crate) following_error_rms_counts: f64,
    pub(crate) following_error_peak_counts: i32,
    /// Set-point minus position at the end of a step.
    pub(crate) rest_error_counts: i32,
}

impl Figures {
    /// The figures of steps that follow each other after so many milliseconds, of this height to and fro.
    pub(crate) fn of(samples: &[Sample], hold_ms: f64, step_counts: i32, steps: u32) -> Self {
        let answers: Vec<Answer> = (0..steps)
            .map(|step| {
                let from_ms = f64::from(step) * hold_ms;
                let height = f64::from(if step % 2 == 0 {
                    step_counts
                } else {
                    -step_counts
                });
                let base = f64::from(if step % 2 == 0 { 0 } else { step_counts });
                Answer::of(samples, from_ms, from_ms + hold_ms, base, height)
            })
            .collect();
        let moving: Vec<i32> = samples
            .iter()
            .filter(|sample| sample.at_ms >= 0.0)
            .map(|sample| sample.set_point - sample.actual)
            .collect();
        let square: f64 = moving.iter().map(|&error| f64::from(error).powi(2)).sum();
        let worst = |values: Vec<Option<f64>>| {
            let values: Option<Vec<f64>> = values.into_iter().collect();
            values.map(|values| values.into_iter().fold(0.0, f64::max))
        };
        let rest = answers.iter().map(|answer| answer.rest_counts);
        Self {
            samples: moving.len(),
            overshoot_percent: answers
                .iter()
                .fold(0.0, |most, answer| answer.overshoot_percent.max(most)),
            rise_ms: worst(answers.iter().map(|answer| answer.rise_ms).collect()),
            settling_ms: worst(answers.iter().map(|answer| answer.settling_ms).collect()),
            following_error_rms_counts: (square / moving.len().max(1) as f64).sqrt(),
            following_error_peak_counts: moving.iter().map(|error| error.abs()).max().unwrap_or(0),
            rest_error_counts: rest.max_by_key(|error| error.abs()).unwrap_or(0),
        }
    }

    /// In the order of [`Self::TITLES`].
    pub(crate) fn cells(&self) -> [String; 6] {
        let ms =
            |value: Option<f64>| value.map_or_else(|| "never".to_owned(), |ms| format!("{ms:.1}"));
        [
            format!("{:.1}", self.overshoot_percent),
            ms(self.rise_ms),
            ms(self.settling_ms),
            format!("{:.1}", self.following_error_rms_counts),
            self.following_error_peak_counts.to_string(),
            self.rest_error_counts.to_string(),
        ]
    }

    pub(crate) const TITLES: [&str; 6] = [
        "overshoot\n%",
        "rise\nms",
        "settling\nms",
        "error rms\ncounts",
        "error peak\ncounts",
        "at rest\ncounts",
    ];
}

/// The figures of one step.
struct Answer {
    overshoot_percent: f64,
    rise_ms: Option<f64>,
    settling_ms: Option<f64>,
    rest_counts: i32,
}

impl Answer {
    fn of(samples: &[Sample], from_ms: f64, until_ms: f64, base: f64, height: f64) -> Self {
        let mut within = samples
            .iter()
            .filter(|sample| (from_ms..until_ms).contains(&sample.at_ms));
        // The share of the step, from 0 to 1.
        let shares: Vec<(f64, f64)> = within
            .clone()
            .map(|sample| {
                let way = f64::from(sample.actual) - base;
                (sample.at_ms - from_ms, way / height)
            })
            .collect();
        let most = shares
            .iter()
            .fold(0.0_f64, |most, (_, share)| share.max(most));
        let first = |level: f64| {
            shares
                .iter()
                .find(|(_, share)| *share >= level)
                .map(|(at, _)| *at)
        };
        let band = BAND.max(LEAST_BAND / height.abs());
        let is_off = |share: f64| (share - 1.0).abs() > band;
        let last_off = shares.iter().rposition(|(_, share)| is_off(*share));
        let settled = match last_off {
            None => shares.first(),
            Some(place) => shares.get(place + 1),
        };
        let rest = within
            .next_back()
            .map_or(0, |sample| sample.set_point - sample.actual);
        Self {
            overshoot_percent: (most - 1.0).max(0.0) * 100.0,
            rise_ms: first(0.9).zip(first(0.1)).map(|(high, low)| high - low),
            settling_ms: settled.map(|(at, _)| *at),
            rest_counts: rest,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two steps of 100 counts, 10 ms each, one sample a millisecond.
    fn samples(positions: [i32; 20]) -> Vec<Sample> {
        let sample = |(ms, actual)| Sample {
            at_ms: f64::from(ms),
            set_point: if ms < 10 { 100 } else { 0 },
            actual,
        };
        (0..20).zip(positions).map(sample).collect()
    }

    #[test]
    fn the_figures_are_those_of_the_worst_step() {
        let positions = [
            0, 10, 50, 90, 120, 110, 104, 100, 100, 99, 100, 80, 30, 10, 2, 0, 0, 0, 0, 0,
        ];
        let figures = Figures::of(&samples(positions), 10.0, 100, 2);
        assert_eq!((figures.overshoot_percent * 10.0).round(), 200.0);
        assert_eq!(figures.rise_ms, Some(2.0));
        // 104 is within 5 %, 110 is not.
        assert_eq!(figures.settling_ms, Some(6.0));
        assert_eq!(figures.following_error_peak_counts, 100);
        assert_eq!(figures.rest_error_counts, 1);
        let square = (100_i32.pow(2)
            + 90_i32.pow(2)
            + 50_i32.pow(2)
            + 10_i32.pow(2)
            + 20_i32.pow(2)
            + 10_i32.pow(2)
            + 4_i32.pow(2)
            + 1
            + 100_i32.pow(2)
            + 80_i32.pow(2)
            + 30_i32.pow(2)
            + 10_i32.pow(2)
            + 2_i32.pow(2)) as f64;
        assert!((figures.following_error_rms_counts - (square / 20.0).sqrt()).abs() < 1e-9);
    }

    #[test]
    fn an_axis_that_swings_for_ever_never_settles() {
        let positions = [
            0, 150, 50, 150, 50, 150, 50, 150, 50, 150, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,
        ];
        let figures = Figures::of(&samples(positions), 10.0, 100, 2);
        assert_eq!(figures.settling_ms, None);
        assert_eq!(figures.cells()[2], "never");
    }
}
