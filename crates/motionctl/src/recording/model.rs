//! The record of a run in memory, for the page and the live view: limited, however long the run is.

use std::io;

use super::about::{About, AxisAbout};
use super::event::Happening;
use super::frames::Frames;
use super::intervals::Intervals;
use super::item::Item;
use super::keep::Keep;
use super::sample::{AxisSample, Sample};

/// Samples of all axes together that are kept: three minutes of eight axes at 1 kHz.
const MOST_AXIS_SAMPLES: usize = 1_500_000;
/// Events that are kept; later ones are counted.
const MOST_HAPPENINGS: usize = 20_000;

/// The record of a run.
#[derive(Debug)]
pub(crate) struct Recording {
    pub(crate) about: About,
    /// In the order of time. In a long run each stands for several cycles: it is the one with the largest following error, or one
    /// that was late.
    pub(crate) samples: Vec<Sample>,
    /// Cycles for which one sample stands: 1, and twice as many each time the memory is full.
    pub(crate) cycles_a_sample: u64,
    /// Cycles since the last sample began to stand for more than itself.
    in_group: u64,
    /// The newest cycle, whether or not it is among the samples.
    pub(crate) latest: Option<Sample>,
    /// The newest position of each axis that is known, and the following error then.
    pub(crate) known_positions: Vec<Option<(i64, i64)>>,
    pub(crate) cycles: u64,
    pub(crate) late_cycles: u64,
    pub(crate) happenings: Vec<Happening>,
    pub(crate) happenings_left_out: u64,
    /// When the motion began, and with which cycle; no set-point is sent before.
    pub(crate) motion_start: Option<(u64, u64)>,
    pub(crate) frames: Frames,
    pub(crate) intervals: Intervals,
    most_samples: usize,
}

impl Recording {
    pub(crate) fn new(about: About) -> Self {
        Self {
            intervals: Intervals::new(about.axes.iter().map(|axis| axis.set_point_id)),
            frames: Frames::new(about.quantity),
            most_samples: most_samples(about.axes.len()),
            known_positions: vec![None; about.axes.len()],
            about,
            samples: Vec::new(),
            cycles_a_sample: 1,
            in_group: 0,
            latest: None,
            cycles: 0,
            late_cycles: 0,
            happenings: Vec::new(),
            happenings_left_out: 0,
            motion_start: None,
        }
    }

    /// What an axis is called in events: by the drive that the user knows.
    pub(crate) fn name(&self, axis: usize) -> String {
        self.about.axes.get(axis).map_or_else(
            || format!("axis {axis}"),
            |about| format!("{} {}", self.about.quantity.drive_word(), about.drive),
        )
    }

    /// Time of the newest cycle in seconds.
    pub(crate) fn end_s(&self) -> f64 {
        self.latest
            .as_ref()
            .map_or(0.0, |sample| sample.at_us as f64 * 1e-6)
    }

    /// Adds what comes next.
    pub(crate) fn add(&mut self, item: &Item) {
        match item {
            Item::Cycle(sample) => self.cycle(sample),
            Item::Frame(frame) => {
                self.intervals.frame(frame, self.about.cycle_us);
                self.frames.push(frame);
            }
            Item::Event(happening) => self.happened(happening),
            Item::MotionBegins { at_us, number } => self.motion_start = Some((*at_us, *number)),
            Item::Naming(naming) => {
                for (axis, naming) in self.about.axes.iter_mut().zip(naming) {
                    *axis = axis.clone().named(naming.clone());
                }
            }
        }
    }

    /// One more axis, of which nothing was recorded until now.
    pub(crate) fn add_axis(&mut self, axis: AxisAbout) {
        self.intervals.add(axis.set_point_id);
        self.about.axes.push(axis);
        self.known_positions.push(None);
        self.most_samples = most_samples(self.about.axes.len());
    }

