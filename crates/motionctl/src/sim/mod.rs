//! `motionctl sim`: a motion from a file on simulated drives.

mod arguments;
mod axis_summary;
mod bench;
mod error;
mod faults;
mod live;
mod outcome;
mod setup;
mod spectator;
mod summary;
mod watch;
mod wheels;

use std::path::Path;
use std::process::ExitCode;

use crate::exit;
use crate::output::{self, tell};
use crate::recording::{
    About, Origin, Recorded, Recorder, Recording, RecordingReport, WithRecording,
};
use crate::report;
use crate::trajectory::{MotionReport, Plan, WithMotion};
pub(crate) use arguments::Arguments;
use bench::Bench;
use error::SimError;
use live::LiveView;
use outcome::outcome;
use setup::Setup;
use spectator::Nobody;
use summary::Summary;

/// Checks everything, runs the motion, prints the summary.
pub(crate) fn run(arguments: &Arguments) -> Result<ExitCode, SimError> {
    if let Some(nodes) = arguments.motion.hub_motors() {
        return wheels::run(arguments, nodes);
    }
    if arguments.twist.twist.is_some() {
        return Err(SimError::NotForServos { option: "--twist" });
    }
    let motion = arguments.motion.read().map_err(SimError::Motion)?;
    let setup = arguments.setup(&motion)?;
    let plan = motion
        .plan(setup.cycle_us, setup.max_step)
        .map_err(SimError::Motion)?;
    let axes = motion.axes_about(&setup.drives).map_err(SimError::Motion)?;
    let about = About {
        seed: Some(setup.drive_options.seed()),
        ..About::now(
            Origin::Simulation,
            axes,
            setup.cycle_us,
            setup.bit_rate.bit_ns(),
        )
    };
    let input: Vec<&Path> = arguments.motion.file().into_iter().collect();
    let recorder = arguments
        .recording
        .open(&about, &input)
        .map_err(SimError::Recording)?;
    let picture = arguments
        .motion
        .path_picture(&plan, arguments.recording.report.is_some())
        .map_err(SimError::Motion)?;
    let motion = motion
        .report(&plan, &setup.drives, setup.max_step)
        .map_err(SimError::Motion)?;
    if !arguments.json {
        motion.show();
    }
    let (summary, recorded) = simulate(arguments, setup, recorder, &about, &plan)?;
    if let (Some(recording), Some(folder)) = (&recorded.recording, &arguments.recording.report) {
        let page = report::write(folder, recording, &outcome(&summary), picture.as_deref());
        let page = page.map_err(|(path, source)| SimError::Write { path, source })?;
        tell(format_args!("report: {}", page.display()));
    }
    print(arguments, &motion, &summary, &recorded.report)?;
    Ok(
        if summary.promises_kept() && recorded.report.is_complete() {
            ExitCode::SUCCESS
        } else {
            exit::BROKEN_PROMISE.into()
        },
    )
}

/// Runs the motion, with the live view or without.
fn simulate(
    arguments: &Arguments,
    setup: Setup,
    mut recorder: Recorder,
    about: &About,
    plan: &Plan,
) -> Result<(Summary, Recorded), SimError> {
    if arguments.live {
        if recorder.model().is_none() {
            recorder.keep_model(Recording::new(about.clone()));
        }
        let motion_us = plan.cycles() as u64 * u64::from(setup.cycle_us);
        let mut view = LiveView::open(setup.drives.len(), motion_us, true)?;
        Bench::new(setup, recorder, &mut view)?.run(plan, false)
    } else {
        Bench::new(setup, recorder, &mut Nobody)?.run(plan, !arguments.json)
    }
}

fn print(
    arguments: &Arguments,
    motion: &MotionReport,
    summary: &Summary,
    recording: &RecordingReport,
) -> Result<(), SimError> {
    if arguments.json {
        let result = &WithRecording {
            result: summary,
            recording,
        };
        output::print_json(&WithMotion { motion, result }).map_err(SimError::Print)?;
    } else {
        output::print(summary).map_err(SimError::Print)?;
    }
    Ok(())
}
