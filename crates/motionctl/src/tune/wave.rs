//! The waves that DYN drives make by themselves (functions 0Bh to 0Dh), and what is measured of them.
//!
//! Where the drive is in its wave no message tells, so there are no set-points to compare with: the figures come from the positions alone.

use can_motion::{DriveMove, Instant, Limits, PollPeriods, WaveShape};
use clap::ValueEnum;
use dyn_can::{Amplitude, FrequencyHz, Request, StepLimit};
use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::Arguments;
use super::measure::{CYCLE_BITS, CYCLE_US, Measured, Sample, limits};
use crate::drives::DrivesError;
use crate::interrupt;
use crate::link::Link;
use crate::own_moves::{hold, until_back};
use crate::station::{GROUP, Station, look};

/// Who makes the wave.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum WaveOption {
    /// This computer, by steps of the set-points.
    Step,
    /// The drive: a square wave.
    DriveSquare,
    /// The drive: a sine.
    DriveSine,
}

impl WaveOption {
    /// The shape, where the drive makes it.
    pub(super) const fn shape(self) -> Option<WaveShape> {
        match self {
            Self::Step => None,
            Self::DriveSquare => Some(WaveShape::Square),
            Self::DriveSine => Some(WaveShape::Sine),
        }
    }
}

/// An amplitude of 4096 is half a turn (1.6A section 6, function 0Bh).
const AMPLITUDE_OF_A_TURN: f64 = 8_192.0;
/// Time before the wave and behind it, in which nothing is measured.
const END_LIMIT_US: u64 = 5_000_000;

/// The amplitude in the unit of the drive.
pub(super) fn amplitude(turns: f64) -> i32 {
    (turns.abs() * AMPLITUDE_OF_A_TURN).round() as i32
}

/// From one side to the other, in command counts of a drive with this gear number.
pub(super) fn told_counts(turns: f64, gear: i32) -> i32 {
    const COUNTS_OF_A_TURN: f64 = 4.0;
    let turn = f64::from(gear) * COUNTS_OF_A_TURN;
    (f64::from(amplitude(turns)) * 2.0 / AMPLITUDE_OF_A_TURN * turn).round() as i32
}

/// What the drive is told, for `--dry-run`.
pub(super) fn requests(arguments: &Arguments, shape: WaveShape) -> Vec<Request> {
    let wave = |amplitude: i32| {
        let amplitude = Amplitude::new(amplitude).ok()?;
        Some(match shape {
            WaveShape::Square => Request::SquareWave(amplitude),
            WaveShape::Sine => Request::SinWave(amplitude),
        })
    };
    let frequency = |hz: i32| FrequencyHz::new(hz).ok().map(Request::SsFrequency);
    let told = [
        frequency(arguments.frequency.into()),
        wave(amplitude(arguments.amplitude)),
        wave(0),
        frequency(0),
    ];
    told.into_iter().flatten().collect()
}

/// Enables, lets the drive make its wave, disables.
pub(super) fn measure(
    link: &mut Link,
    arguments: &Arguments,
    shape: WaveShape,
) -> Result<Measured, DrivesError> {
    let drive = arguments.drive;
    let seen = look(link, arguments.axes, &[drive]).map_err(DrivesError::Look)?;
    let seen = seen.first().ok_or(DrivesError::Incomplete {
        drive: drive.into(),
    })?;
    let excursion = told_counts(arguments.amplitude, seen.gear.get().into()) / 2 + 1;
    let cycle_us = CYCLE_US.max(link.bit_rate().us_covering(CYCLE_BITS));
    let polls = PollPeriods {
        status_us: Some(100_000),
        position_us: Some(cycle_us),
        ..PollPeriods::OFF
    };
    let room = limits(seen.position_counts, excursion);
    let limits = Limits {
        // A square wave jumps from one side to the other.
        max_step: StepLimit::new(2 * excursion).unwrap_or(StepLimit::MAX),
        ..room
    };
    let axis = arguments.axes.axis(drive, seen.gear, limits, polls);
    let mut station = Station::new(link, &[axis], cycle_us).map_err(DrivesError::Config)?;
    let scale = arguments.axes.scale(seen.gear);
    let measured = swing(&mut station, arguments, shape, |counts| {
        scale.to_command_counts(counts)
    });
    let (measured, _) = DrivesError::after_shut_down(measured, &mut station)?;
    Ok(measured)
}