    /// Sorts the axes by their drives, and gives every sample all of them: before its first one an axis stood where that has it.
    pub(crate) fn even_out(&mut self) {
        let mut order: Vec<usize> = (0..self.about.axes.len()).collect();
        order.sort_by_key(|&axis| self.about.axes[axis].drive);
        let first = |axis: usize| {
            let mut samples = self.samples.iter().chain(&self.latest);
            let first = samples.find_map(|sample| sample.axes.get(axis));
            first.map(|first| AxisSample {
                position: None,
                ..*first
            })
        };
        let firsts: Vec<Option<AxisSample>> = (0..order.len()).map(first).collect();
        for sample in self.samples.iter_mut().chain(&mut self.latest) {
            let all = order.iter().filter_map(|&axis| {
                let known = sample.axes.get(axis).copied();
                known.or_else(|| firsts.get(axis).copied().flatten())
            });
            sample.axes = all.collect();
        }
        let place = |axis: usize| order.iter().position(|&other| other == axis);
        for happening in &mut self.happenings {
            happening.axis = happening.axis.and_then(place);
        }
        self.about.axes = order
            .iter()
            .map(|&axis| self.about.axes[axis].clone())
            .collect();
    }

    /// Adds counts to every set-point of an axis, when it shows late where it stood.
    pub(crate) fn shift(&mut self, axis: usize, counts: i32) {
        for sample in self.samples.iter_mut().chain(&mut self.latest) {
            if let Some(axis) = sample.axes.get_mut(axis) {
                axis.sent = axis.sent.wrapping_add(counts);
                axis.target = axis.target.wrapping_add(counts);
            }
        }
    }

    /// Takes the usual interval of the set-points for the cycle.
    pub(crate) fn recognise_cycle(&mut self) {
        let interval_us = self.intervals.median_us().unwrap_or(0);
        let interval_us = interval_us + i64::from(self.about.cycle_us);
        // To 10 us: clocks of adapters are no better.
        let cycle_us = u32::try_from((interval_us + 5) / 10 * 10).unwrap_or(0);
        if cycle_us > 0 {
            self.intervals.set_cycle(self.about.cycle_us, cycle_us);
            self.about.cycle_us = cycle_us;
        }
    }

    /// Forgets what a view does not show any more: everything but the newest `window_us` and the newest events.
    pub(crate) fn forget_before(&mut self, window_us: u64, happenings: usize) {
        let from_us = self
            .latest
            .as_ref()
            .map_or(0, |sample| sample.at_us.saturating_sub(window_us));
        let old = self
            .samples
            .partition_point(|sample| sample.at_us < from_us);
        // Not one by one, which would move all others each time.
        if old > self.samples.len() / 2 {
            self.samples.drain(..old);
        }
        if self.happenings.len() > 2 * happenings {
            let old = self.happenings.len() - happenings;
            self.happenings.drain(..old);
        }
    }

    fn cycle(&mut self, sample: &Sample) {
        self.cycles += 1;
        self.late_cycles += u64::from(sample.is_late);
        for (known, axis) in self.known_positions.iter_mut().zip(&sample.axes) {
            *known = axis.position.zip(axis.error()).or(*known);
        }
        self.latest = Some(sample.clone());
        match self.samples.last_mut() {
            Some(last) if self.in_group < self.cycles_a_sample => {
                self.in_group += 1;
                if weight(sample) > weight(last) {
                    *last = sample.clone();
                }
            }
            _ => {
                self.samples.push(sample.clone());
                self.in_group = 1;
            }
        }
        if self.samples.len() >= self.most_samples && self.in_group == self.cycles_a_sample {
            self.halve();
        }
    }

    /// Of each two samples the heavier one stays.
    fn halve(&mut self) {
        let before = core::mem::take(&mut self.samples);
        let count = before.len();
        let mut pairs = before.into_iter();
        while let Some(first) = pairs.next() {
            let heavier = match pairs.next() {
                Some(second) if weight(&second) > weight(&first) => second,
                _ => first,
            };
            self.samples.push(heavier);
        }
        if count % 2 == 1 {
            self.in_group = self.cycles_a_sample;
        } else {
            self.in_group = 2 * self.cycles_a_sample;
        }
        self.cycles_a_sample *= 2;
    }

