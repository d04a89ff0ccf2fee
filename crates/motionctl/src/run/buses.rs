//! The buses of a motion, from open links to summaries.

use std::process::ExitCode;
use std::sync::Arc;

use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::Arguments;
use super::error::RunError;
use super::follow::{Follow, places};
use super::recording::RunRecording;
use super::summary::Summary;
use super::together::{Leader, Part, Together};
use super::{Axis, admit, configs, look_at};
use crate::control::Wishes;
use crate::link::{Link, OpenBus};
use crate::live_view::BusView;
use crate::output::{print, print_json};
use crate::recording::Recorded;
use crate::set_points::SetPointSource;
use crate::station::{Seen, Station};
use crate::stream::StreamReport;
use crate::trajectory::MotionReport;

/// A bus and the axes on it.
pub(super) struct Bus {
    pub(super) link: Link,
    pub(super) name: String,
    /// The network interface, when it is one.
    pub(super) interface: Option<String>,
    pub(super) axes: Vec<Axis>,
    /// Until the bus is ready to follow.
    pub(super) recording: Option<RunRecording>,
}

/// Opens the links and gives each its axes, in the order of the columns.
pub(super) fn open(arguments: &Arguments, axes: Vec<Axis>) -> Result<Vec<Bus>, RunError> {
    let mut axes = axes.into_iter();
    let mut bus = |OpenBus {
                       link,
                       name,
                       interface,
                       axes: count,
                   }| Bus {
        link,
        name,
        interface,
        axes: axes.by_ref().take(count.unwrap_or(usize::MAX)).collect(),
        recording: None,
    };
    let open = arguments.link.open().map_err(RunError::Open)?;
    Ok(open.into_iter().map(&mut bus).collect())
}

/// Refuses what a bus cannot carry.
pub(super) fn admit_all(arguments: &Arguments, buses: &mut [Bus]) -> Result<(), RunError> {
    for bus in buses {
        admit(arguments, &mut bus.link, &bus.axes)?;
    }
    Ok(())
}

/// The buses, asked and ready to follow, and the view of the only one when it is wanted.
pub(super) fn ready<'link>(
    arguments: &Arguments,
    buses: &'link mut [Bus],
    wishes: &Wishes,
) -> Result<(Vec<Follow<'link>>, Option<BusView>), RunError> {
    let together = (buses.len() > 1).then(|| Arc::new(Together::new(buses.len())));
    let seen = look_at_all(arguments, buses)?;
    let mut view = None;
    let follow = |(bus, seen): (&'link mut Bus, Vec<Seen>)| {
        let configs = configs(arguments, &bus.axes, |drive| {
            let seen = seen.iter().find(|seen| seen.drive == drive);
            seen.map_or(0, |seen| seen.position_counts)
        });
        let mut station =
            Station::new(&mut bus.link, &configs, arguments.cycle_us).map_err(RunError::Config)?;
        let drives: Vec<_> = bus.axes.iter().map(|axis| axis.drive).collect();
        let read_back = bus.axes.iter().map(|axis| arguments.axes.scale(axis.gear));
        let read_back: Vec<_> = read_back.collect();
        if let Some(recording) = bus.recording.take() {
            view = recording.attach(
                arguments,
                &mut station,
                &places(&drives),
                &read_back,
                wishes,
            )?;
        }
        let axes = drives.into_iter().zip(read_back).collect();
        let (name, together) = (bus.name.clone(), together.clone());
        Ok(Follow::new(station, axes, name, together))
    };
    let follows: Result<Vec<_>, RunError> = buses.iter_mut().zip(seen).map(follow).collect();
    Ok((follows?, view))
}

/// Asks the drives of every bus; when they cannot be used, the recordings end with the frames that say why.
fn look_at_all(arguments: &Arguments, buses: &mut [Bus]) -> Result<Vec<Vec<Seen>>, RunError> {
    let seen = buses
        .iter_mut()
        .map(|bus| look_at(arguments, &mut bus.link, &bus.axes));
    let seen: Result<_, _> = seen.collect();
    if seen.is_err() {
        for bus in buses {
            if let Some(recording) = bus.recording.take() {
                recording.give_up(&mut bus.link);
            }
        }
    }
    seen
}

/// Runs the motion on every bus.
pub(super) fn follow_all(
    mut follows: Vec<Follow<'_>>,
    source: &mut dyn SetPointSource,
    wishes: &Wishes,
    show_progress: bool,
) -> Vec<(Summary, Recorded)> {
    let rest = follows.split_off(1);
    let Some(first) = follows.pop() else {
        return Vec::new();
    };
    let Some(together) = first.together() else {
        return vec![first.run(source, wishes, show_progress)];
    };
    std::thread::scope(|scope| {
        let mut from = first.axes();
        let threads: Vec<_> = rest
            .into_iter()
            .map(|follow| {
                let own = from..from + follow.axes();
                from = own.end;
                let mut part = Part::new(Arc::clone(&together), own);
                scope.spawn(move || follow.run(&mut part, &Wishes::new(), false))
            })
            .collect();
        let own = 0..first.axes();
        let mut leader = Leader::new(source, Arc::clone(&together), own);
        let mut summaries = vec![first.run(&mut leader, wishes, show_progress)];
        for thread in threads {
            match thread.join() {
                Ok(summary) => summaries.push(summary),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        summaries
    })
}

/// Everything that came of a motion.
#[derive(Serialize, JsonSchema)]
struct Outcome<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    motion: Option<&'a MotionReport>,
    #[serde(skip_serializing_if = "Option::is_none")]
    stream: Option<&'a StreamReport>,
    #[serde(flatten)]
    on: On<'a>,
}

#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
enum On<'a> {
    One(&'a Summary),
    Several { buses: &'a [Summary] },
}

/// Prints what came of a motion; the worst of its buses decides the exit status.
pub(super) fn show(
    arguments: &Arguments,
    summaries: &[Summary],
    motion: Option<&MotionReport>,
    stream: Option<&StreamReport>,
) -> Result<ExitCode, RunError> {
    let on = match summaries {
        [one] => On::One(one),
        buses => On::Several { buses },
    };
    if arguments.json {
        let result = Outcome { motion, stream, on };
        print_json(&result).map_err(RunError::Print)?;
    } else {
        for summary in summaries {
            print(summary).map_err(RunError::Print)?;
        }
        if let Some(stream) = stream {
            print(stream).map_err(RunError::Print)?;
        }
    }
    let worst = summaries
        .iter()
        .max_by_key(|summary| summary.ending.severity());
    Ok(worst.map_or(ExitCode::SUCCESS, |summary| summary.ending.exit_code()))
}

/// The shape of what `--json` prints.
pub(super) fn schema() -> schemars::Schema {
    crate::schema::of::<Outcome<'_>>()
}
