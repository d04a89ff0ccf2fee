//! The buses of a simulation, from their files to their summaries.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use schemars::JsonSchema;
use serde::Serialize;

use super::arguments::Arguments;
use super::bench::{Bench, Run};
use super::error::SimError;
use super::live::LiveView;
use super::outcome::outcome;
use super::setup::Setup;
use super::spectator::Nobody;
use super::summary::Summary;
use crate::exit;
use crate::output::{self, tell};
use crate::recording::{
    About, AxisAbout, Origin, Recorded, Recorder, Recording, RecordingOptions, RecordingReport,
    WithRecording,
};
use crate::report;
use crate::schema::Either;
use crate::trajectory::{MotionReport, Plan, WithMotion};

/// A bus that is ready to run.
pub(super) struct Bus {
    setup: Setup,
    about: About,
    recorder: Recorder,
    /// Where its page goes.
    folder: Option<PathBuf>,
}

/// What came of a bus.
pub(super) struct BusResult {
    name: String,
    summary: Summary,
    recorded: Recorded,
    folder: Option<PathBuf>,
}

impl BusResult {
    fn with_recording(&self) -> WithRecording<'_, Summary> {
        WithRecording {
            result: &self.summary,
            recording: &self.recorded.report,
        }
    }
}

/// Opens every file of every bus before a run for whose results there would be no place.
pub(super) fn open(
    arguments: &Arguments,
    setups: Vec<Setup>,
    axes: Vec<AxisAbout>,
) -> Result<Vec<Bus>, SimError> {
    let options: Vec<RecordingOptions> = setups
        .iter()
        .map(|setup| match setup.bus.as_str() {
            "" => arguments.recording.clone(),
            name => arguments.recording.named_apart(name),
        })
        .collect();
    // No recording is written over another, or over the motion itself.
    let mut taken: Vec<&Path> = arguments.motion.file().into_iter().collect();
    let mut axes = axes.into_iter();
    let mut buses = Vec::new();
    for (setup, options) in setups.into_iter().zip(&options) {
        let own = axes.by_ref().take(setup.drives.len()).collect();
        let bit_ns = setup.bit_rate.bit_ns();
        let mut about = About {
            seed: Some(setup.drive_options.seed()),
            ..About::now(Origin::Simulation, own, setup.cycle_us, bit_ns)
        };
        if !setup.bus.is_empty() {
            about.interface.clone_from(&setup.bus);
        }
        let recorder = options.open(&about, &taken).map_err(SimError::Recording)?;
        taken.extend(options.files());
        buses.push(Bus {
            setup,
            about,
            recorder,
            folder: options.report.clone(),
        });
    }
    Ok(buses)
}

/// Runs the motion, with the live view or without.
pub(super) fn run(
    arguments: &Arguments,
    mut buses: Vec<Bus>,
    plan: &Plan,
) -> Result<Vec<BusResult>, SimError> {
    let places: Vec<_> = buses
        .iter_mut()
        .map(|bus| (bus.setup.bus.clone(), bus.folder.take()))
        .collect();
    let results = match (arguments.live, buses.pop()) {
        // One bus alone has a view.
        (true, Some(mut bus)) => {
            if bus.recorder.model().is_none() {
                bus.recorder.keep_model(Recording::new(bus.about));
            }
            let motion_us = plan.cycles() as u64 * u64::from(bus.setup.cycle_us);
            let mut view = LiveView::open(bus.setup.drives.len(), motion_us, true)?;
            let bench = Bench::new(bus.setup, bus.recorder, &mut view)?;
            Run::new(vec![bench]).run(plan, false)?
        }
        (_, last) => {
            buses.extend(last);
            let mut nobody: Vec<Nobody> = buses.iter().map(|_| Nobody).collect();
            let benches = buses.into_iter().zip(&mut nobody);
            let benches: Result<Vec<Bench<'_>>, SimError> = benches
                .map(|(bus, nobody)| Bench::new(bus.setup, bus.recorder, nobody))
                .collect();
            Run::new(benches?).run(plan, !arguments.json)?
        }
    };
    let results = results.into_iter().zip(places);
    Ok(results
        .map(|((summary, recorded), (name, folder))| BusResult {
            name,
            summary,
            recorded,
            folder,
        })
        .collect())
}