    fn happened(&mut self, happening: &Happening) {
        // A controller that is bus-off says so every cycle.
        if let Some(last) = self.happenings.last_mut()
            && (last.axis, last.kind, &last.text)
                == (happening.axis, happening.kind, &happening.text)
        {
            last.times = last.times.saturating_add(happening.times);
        } else if self.happenings.len() < MOST_HAPPENINGS {
            self.happenings.push(happening.clone());
        } else {
            self.happenings_left_out += u64::from(happening.times);
        }
    }
}

fn most_samples(axes: usize) -> usize {
    (MOST_AXIS_SAMPLES / axes.max(1)).max(2)
}

/// What matters in a sample: that it was late, that it has a position at all, its following error.
fn weight(sample: &Sample) -> (bool, bool, u64) {
    let has_position = sample.axes.iter().any(|axis| axis.position.is_some());
    (sample.is_late, has_position, sample.largest_error())
}

impl Keep for Recording {
    fn keep(&mut self, item: &Item) -> io::Result<()> {
        self.add(item);
        Ok(())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }

    fn finish(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::about::{AxisAbout, Origin};
    use super::super::sample::AxisSample;
    use super::*;
    use dyn_can::DriveId;
    use proptest::prelude::*;

    fn recording(most_samples: usize) -> Recording {
        let axes = DriveId::all().take(1).map(AxisAbout::of_drive).collect();
        Recording {
            most_samples,
            ..Recording::new(About::now(Origin::Bus, axes, 1_000, 1_000))
        }
    }

    fn sample(number: u64, error: i64) -> Sample {
        Sample {
            at_us: number * 1_000,
            number,
            load: 0.1,
            is_late: false,
            axes: vec![AxisSample {
                target: 0,
                sent: 0,
                position: Some(-error),
                backlog: 0,
                status_age_us: None,
                position_age_us: None,
                state: None,
            }],
            wheels: Vec::new(),
        }
    }

    #[test]
    fn a_spike_of_one_cycle_survives_any_length() {
        let mut recording = recording(100);
        for number in 0..100_000 {
            let error = if number == 56_789 { 7 } else { 0 };
            recording.add(&Item::Cycle(sample(number, error)));
        }
        assert!(recording.samples.len() <= 100);
        assert_eq!(recording.cycles, 100_000);
        assert!(recording.samples.contains(&sample(56_789, 7)));
        assert_eq!(recording.latest, Some(sample(99_999, 0)));
        assert!(recording.samples.len() as u64 * recording.cycles_a_sample >= 100_000);
    }

    #[test]
    fn what_is_said_again_and_again_is_counted() {
        let mut recording = recording(10);
        for at_us in [1, 2, 3] {
            recording.add(&Item::Event(Happening {
                at_us,
                axis: None,
                kind: super::super::event::Kind::Notice,
                text: "bus-off".to_owned(),
                times: 1,
            }));
        }
        assert_eq!(recording.happenings.len(), 1);
        assert_eq!(recording.happenings[0].to_string(), "bus-off (3 times)");
    }

    proptest! {
        #[test]
        fn every_sample_is_one_of_its_group_and_none_of_it_is_heavier(
            errors in prop::collection::vec(-1_000_i64..1_000, 1..600),
            most in 2_usize..50,
        ) {
            let mut recording = recording(most);
            for (number, error) in errors.iter().enumerate() {
                recording.add(&Item::Cycle(sample(number as u64, *error)));
            }
            let size = recording.cycles_a_sample;
            prop_assert!(recording.samples.is_sorted_by(|a, b| a.number < b.number));
            for group in errors.chunks(size as usize).zip(&recording.samples) {
                let most = group.0.iter().map(|error| error.unsigned_abs()).max();
                prop_assert_eq!(Some(group.1.largest_error()), most);
            }
            prop_assert_eq!(recording.samples.len(), errors.len().div_ceil(size as usize));
        }
    }
}