fn swing(
    station: &mut Station<'_>,
    arguments: &Arguments,
    shape: WaveShape,
    to_counts: impl Fn(i32) -> Option<i32>,
) -> Result<Measured, DrivesError> {
    hold(station)?;
    let refused = |reason: String| DrivesError::MoveRefused {
        drive: arguments.drive,
        reason,
    };
    let anchor = station
        .master()
        .snapshot(0)
        .map_or(0, |axis| axis.sent_counts);
    let start = station.now();
    let wanted = DriveMove::Wave {
        shape,
        amplitude: amplitude(arguments.amplitude),
        frequency_hz: arguments.frequency.into(),
    };
    let started = station.master().start_move(start, 0, wanted);
    started.map_err(|error| refused(error.to_string()))?;
    let end_us = u64::from(arguments.periods()) * 1_000_000 / u64::from(arguments.frequency);
    let mut samples = Vec::new();
    let mut seen_at: Option<Instant> = None;
    let mut is_complete = false;
    while interrupt::requests() == 0 {
        station.cycle(|_, _| {})?;
        if let Some((drive, fault)) = station.first_fault() {
            return Err(DrivesError::DriveFault { drive, fault });
        }
        let elapsed_us = station.now().us_since(start);
        if elapsed_us >= end_us {
            is_complete = true;
            break;
        }
        let Some(axis) = station.master().snapshot(0) else {
            break;
        };
        let position = axis.feedback.position;
        if let Some(position) = position.filter(|read| Some(read.at) != seen_at)
            && let Some(counts) = to_counts(position.value)
        {
            seen_at = Some(position.at);
            samples.push(Sample {
                at_ms: position.at.us_since(start) as f64 / 1_000.0,
                set_point: 0,
                actual: counts.wrapping_sub(anchor),
            });
        }
    }
    come_back(station)?;
    Ok(Measured {
        samples,
        is_complete,
    })
}

/// Ends the wave, and waits until the drive holds where it began.
fn come_back(station: &mut Station<'_>) -> Result<(), DrivesError> {
    let start = station.now();
    station.master().stop(start, GROUP);
    while station.snapshots().any(|axis| axis.facts.has_own_move())
        && station.now().us_since(start) < END_LIMIT_US
    {
        station.cycle(|_, _| {})?;
        if let Some((drive, fault)) = station.first_fault() {
            return Err(DrivesError::DriveFault { drive, fault });
        }
    }
    until_back(station)
}

/// What a wave of the drive is worth, in numbers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub(crate) struct WaveFigures {
    /// Positions that were read.
    samples: usize,
    /// From one side to the other: between the middle positions of each side of a square wave, between the extremes of a sine.
    swing_counts: i32,
    /// What the drive was told, where its amplitude goes to either side; half of it where the amplitude is the whole swing (D43).
    told_counts: i32,
    /// Of a square wave: beyond a side, in percent of the swing.
    overshoot_percent: Option<f64>,
    /// Of a square wave: from 10 to 90 % of the swing, the slowest time.
    rise_ms: Option<f64>,
    /// By the times at which the axis goes through its middle; `None` where it does so less than twice.
    frequency_hz: Option<f64>,
}

impl WaveFigures {
    pub(super) fn of(samples: &[Sample], shape: WaveShape, told_counts: i32) -> Self {
        let values = || samples.iter().map(|sample| sample.actual);
        let (low, high) = (values().min().unwrap_or(0), values().max().unwrap_or(0));
        let middle = (f64::from(low) + f64::from(high)) / 2.0;
        let is_square = shape == WaveShape::Square;
        let (bottom, top) = if is_square {
            let side = |is_high: bool| {
                median(values().filter(|value| (f64::from(*value) > middle) == is_high))
            };
            (side(false), side(true))
        } else {
            (low, high)
        };
        let swing = f64::from(top) - f64::from(bottom);
        let beyond = f64::from(high.saturating_sub(top).max(bottom.saturating_sub(low)));
        let rises = rises(samples, f64::from(bottom), swing);
        let has_swing = is_square && swing > 0.0;
        Self {
            samples: samples.len(),
            swing_counts: top.saturating_sub(bottom),
            told_counts,
            overshoot_percent: has_swing.then(|| beyond / swing * 100.0),
            rise_ms: rises
                .filter(|_| has_swing)
                .map(|rises| rises.into_iter().fold(0.0, f64::max)),
            frequency_hz: frequency(samples, middle),
        }
    }