/// One of several buses, in JSON.
#[derive(Serialize, JsonSchema)]
struct NamedBus<'a> {
    bus: &'a str,
    #[serde(flatten)]
    result: WithRecording<'a, Summary>,
}

#[derive(Serialize, JsonSchema)]
struct Several<'a> {
    buses: Vec<NamedBus<'a>>,
}

/// Writes the pages, and prints what came of the motion.
pub(super) fn show(
    arguments: &Arguments,
    motion: &MotionReport,
    results: &[BusResult],
) -> Result<ExitCode, SimError> {
    for result in results {
        if let (Some(recording), Some(folder)) = (&result.recorded.recording, &result.folder) {
            let page = report::write(folder, recording, &outcome(&result.summary));
            let page = page.map_err(|(path, source)| SimError::Write { path, source })?;
            tell(format_args!("report: {}", page.display()));
        }
    }
    if arguments.json {
        print_json(motion, results)?;
    } else {
        for BusResult { name, summary, .. } in results {
            if name.is_empty() {
                output::print(summary).map_err(SimError::Print)?;
            } else {
                output::print(format_args!("bus {name}\n{summary}")).map_err(SimError::Print)?;
            }
        }
    }
    let is_good = |report: &RecordingReport, summary: &Summary| {
        summary.promises_kept() && report.is_complete()
    };
    let mut results = results.iter();
    Ok(
        if results.all(|result| is_good(&result.recorded.report, &result.summary)) {
            ExitCode::SUCCESS
        } else {
            exit::BROKEN_PROMISE.into()
        },
    )
}

fn print_json(motion: &MotionReport, results: &[BusResult]) -> Result<(), SimError> {
    let printed = match results {
        [only] if only.name.is_empty() => {
            let result = &only.with_recording();
            output::print_json(&WithMotion { motion, result })
        }
        buses => {
            let buses = buses.iter().map(|bus| NamedBus {
                bus: &bus.name,
                result: bus.with_recording(),
            });
            let result = &Several {
                buses: buses.collect(),
            };
            output::print_json(&WithMotion { motion, result })
        }
    };
    printed.map(drop).map_err(SimError::Print)
}

/// The shape of what `--json` prints: of the only bus, or of several.
pub(super) fn schema() -> schemars::Schema {
    type One<'a> = WithMotion<'a, WithRecording<'a, Summary>>;
    crate::schema::of::<Either<One<'_>, WithMotion<'_, Several<'_>>>>()
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use super::*;
    use crate::sim::faults::Script;

    #[derive(clap::Parser)]
    struct Cli {
        #[command(flatten)]
        arguments: Arguments,
    }

    #[test]
    fn a_fault_on_one_bus_stops_the_other_one() {
        // The built-in motion has four axes and lasts six seconds.
        let words = ["sim", "--bus", "a=1,2", "--bus", "b=1,2", "--json"];
        let Cli { arguments } = Cli::parse_from(words);
        let motion = arguments.motion.read().unwrap();
        let mut setups = arguments.setups(&motion).unwrap();
        let script = "[[alarm]]\nat_s = 1.0\ndrive = 1\nalarm = \"over-current\"\n";
        setups[1].faults = Script::parse(script, &setups[1].drives).unwrap();
        let plan = motion
            .plan(arguments.servo_cycle_us(), arguments.most_step().unwrap())
            .unwrap();
        let drives = setups.iter().flat_map(|setup| setup.drives.clone());
        let axes = motion.axes_about(&drives.collect::<Vec<_>>()).unwrap();
        let buses = open(&arguments, setups, axes).unwrap();
        let results = run(&arguments, buses, &plan).unwrap();
        assert!(results[1].summary.faults > 0);
        assert_eq!(results[0].summary.faults, 0);
        let summary = &results[0].summary;
        assert!(!summary.promises_kept, "it did not get to its end");
        assert!(summary.cycles < 2_000, "{}", summary.cycles);
        for axis in &summary.axes {
            // Its books agree: it was slowed down, not cut off.
            assert_eq!(i64::from(axis.sent_counts), axis.received_counts);
            assert_ne!(axis.sent_counts, axis.target_counts);
            assert_eq!(axis.state, "holding");
        }
    }
}
