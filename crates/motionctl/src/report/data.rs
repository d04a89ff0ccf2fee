//! The numbers of the page.

use serde_json::{Value, json};

use super::pack::{Block, differences, sparse};
use crate::recording::{
    AxisOutcome, AxisSample, Happening, Origin, Outcome, Quantity, Recording, Sample, Sighting,
};

/// Unit of the times of frames.
const FRAME_UNIT_NS: u64 = 100;

/// The block.
pub(super) fn data(recording: &Recording, outcome: &Outcome) -> Value {
    let about = &recording.about;
    let samples = samples(recording);
    let (origin, title) = match about.origin {
        Origin::Simulation => ("simulation", "Simulated run"),
        Origin::Bus => ("bus", "Run on a bus"),
        Origin::Log => ("log", "Log of a bus"),
    };
    let quantity = match about.quantity {
        Quantity::Position => "position",
        Quantity::Speed => "speed",
    };
    let facts = about.facts().into_iter();
    let axes = (0..about.axes.len()).map(|axis| axis_data(recording, outcome, &samples, axis));
    json!({
        "origin": origin,
        "quantity": quantity,
        "title": title,
        "verdict": { "text": outcome.verdict, "good": outcome.is_good },
        "about": facts.collect::<Vec<_>>(),
        "facts": all_facts(recording, outcome),
        "cycleUs": about.cycle_us,
        "bitNs": about.bit_ns,
        "endUs": end_us(recording),
        "motionStart": recording.motion_start,
        "loadIsLeast": about.origin != Origin::Simulation,
        "axes": axes.collect::<Vec<_>>(),
        "samples": sample_data(recording, &samples),
        "deviationsUs": recording.intervals.deviations_us().iter().collect::<Vec<_>>(),
        "events": recording.happenings.iter().map(event).collect::<Vec<_>>(),
        "eventsLeftOut": recording.happenings_left_out,
        "texts": recording.frames.texts(),
        "frames": frames(recording.frames.sightings()),
        "framesForgotten": recording.frames.forgotten(),
    })
}

/// The samples, and the newest cycle behind them.
fn samples(recording: &Recording) -> Vec<&Sample> {
    let newest = recording.latest.iter().filter(|newest| {
        let last = recording.samples.last();
        last.is_none_or(|last| last.number < newest.number || last.at_us < newest.at_us)
    });
    recording.samples.iter().chain(newest).collect()
}

/// The end of everything that is shown.
fn end_us(recording: &Recording) -> u64 {
    let cycles = recording.latest.as_ref().map(|sample| sample.at_us);
    let frames = recording.frames.sightings().last();
    let events = recording.happenings.last().map(|event| event.at_us);
    let ends = [cycles, frames.map(|frame| frame.start_ns / 1_000), events];
    ends.into_iter().flatten().max().unwrap_or(0)
}

fn all_facts(recording: &Recording, outcome: &Outcome) -> Vec<String> {
    let mut facts = outcome.facts.clone();
    if recording.cycles_a_sample > 1 {
        facts.push(format!(
            "A long run: each point of a curve stands for {} cycles, and is the one of them with the largest following error; --csv and --mcap keep every cycle.",
            recording.cycles_a_sample
        ));
    }
    facts
}

fn sample_data(recording: &Recording, samples: &[&Sample]) -> Value {
    let whole = |number: u64| i64::try_from(number).unwrap_or(i64::MAX);
    let late = (0_usize..)
        .zip(samples)
        .filter(|(_, sample)| sample.is_late);
    json!({
        "count": samples.len(),
        "cycles": recording.cycles,
        "cyclesASample": recording.cycles_a_sample,
        "timesUs": differences(samples.iter().map(|sample| whole(sample.at_us))),
        "numbers": differences(samples.iter().map(|sample| whole(sample.number))),
        "loadPermille": differences(samples.iter().map(|sample| (1_000.0 * sample.load).round() as i64)),
        "late": late.map(|(place, _)| place).collect::<Vec<_>>(),
    })
}

fn axis_data(recording: &Recording, outcome: &Outcome, samples: &[&Sample], axis: usize) -> Value {
    let about = &recording.about.axes[axis];
    let empty = AxisOutcome::default();
    let end = outcome.axes.get(axis).unwrap_or(&empty);
    let knows_targets = recording.about.origin != Origin::Log;
    // Polls run from the begin of the motion on.
    let start_us = recording.motion_start.map_or(0, |(at_us, _)| at_us);
    let of_axis = || {
        samples
            .iter()
            .filter_map(|sample| Some((sample.at_us, sample.axes.get(axis)?)))
    };
    let values = |value: fn(&AxisSample) -> i64| differences(of_axis().map(|(_, of)| value(of)));
    let ages = |age: fn(&AxisSample) -> Option<u32>| {
        sparse(of_axis().map(|(at_us, of)| age(of).filter(|_| at_us >= start_us).map(i64::from)))
    };
    json!({
        "name": about.name,
        "drive": about.drive,
        "unit": about.unit,
        "countsPerUnit": about.counts_per_unit,
        "start": about.start,
        "setPoints": end.set_points,
        "receivedCounts": end.received_counts,
        "replyTimeouts": end.reply_timeouts,
        "state": end.state,
        "target": knows_targets.then(|| values(|of| of.target.into())),
        "sent": values(|of| of.sent.into()),
        "position": sparse(of_axis().map(|(_, of)| of.position)),
        "statusAgeUs": ages(|of| of.status_age_us),
        "positionAgeUs": ages(|of| of.position_age_us),
    })
}

/// Time, axis, kind, words, how often.
fn event(event: &Happening) -> Value {
    json!([
        event.at_us,
        event.axis,
        event.kind.name(),
        event.text,
        event.times
    ])
}

/// For each frame: time since the start of the frame before, length in bits, number of its text.
fn frames<'a>(frames: impl Iterator<Item = &'a Sighting>) -> String {
    let (mut block, mut before) = (Block::default(), 0_i64);
    for frame in frames {
        let start = i64::try_from(frame.start_ns / FRAME_UNIT_NS).unwrap_or(i64::MAX);
        block.push_signed(start - before);
        block.push(u64::from(frame.bits));
        block.push(frame.text as u64);
        before = start;
    }
    block.text()
}