    pub(super) const TITLES: [&str; 5] = [
        "swing\ncounts",
        "told\ncounts",
        "overshoot\n%",
        "rise\nms",
        "frequency\nHz",
    ];

    pub(super) fn cells(&self) -> [String; 5] {
        let number = |value: Option<f64>| {
            value.map_or_else(|| "-".to_owned(), |value| format!("{value:.1}"))
        };
        [
            self.swing_counts.to_string(),
            self.told_counts.to_string(),
            number(self.overshoot_percent),
            number(self.rise_ms),
            number(self.frequency_hz),
        ]
    }
}

fn median(values: impl Iterator<Item = i32>) -> i32 {
    let mut values: Vec<i32> = values.collect();
    values.sort_unstable();
    values.get(values.len() / 2).copied().unwrap_or(0)
}

/// Times at which the axis goes up through a level, between two samples.
fn upward(samples: &[Sample], level: f64) -> Vec<f64> {
    let pairs = samples.iter().zip(samples.iter().skip(1));
    let crosses = |(before, after): (&Sample, &Sample)| {
        let (from, to) = (f64::from(before.actual), f64::from(after.actual));
        let share = (level - from) / (to - from);
        (from < level && to >= level).then_some(before.at_ms + share * (after.at_ms - before.at_ms))
    };
    pairs.filter_map(crosses).collect()
}

/// The time of each rise; none where a rise is missing.
fn rises(samples: &[Sample], bottom: f64, swing: f64) -> Option<Vec<f64>> {
    let begins = upward(samples, bottom + 0.1 * swing);
    let ends = upward(samples, bottom + 0.9 * swing);
    // One that swings through the levels again belongs to the rise before.
    let rises = ends.iter().filter_map(|end| {
        let begin = begins.iter().rev().find(|begin| *begin <= end)?;
        Some(end - begin)
    });
    let rises: Vec<f64> = rises.collect();
    (!rises.is_empty()).then_some(rises)
}

fn frequency(samples: &[Sample], middle: f64) -> Option<f64> {
    let times = upward(samples, middle);
    let (first, last) = (times.first()?, times.last()?);
    let periods = times.len() - 1;
    (periods > 0).then(|| periods as f64 / (last - first) * 1_000.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn samples(value: impl Fn(f64) -> f64) -> Vec<Sample> {
        (0..2_000)
            .map(|ms| Sample {
                at_ms: f64::from(ms),
                set_point: 0,
                actual: value(f64::from(ms) / 1_000.0).round() as i32,
            })
            .collect()
    }

    #[test]
    fn a_square_wave_that_overshoots() {
        // 2 Hz, 10 ms from side to side, 10 % beyond for 20 ms.
        let figures = WaveFigures::of(
            &samples(|s| {
                let half = (s * 4.0).floor();
                let ms = (s * 1_000.0) - half * 250.0;
                let side = if half % 2.0 == 0.0 { 1.0 } else { -1.0 };
                side * match ms {
                    ms if ms < 10.0 => -100.0 + 20.0 * ms,
                    ms if ms < 30.0 => 120.0,
                    _ => 100.0,
                }
            }),
            WaveShape::Square,
            200,
        );
        assert_eq!(figures.swing_counts, 200);
        assert!((figures.overshoot_percent.expect("one") - 10.0).abs() < 0.1);
        assert!((figures.rise_ms.expect("one") - 8.0).abs() < 0.1);
        assert!((figures.frequency_hz.expect("one") - 2.0).abs() < 0.01);
    }

    #[test]
    fn a_sine_has_a_swing_and_a_frequency() {
        let sine = |s: f64| 300.0 * (s * 5.0 * core::f64::consts::TAU).sin();
        let figures = WaveFigures::of(&samples(sine), WaveShape::Sine, 600);
        assert_eq!(
            (figures.swing_counts, figures.overshoot_percent),
            (600, None)
        );
        assert!((figures.frequency_hz.expect("one") - 5.0).abs() < 0.01);
        let nothing = WaveFigures::of(&[], WaveShape::Square, 600);
        assert_eq!((nothing.swing_counts, nothing.frequency_hz), (0, None));
    }
}
